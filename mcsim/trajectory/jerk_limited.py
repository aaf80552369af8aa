"""Speeds with limited jerk: the acceleration is linear between the times where the jerk changes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcsim.trajectory.curves import Array


@dataclass(frozen=True)
class Ramp:
    """Speeding up from rest, or braking to it: SI units, all above zero.

    ``speed jerk`` is at least ``acceleration^2``, else the acceleration is not reached.
    """

    speed: float
    acceleration: float
    jerk: float

    @property
    def rise(self) -> float:
        """Time (s) in which the acceleration rises, and falls again."""
        return self.acceleration / self.jerk

    @property
    def hold(self) -> float:
        """Time (s) at full acceleration."""
        return self.speed / self.acceleration - self.rise

    @property
    def duration(self) -> float:
        """Time (s) of all of it."""
        return 2.0 * self.rise + self.hold


def phases(up: Ramp, cruise: float, down: Ramp) -> tuple[Array, Array]:
    """Times (s) from the start and accelerations (m/s^2) where the jerk changes, (8,).

    ``cruise`` is the time (s) between the ramps, at constant speed.
    """
    steps = [0.0, up.rise, up.hold, up.rise, cruise, down.rise, down.hold, down.rise]
    top, low = up.acceleration, -down.acceleration
    return np.cumsum(steps), np.array([0.0, top, top, 0.0, 0.0, low, low, 0.0])


def speed_of(knots: Array, accelerations: Array, time: Array) -> Array:
    """Speed (m/s) at ``time`` (s), (n,): the integral of phases that begin at rest."""
    slopes = np.diff(accelerations) / np.maximum(np.diff(knots), 1e-300)
    means = (accelerations[1:] + accelerations[:-1]) / 2.0
    speeds = np.concatenate(([0.0], np.cumsum(means * np.diff(knots))))
    at = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, len(slopes) - 1)
    since = np.clip(time, knots[0], knots[-1]) - knots[at]
    speed: Array = speeds[at] + accelerations[at] * since + 0.5 * slopes[at] * since**2
    return speed
