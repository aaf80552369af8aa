"""A straight run from rest to rest: true velocity, acceleration, tilt."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.systems.velocity.scenario import StraightRun

Array = NDArray[np.float64]

#: Times within an interval that a mean is taken from.
_NODES = 6


@dataclass(frozen=True)
class RunMotion:
    """True motion at given times, arrays of one shape: SI units; tilt is that of the sensor."""

    velocity: Array
    acceleration: Array
    vertical: Array
    tilt: Array


def run_motion(run: StraightRun, time: Array) -> RunMotion:
    """Motion at times after the start (s).

    At a jump of the acceleration its value is the mean of both sides.
    """
    ramp = run.top_speed / run.acceleration
    velocity = run.acceleration * np.clip(np.minimum(time, run.duration - time), 0.0, ramp)
    return RunMotion(
        velocity=velocity,
        acceleration=run.acceleration
        * (_between(time, 0.0, ramp) - _between(time, run.duration - ramp, run.duration)),
        vertical=run.vertical.amplitude * np.sin(2.0 * np.pi * run.vertical.frequency * time),
        tilt=run.mounting_angle
        + run.pitch.amplitude * np.sin(2.0 * np.pi * run.pitch.frequency * time),
    )


def within_intervals(run: StraightRun, time: Array) -> tuple[RunMotion, Array]:
    """Motion (n, k) at k times within each interval between ``n + 1`` times, for means over them.

    The second result are the weights (k,) of the times, of Gauss and Legendre.  The acceleration,
    which may jump, is each interval's mean throughout.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    steps = np.diff(time)
    inside = time[:-1, None] + 0.5 * steps[:, None] * (1.0 + nodes)
    motion = run_motion(run, inside)
    mean = np.diff(run_motion(run, time).velocity) / steps
    acceleration = np.broadcast_to(mean[:, None], inside.shape)
    return replace(motion, acceleration=acceleration), 0.5 * weights


def _between(time: Array, begin: float, end: float) -> Array:
    """1 inside, 1/2 on the ends (to rounding of the times), 0 outside."""
    tiny = 1e-9
    return 0.5 * (
        np.sign(np.where(np.abs(time - begin) < tiny, 0.0, time - begin))
        - np.sign(np.where(np.abs(time - end) < tiny, 0.0, time - end))
    )
