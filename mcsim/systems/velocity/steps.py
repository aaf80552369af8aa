"""Steps of a velocity scenario's runs and rest; refuses those that cannot be simulated."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.sensors.schedule import Schedule, schedule_of
from mcsim.systems.velocity.raw_output import raw_errors
from mcsim.systems.velocity.scenario import VelocityScenario

#: Steps of all runs of a group, and of one run, whose arrays fit in memory (some 2 GB).
_MOST_STEPS, _MOST_OF_A_RUN = 20_000_000, 2_000_000
#: Samples of a group, and entries of its runs' covariances, that fit in memory where every
#: sample is measured.
_MOST_MEASURED, _MOST_COVARIANCES = 1_000_000, 5_000_000


def scheduled(model: VelocityScenario, folder: Path) -> Schedule:
    """When the samples of a run are taken, and what the integration knows of it.

    Raises
    ------
    InputError
        Recorded stamps that do not fit the run, or a bandwidth beside intervals that vary.
    """
    sensor, duration = model.sensor, model.trajectory.duration
    intervals = model.reconstruction.intervals
    plan = schedule_of(sensor.time, intervals, sensor.rate, duration, folder, "sensor")
    uneven = plan.instants is not None and not plan.instants.even
    if uneven and any(raw_errors(model).filters):
        raise InputError(
            "sensor.accelerometer: what a filter makes of samples at intervals that are not "
            "those of `sensor.rate` is not simulated here; leave it out, or `sensor.time`"
        )
    return plan


def reported_steps(model: VelocityScenario, times: NDArray[np.float64]) -> NDArray[np.int64]:
    """Steps (k,) until the samples at ``times`` (n + 1,) that are nearest the instants asked for.

    Raises
    ------
    InputError
        Two instants have the same nearest sample.
    """
    asked = model.reported
    middles = 0.5 * (times[:-1] + times[1:])
    steps = np.maximum(np.searchsorted(middles, asked), 1)
    same = np.flatnonzero(np.diff(steps) == 0)
    if len(same):
        one, two = asked[same[0]], asked[same[0] + 1]
        raise InputError(f"instants: {one:g} s and {two:g} s have the same nearest sample")
    return steps.astype(np.int64)


def step_count(model: VelocityScenario, folder: Path = Path()) -> int:
    """Steps of a run.

    Raises
    ------
    InputError
        An instant earlier than the first sample, or an absurdly long run.
    """
    plan = scheduled(model, folder)
    rate = model.sensor.rate
    if model.trajectory.rest * rate < 1.0 - 1e-9:
        raise InputError(
            f"trajectory.rest: {model.trajectory.rest:g} s hold no sample; the initial tilt needs "
            f"at least one sampling interval, {1.0 / rate:.4g} s"
        )
    for instant in model.instants or ():
        steps = instant * rate
        if abs(steps - round(steps)) > 1e-6 * max(steps, 1.0):
            raise InputError(
                f"instants: {instant:g} s is not a multiple of the sampling interval; the nearest "
                f"are {math.floor(steps) / rate:.6g} s and {math.ceil(steps) / rate:.6g} s"
            )
    if steps_until(model.reported[0], rate) < 1:
        raise InputError(
            f"sensor.rate: {model.reported[0]:g} s after the start is less than one sampling "
            f"interval; use a rate above {1.0 / model.reported[0]:.4g} Hz"
        )
    n = steps_until(model.trajectory.duration, rate)
    n = n if plan.instants is None else plan.instants.last
    if n > _MOST_OF_A_RUN:
        raise InputError(
            f"trajectory.duration: a run of {n:,} samples is more than mcsim can hold; shorten it "
            f"or lower `sensor.rate`, to {_MOST_OF_A_RUN:,} samples"
        )
    if n * model.runs > _MOST_STEPS:
        raise InputError(
            f"runs: {model.runs} runs of {n:,} samples are more than mcsim can hold; "
            "shorten `trajectory.duration` or lower `sensor.rate` or `runs`"
        )
    if _is_surely_measured(model):
        check_group(model)
    return n


def steps_until(time: float, rate: float) -> int:
    """Whole sampling intervals within a time (s), rounding of the time forgiven."""
    return math.floor(time * rate * (1.0 + 1e-12) + 1e-9)


def rest_steps(model: VelocityScenario) -> int:
    """Samples of the rest, at least one."""
    return max(1, math.floor(model.trajectory.rest * model.sensor.rate * (1.0 + 1e-12)))


def check_group(model: VelocityScenario) -> None:
    """Refuse a group that does not fit in memory where every sample is measured.

    Raises
    ------
    InputError
        Too many samples, or too many runs and instants.
    """
    rate, run = model.sensor.rate, model.trajectory
    samples = rest_steps(model) + model.runs * steps_until(run.duration, rate)
    if samples > _MOST_MEASURED:
        raise InputError(
            f"sensor.accelerometer: a group's rest and runs are {samples:,} samples, more than the "
            f"{_MOST_MEASURED:,} that mcsim can measure one by one; shorten `trajectory.rest`, "
            "lower `sensor.rate` or `runs`, or leave out all terms but noise and offsets"
        )
    if len(model.reported) * model.runs**2 > _MOST_COVARIANCES:
        raise InputError(
            f"sensor.accelerometer: the covariances of {model.runs} runs at "
            f"{len(model.reported)} instants are more than mcsim can hold; lower `runs` or ask "
            "for fewer `instants`"
        )


def _is_surely_measured(model: VelocityScenario) -> bool:
    """Whether the accelerometer has more than noise, offsets and a range that may not matter."""
    errors = raw_errors(model)
    return bool(
        errors.mixing
        or any(p.count for p in errors.processes)
        or np.any(errors.resolutions)
        or np.any(errors.spike_rates * errors.spike_amplitudes)
    )
