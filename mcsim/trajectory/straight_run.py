"""A straight run from rest to rest: true velocity, acceleration, tilt."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.scenario.velocity import StraightRun

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RunMotion:
    """True motion at given times, arrays (n,): SI units; tilt is that of the sensor."""

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


def interval_means(run: StraightRun, time: Array) -> RunMotion:
    """Motion (n,) as means over the intervals between ``n + 1`` times; angles at their middles."""
    middle = run_motion(run, 0.5 * (time[1:] + time[:-1]))
    ends = run_motion(run, time).velocity
    return RunMotion(middle.velocity, np.diff(ends) / np.diff(time), middle.vertical, middle.tilt)


def _between(time: Array, begin: float, end: float) -> Array:
    """1 inside, 1/2 on the ends (to rounding of the times), 0 outside."""
    tiny = 1e-9
    return 0.5 * (
        np.sign(np.where(np.abs(time - begin) < tiny, 0.0, time - begin))
        - np.sign(np.where(np.abs(time - end) < tiny, 0.0, time - end))
    )
