"""A drive: the vehicle's true motion over time, with its straight lead segments."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from mcsim.trajectory.curves import Array, PlaneCurve

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

#: Half-width (s) of the look to both sides of a jump.
_BESIDE = 1e-7
#: Times worked out at once: what that takes in memory does not grow with the drive.
_AT_ONCE = 1 << 18


@dataclass(frozen=True)
class Motion:
    """True motion at some times; every array has the shape of the times.

    Position along and across (m), velocity along and across (m/s), heading (rad),
    acceleration forward and to the left of the vehicle (m/s^2), yaw rate (rad/s).
    """

    along: Array
    across: Array
    velocity_along: Array
    velocity_across: Array
    heading: Array
    forward: Array
    left: Array
    yaw_rate: Array

    @property
    def speed(self) -> Array:
        return np.hypot(self.velocity_along, self.velocity_across)

    @property
    def course(self) -> Array:
        return np.arctan2(self.velocity_across, self.velocity_along)


class Manoeuvre(Protocol):
    """Motion between time 0 and ``duration``, without lead segments; derive from it.

    Attributes
    ----------
    duration : float
        Seconds.
    stops : bool
        Whether the vehicle stands still at the end; then there is no lead-out.
    jumps : tuple of float
        Times strictly inside at which accelerations may jump (s).
    notes : tuple of str
        What a user should know of where the motion comes from.
    attitude : pair of BSpline, optional
        Roll and pitch of the body (rad) over time, where they are known beforehand.
    """

    duration: float
    stops: bool
    jumps: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()
    attitude: tuple[BSpline, BSpline] | None = None

    def motion(self, t: Array) -> Motion:
        """The motion at times within [0, duration]."""


class CurveManoeuvre(Manoeuvre):
    """A plane curve driven with constant deceleration.

    ``s(t) = v0 t - a t^2 / 2``; if ``v0^2 <= 2 a S`` the vehicle stops at ``v0 / a``
    inside, and the manoeuvre ends there.  Side-slip is course minus heading.
    """

    def __init__(
        self,
        curve: PlaneCurve,
        speed: float,
        deceleration: float,
        side_slip: float = 0.0,
        slip_bump: bool = False,
    ) -> None:
        self.curve = curve
        self.speed = speed
        self.deceleration = deceleration
        self.side_slip = side_slip
        self.slip_bump = slip_bump
        # The relative margin lets a deceleration written as v0^2 / (2 S) stop at the very end.
        self.stops = speed**2 <= 2.0 * deceleration * curve.length * (1.0 + 1e-12)
        self.duration = speed / deceleration if self.stops else self._time_at(curve.length)
        self.jumps = tuple(
            t for t in map(self._time_at, curve.breaks) if t is not None and t < self.duration
        )

    def _time_at(self, s: float) -> float:
        """Time at which distance ``s`` is reached; infinite if it never is."""
        square = self.speed**2 - 2.0 * self.deceleration * s
        if square < 0.0:
            return math.inf
        return 2.0 * s / (self.speed + math.sqrt(square))

    def motion(self, t: Array) -> Motion:
        v = np.maximum(self.speed - self.deceleration * t, 0.0)
        s = np.clip((self.speed - 0.5 * self.deceleration * t) * t, 0.0, self.curve.length)
        points = self.curve.at(s)
        slip, slip_rate = self._slip(t)
        tangential, normal = -self.deceleration, v**2 * points.curvature
        return Motion(
            along=points.along,
            across=points.across,
            velocity_along=v * np.cos(points.course),
            velocity_across=v * np.sin(points.course),
            heading=points.course - slip,
            forward=tangential * np.cos(slip) - normal * np.sin(slip),
            left=tangential * np.sin(slip) + normal * np.cos(slip),
            yaw_rate=v * points.curvature - slip_rate,
        )

    def _slip(self, t: Array) -> tuple[Array, Array]:
        if not self.slip_bump:
            return np.full_like(t, self.side_slip), np.zeros_like(t)
        phase = np.pi * t / self.duration
        rate = self.side_slip * np.pi / self.duration * np.sin(2.0 * phase)
        return self.side_slip * np.sin(phase) ** 2, rate


@dataclass(frozen=True)
class Drive:
    """A manoeuvre between two straight leads at the speed of that moment.

    Time 0 is where the manoeuvre starts; the drive begins at ``-lead``.
    """

    manoeuvre: Manoeuvre
    lead: float

    @property
    def end(self) -> float:
        """Time of the drive's end (s); no lead-out after a stop."""
        return self.manoeuvre.duration + (0.0 if self.manoeuvre.stops else self.lead)

    @property
    def duration(self) -> float:
        return self.lead + self.end

    def motion(self, t: Array) -> Motion:
        """The motion at any time; outside the manoeuvre it goes straight on.

        At a jump of the accelerations their value is the mean of both sides.
        """
        within = np.clip(t, 0.0, self.manoeuvre.duration)
        inner = self.manoeuvre.motion(within)
        outside = t - within
        signals = self.signals(t)
        return Motion(
            along=inner.along + outside * inner.velocity_along,
            across=inner.across + outside * inner.velocity_across,
            velocity_along=inner.velocity_along,
            velocity_across=inner.velocity_across,
            heading=inner.heading,
            forward=signals[0],
            left=signals[1],
            yaw_rate=signals[2],
        )

    def heading(self, t: Array) -> Array:
        """Heading at any time (rad)."""
        return self.manoeuvre.motion(np.clip(t, 0.0, self.manoeuvre.duration)).heading

    def _signals(self, t: Array) -> Array:
        """Forward and left acceleration and yaw rate; zero on the straight."""
        if len(t) > _AT_ONCE:
            pieces = [t[i : i + _AT_ONCE] for i in range(0, len(t), _AT_ONCE)]
            return np.concatenate([self._signals(piece) for piece in pieces], axis=1)
        signals = np.zeros((3, *t.shape))
        inside = (t > 0.0) & (t < self.manoeuvre.duration)
        motion = self.manoeuvre.motion(t[inside])
        signals[:, inside] = motion.forward, motion.left, motion.yaw_rate
        return signals

    def signals(self, t: Array, width: float | Array = 0.0) -> Array:
        """What ideal sensors measure at times ``t`` (k,): forward, left, yaw rate (3, k).

        A time on a jump takes the mean of both sides.  With a ``width`` (s), of all or of each,
        a time whose cell of that width holds a jump takes the mean over its cell, so that a grid
        of cells keeps the integral wherever the jump lies between its points.
        """
        signals = self._signals(t)
        half = np.broadcast_to(np.maximum(0.5 * np.asarray(width), _BESIDE), t.shape)
        for jump in (0.0, *self.manoeuvre.jumps, self.manoeuvre.duration):
            near = np.abs(t - jump) < half
            if np.any(near):
                before = np.clip(0.5 + (jump - t[near]) / (2.0 * half[near]), 0.0, 1.0)
                if np.all(np.asarray(width) == 0.0):
                    before[:] = 0.5
                sides = self._signals(jump + np.array([-2.0, 2.0]) * _BESIDE)
                signals[:, near] = before * sides[:, :1] + (1.0 - before) * sides[:, 1:]
        return signals
