"""What the strapdown case's sensors sample of a drive."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mcsim.kernels import strapdown
from mcsim.sensor_terms.mechanisms.linear_filter import Filters
from mcsim.sensors.filters import behind_filters
from mcsim.sensors.sampling import Signals, power_beyond
from mcsim.sensors.schedule import Instants
from mcsim.simulation.planar_samples import sample_count, taken
from mcsim.simulation.problem import Array
from mcsim.systems.strapdown.truth import SpatialDrive, SpatialMotion


@dataclass(frozen=True)
class Samples:
    """Ideal samples (n + 1, 6), rates as turns per interval, and the truth at their times."""

    signals: Array
    truth: SpatialMotion
    beyond_rate: Array


@lru_cache(maxsize=64)
def sampled(
    drive: SpatialDrive,
    rate: float,
    method: str,
    filters: tuple[Filters, ...],
    instants: Instants | None = None,
    latency: float = 0.0,
) -> Samples:
    """What does not change while only sensor errors are swept; as in the plane."""
    plane = drive.drive
    count = sample_count(plane, rate)
    ideal: Signals = drive.signals
    if any(filters):
        ideal = behind_filters(ideal, filters, -plane.lead, rate, count)
    signals, times = taken(ideal, -plane.lead, rate, count, method, instants)
    truth = drive.motion(times + latency)
    beyond = power_beyond(ideal, -plane.lead, rate, count)
    return Samples(np.ascontiguousarray(signals.T * _per_interval(rate)), truth, beyond)


def _per_interval(rate: float) -> Array:
    """Factors (6,) from rates to turns per interval."""
    factors = np.ones(strapdown.Strapdown.CHANNELS)
    factors[list(strapdown.TURNS)] = 1.0 / rate
    return factors
