"""A straight run: true velocity of the wheels, and what the sensor on the body goes through."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.systems.velocity.profiles import Profile, RunBlock, profile_of
from mcsim.systems.velocity.scenario import PitchingBody, VelocityScenario
from mcsim.trajectory.lean import Lean, leaning, refuse_long

Array = NDArray[np.float64]

#: Times within an interval that a mean is taken from.
_NODES = 6


@dataclass(frozen=True)
class RunMotion:
    """True motion at given times, arrays of one shape: SI units.

    The velocity is that of the wheels; acceleration, vertical acceleration and tilt are those of
    the sensor.
    """

    velocity: Array
    acceleration: Array
    vertical: Array
    tilt: Array


@dataclass(frozen=True, eq=False)
class TrueRun:
    """A run on its wheels, and how the body pitches on them (None if it is stiff).

    A sensor at a height h above the axis of the pitch alpha lies h sin(alpha) behind it: it moves
    at ``v - h alpha' cos(alpha)``.
    """

    run: RunBlock
    profile: Profile
    lean: Lean | None = None
    height: float = 0.0

    def motion(self, time: Array) -> RunMotion:
        """Motion at times after the start (s).

        At a jump of the wheels' acceleration its value is the mean of both sides.
        """
        run, profile = self.run, self.profile
        swing = 2.0 * np.pi * run.pitch.frequency * time
        motion = RunMotion(
            velocity=profile.velocity(time),
            acceleration=profile.acceleration(time),
            vertical=run.vertical.amplitude * np.sin(2.0 * np.pi * run.vertical.frequency * time),
            tilt=run.mounting_angle + run.pitch.amplitude * np.sin(swing),
        )
        return motion if self.lean is None else self._on_the_body(self.lean, motion, time)

    def within_intervals(self, time: Array) -> tuple[RunMotion, Array]:
        """Motion (n, k) at k times within each interval between ``n + 1`` times, for means.

        The second result are the weights (k,) of the times, of Gauss and Legendre.  The
        acceleration, which may jump, is each interval's mean throughout.
        """
        nodes, weights = np.polynomial.legendre.leggauss(_NODES)
        steps = np.diff(time)
        inside = time[:-1, None] + 0.5 * steps[:, None] * (1.0 + nodes)
        motion = self.motion(inside)
        mean = np.diff(self.sensor_velocity(time)) / steps
        acceleration = np.broadcast_to(mean[:, None], inside.shape)
        return replace(motion, acceleration=acceleration), 0.5 * weights

    def sensor_velocity(self, time: Array) -> Array:
        """Horizontal velocity (m/s) of the sensor: that of the wheels, less its own swing."""
        velocity = self.profile.velocity(time)
        if self.lean is None or self.height == 0.0:
            return velocity
        swing = self.height * self.lean.rate(time) * np.cos(self.lean.angle(time))
        return np.asarray(velocity - swing, float)

    def _on_the_body(self, lean: Lean, motion: RunMotion, time: Array) -> RunMotion:
        angle, rate, bend = lean.angle(time), lean.rate(time), lean.bend(time)
        cos, sin = np.cos(angle), np.sin(angle)
        return replace(
            motion,
            acceleration=motion.acceleration - self.height * (bend * cos - rate**2 * sin),
            vertical=motion.vertical - self.height * (bend * sin + rate**2 * cos),
            tilt=motion.tilt + angle,
        )


def true_run(model: VelocityScenario, folder: Path) -> TrueRun:
    """The true run of a scenario; ``folder`` is where recorded files lie.

    Raises
    ------
    InputError
        A record that cannot be used, or a body that cannot follow the run.
    """
    return _run(model.trajectory, model.body, folder)


@lru_cache(maxsize=64)
def _run(run: RunBlock, body: PitchingBody, folder: Path) -> TrueRun:
    profile = profile_of(run, folder)
    pitch = body.pitch
    if pitch.gradient == 0.0:
        return TrueRun(run, profile)
    refuse_long(run.duration, pitch.natural_frequency)
    lean = leaning(
        profile.acceleration,
        0.0,
        0.0,
        profile.breaks,
        pitch.gradient,
        pitch.natural_frequency,
        pitch.damping,
    )
    return TrueRun(run, profile, lean, body.height)
