"""What erring time stamps make of the errors, by the linear model, and of their history."""

from __future__ import annotations

import numpy as np

from mcsim.kernels.system import EXACT_CLOCK, Clock
from mcsim.sensors.schedule import Schedule
from mcsim.simulation.problem import Array


def clock_of(schedule: Schedule | None, disturbed: bool) -> Clock:
    """The stamps of a schedule as kernels take them; undisturbed ones err by nothing."""
    if schedule is None or not schedule.varies:
        return EXACT_CLOCK
    times, interval = schedule.times, schedule.interval
    if not disturbed:
        return Clock(0.0, 0.0, -np.inf, schedule.nominal)
    return Clock(
        times.interval_jitter / interval,
        times.stamp_jitter / interval,
        _normal_of(times.lost),
        schedule.nominal,
    )


def _normal_of(share: float) -> float:
    """The value that this share of normals lies below."""
    from scipy.special import ndtri

    return float(ndtri(share))


def instant_weights(schedule: Schedule, intervals: Array, signals: Array) -> Array:
    """Linear errors (l, n + 1) per unit normal of each sample's instant.

    ``intervals`` (l, n + 1) are those per sampling interval before each sample, ``signals``
    (l, n + 1) those of what the channels measure at another instant.
    """
    jitter = schedule.times.interval_jitter / schedule.interval
    weights = signals.copy()
    if schedule.nominal:
        # The truth is that of the last instant.
        weights[:, -1] -= jitter * intervals[:, -1]
    else:
        weights[:, 1:-1] += jitter * (intervals[:, 1:-1] - intervals[:, 2:])
    return weights


def stamp_weights(schedule: Schedule, intervals: Array) -> Array:
    """Linear errors (l, n + 1) per unit normal of each sample's stamp; arguments as above."""
    if schedule.nominal:
        return np.zeros_like(intervals)
    ends = np.concatenate([intervals[:, 1:], np.zeros((len(intervals), 1))], axis=1)
    own = intervals.copy()
    own[:, 0] = 0.0
    return np.asarray(schedule.times.stamp_jitter / schedule.interval * (own - ends), float)


def truth_late(truth: Array, times: Array, late: Array) -> Array:
    """Truth (k, n + 1, r) where samples are late (n + 1, r) in s: rows (k, n + 1) at ``times``."""
    slopes = np.gradient(truth, times, axis=1)
    return np.asarray(truth[:, :, None] + slopes[:, :, None] * late, float)
