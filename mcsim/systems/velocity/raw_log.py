"""Raw output of a group's runs, as an accelerometer would have recorded it.

Runs are recorded one after another, each with its own rest before it and a standstill after it, as
in the source.  The scenario's uncertainties are errors here: the sensor differs from
its calibration, gravity from its estimate, the tilt while moving from that at rest, each drawn
once for the group; time stamps err as the scenario says.  Noise and drifts go on through all.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcsim.sensors.simulated_log import SimulatedLog
from mcsim.systems.velocity.raw_output import raw_errors
from mcsim.systems.velocity.samples import correction_of, rest_output, run_samples
from mcsim.systems.velocity.scenario import Gravity, VelocityScenario
from mcsim.systems.velocity.steps import rest_steps
from mcsim.systems.velocity.truth import true_run

Array = NDArray[np.float64]

#: Standstill after a run (s).
STANDSTILL = 1.0
_QUANTITIES = ("lxx", "lxy", "lxz", "lzx", "lzy", "lzz", "bx", "by", "bz")


def raw_log(
    model: VelocityScenario, seed: int, group: int = 0, folder: Path = Path()
) -> Mapping[str, Array]:
    """Columns of a group's log by title: run, time, the raw axes in g, true velocity.

    A row's velocity is that of the wheels at its nominal instant; its stamp may err.  Recorded
    profiles are looked up in ``folder``.
    """
    generator = np.random.default_rng([seed, group])
    true = drawn_truth(model, generator)
    rate, runs = model.sensor.rate, model.runs
    at_rest, still = rest_steps(model), max(1, round(STANDSTILL * rate))
    moving = math.ceil(model.trajectory.duration * rate * (1.0 - 1e-12) - 1e-9)
    times = np.arange(moving + 1) / rate
    errors = _errors(model, (at_rest + still) * runs / rate)
    level = true.model_copy(update={"trajectory": model.trajectory})
    rest = rest_output(level)
    one = np.concatenate(
        [
            np.tile(rest, (at_rest, 1)),
            run_samples(true, true_run(true, folder), times, errors.filters),
            np.tile(rest, (still, 1)),
        ]
    )
    velocity = true_run(model, folder).motion(times[:-1]).velocity
    ideal = np.tile(one, (runs, 1))
    sensed = ideal - correction_of(true.calibration)[1]
    # The filters are in the samples of the run already.
    log = SimulatedLog(
        replace(errors, filters=((),) * 3), int(generator.integers(np.iinfo(np.int64).max))
    )
    raw = log.measure(np.concatenate([ideal, sensed], axis=1))
    return {
        "run": np.repeat(np.arange(1, runs + 1), len(one)),
        "time [s]": _stamps(model, len(ideal), generator),
        **{f"a{axis} [g]": raw[:, i] for i, axis in enumerate("xyz")},
        "true velocity [m/s]": np.tile(
            np.concatenate([np.zeros(at_rest), velocity, np.zeros(still)]), runs
        ),
    }


def drawn_truth(model: VelocityScenario, generator: np.random.Generator) -> VelocityScenario:
    """What may be true where the scenario holds estimates: one draw of its uncertainties."""

    def drawn(quantity: Any) -> Any:
        error = quantity.uncertainty * generator.standard_normal()
        return quantity.model_copy(update={"estimate": quantity.estimate + error})

    quantities = {name: drawn(getattr(model.calibration, name)) for name in _QUANTITIES}
    change = model.tilt.change * generator.standard_normal()
    angle = model.trajectory.mounting_angle + change
    return model.model_copy(
        update={
            "calibration": model.calibration.model_copy(update=quantities),
            "gravity": _drawn_gravity(model.gravity, generator),
            "trajectory": model.trajectory.model_copy(update={"mounting_angle": angle}),
        }
    )


def _drawn_gravity(gravity: Gravity, generator: np.random.Generator) -> Gravity:
    error = gravity.uncertainty * generator.standard_normal()
    return gravity.model_copy(update={"estimate": gravity.local_gravity + error, "latitude": None})


def _errors(model: VelocityScenario, standing: float) -> Any:
    """Error terms whose in-run noise spans all that is recorded."""
    longer = model.trajectory.model_copy(update={"rest": standing})
    return raw_errors(model.model_copy(update={"trajectory": longer}))


def _stamps(model: VelocityScenario, count: int, generator: np.random.Generator) -> Array:
    """Time stamps (count,) in s, with their errors."""
    sensor = model.sensor
    errors = generator.standard_normal(count)
    even = np.arange(count) / sensor.rate
    if sensor.time_errors == "stamps":
        return np.asarray(even + sensor.time_error / math.sqrt(2.0) * errors)
    return np.asarray(even + sensor.time_error * np.cumsum(errors))
