"""What the planar case's sensors sample of a drive, and how long it may last."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from mcsim.errors import InputError
from mcsim.scenario.sample_times import Intervals
from mcsim.scenario.sensors import Sensors
from mcsim.sensor_terms.mechanisms.linear_filter import Filters
from mcsim.sensors.filters import behind_filters
from mcsim.sensors.sampling import (
    DENSE_RATE,
    Signals,
    oversampling,
    power_beyond,
    sample,
    sample_at,
)
from mcsim.sensors.schedule import Instants, Schedule, schedule_of
from mcsim.simulation.problem import Array
from mcsim.trajectory import Drive, Motion

#: Dense samples of the truth and samples of a drive whose arrays fit in memory (some 2 GB).
_MOST_DENSE_SAMPLES, _MOST_SAMPLES = 20_000_000, 3_000_000
#: Share of a drive after its last sample that is more than rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Samples:
    """Ideal samples (n + 1, 3), turns per interval last, and the truth at their times."""

    signals: Array
    truth: Motion
    beyond_rate: Array


@lru_cache(maxsize=64)
def sampled(
    drive: Drive,
    rate: float,
    method: str,
    filters: tuple[Filters, ...],
    instants: Instants | None = None,
    latency: float = 0.0,
) -> Samples:
    """What does not change while only sensor errors are swept.

    Without ``instants`` they are even.  The truth is that of the ``latency`` (s) later.
    """
    count = sample_count(drive, rate)
    ideal: Signals = drive.signals
    if any(filters):
        ideal = behind_filters(ideal, filters, -drive.lead, rate, count)
    signals, times = taken(ideal, -drive.lead, rate, count, method, instants)
    truth = drive.motion(times + latency)
    beyond = power_beyond(ideal, -drive.lead, rate, count)
    return Samples(np.ascontiguousarray(signals.T * [1.0, 1.0, 1.0 / rate]), truth, beyond)


def taken(
    ideal: Signals, start: float, rate: float, count: int, method: str, instants: Instants | None
) -> tuple[Array, Array]:
    """Samples (c, n + 1) of ideal signals and the times (n + 1,) that they are taken at."""
    if instants is None or instants.even:
        return sample(ideal, start, rate, count, method), start + np.arange(count + 1) / rate
    return sample_at(ideal, start, instants.true, rate, method), start + instants.true


def planned(drive: Drive, sensors: Sensors, folder: Path, intervals: Intervals) -> Schedule:
    """When the samples of a drive are taken.

    Raises
    ------
    InputError
        A drive that is shorter than a sample or absurdly long, or recorded stamps that do not fit.
    """
    sample_count(drive, sensors.rate)
    return schedule_of(sensors.time, intervals, sensors.rate, drive.duration, folder)


def scheduled_count(drive: Drive, sensors: Sensors, folder: Path) -> int:
    """Number of the last sample that the drive holds; raises as ``planned``."""
    instants = planned(drive, sensors, folder, "measured").instants
    return sample_count(drive, sensors.rate) if instants is None else instants.last


def wrap(angle: Array) -> Array:
    """Angles in (-pi, pi]."""
    return angle - 2.0 * np.pi * np.ceil((angle - np.pi) / (2.0 * np.pi))


def course_missing(drive: Drive) -> Mapping[str, str]:
    """Why the course at the end is undefined, if it is."""
    if drive.manoeuvre.stops:
        return {
            "course": "the vehicle comes to rest within the last interval: its course is undefined"
        }
    return {}


def end_notes(drive: Drive, rate: float) -> tuple[str, ...]:
    """What to say of a drive whose manoeuvre goes on after the last sample; usually nothing.

    Where a lead follows it, the last sample lies in that; without one it need not hold the end.
    """
    last = sample_count(drive, rate) / rate - drive.lead
    if drive.manoeuvre.duration - last <= _ROUNDING * max(1.0, drive.duration):
        return ()
    return (
        "trajectory: the manoeuvre ends between two samples, and no lead follows that holds one; "
        "errors are those at the last sample, less than a sampling interval before the end",
    )


def sample_count(drive: Drive, rate: float) -> int:
    """Number of the last sample that the drive holds."""
    count = math.floor(drive.duration * rate * (1.0 + 1e-12) + 1e-9)
    if count < 1:
        raise InputError(
            f"sensors.rate: the drive lasts {drive.duration:.4g} s, less than one sampling "
            f"interval; use a rate above {1.0 / drive.duration:.4g} Hz"
        )
    if count * oversampling(rate) > _MOST_DENSE_SAMPLES or count > _MOST_SAMPLES:
        slower = drive.duration * DENSE_RATE < _MOST_DENSE_SAMPLES  # a lower rate would do
        raise InputError(
            f"trajectory: the drive lasts {drive.duration:.4g} s, {count:,} samples at "
            f"{rate:g} Hz, more than mcsim can hold; shorten it"
            f"{', or lower `sensors.rate`' if slower else ''}"
        )
    return count
