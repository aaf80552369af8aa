"""Plane curves by arc length: position, course and curvature at a distance s."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# So many panels that four nodes each are exact to rounding.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_PANELS_PER_PIECE = 256
#: The angle (rad) that a panel of a curve may turn by at most.
_TURN_PER_PANEL = 0.4
#: Points of a curve worked out at once: what that takes in memory does not grow with the drive.
_AT_ONCE = 1 << 18
#: Newton's steps, and the share of the parameter's range under which one step more is rounding.
_MOST_STEPS, _SMALL_STEP = 6, 1e-8


@dataclass(frozen=True)
class CurvePoints:
    """Points of a curve; all arrays have the shape of the distances asked for.

    ``along`` and ``across`` in m, ``course`` in rad, ``curvature`` in 1/m.
    """

    along: Array
    across: Array
    course: Array
    curvature: Array


class PlaneCurve(Protocol):
    """A curve that starts at the origin in the direction of ``along``."""

    @property
    def length(self) -> float:
        """Arc length S (m)."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Distances strictly inside at which the curvature may jump (m)."""

    def at(self, s: Array) -> CurvePoints:
        """The points at distances ``s`` (m), 0 <= s <= length."""


def _in_pieces(at: Callable[[Array], CurvePoints], s: Array) -> CurvePoints:
    """The points at distances of any shape, so many at once as need little memory."""
    if s.size <= _AT_ONCE:
        return at(s)
    flat = s.ravel()
    parts = [at(flat[i : i + _AT_ONCE]) for i in range(0, len(flat), _AT_ONCE)]

    def joined(name: str) -> Array:
        return np.concatenate([getattr(part, name) for part in parts]).reshape(s.shape)

    return CurvePoints(*map(joined, ("along", "across", "course", "curvature")))


class _Cumulative:
    """The running integral of a smooth function over pieces, exact to rounding."""

    def __init__(
        self,
        function: Callable[[Array], Array],
        pieces: Array,
        panels_per_piece: int = _PANELS_PER_PIECE,
    ) -> None:
        self.function = function
        self.knots = np.unique(
            np.concatenate([np.linspace(a, b, panels_per_piece + 1) for a, b in pairwise(pieces)])
        )
        panels = self._panel(self.knots[:-1], self.knots[1:])
        self.at_knots = np.concatenate([[0.0], np.cumsum(panels)])

    def _panel(self, a: Array, b: Array) -> Array:
        half = 0.5 * (b - a)
        u = (0.5 * (a + b))[:, None] + half[:, None] * _NODES
        return half * (self.function(u) @ _WEIGHTS)

    def __call__(self, u: Array) -> Array:
        i = np.clip(np.searchsorted(self.knots, u, side="right") - 1, 0, len(self.knots) - 2)
        return self.at_knots[i] + self._panel(self.knots[i], u)


@dataclass(frozen=True)
class Derivatives:
    """A parametric curve and its first two derivatives at some parameters."""

    x: Array
    y: Array
    dx: Array
    dy: Array
    ddx: Array
    ddy: Array


class ParametricCurve:
    """A curve (x(u), y(u)) turned so that it starts at the origin along ``along``.

    ``pieces`` are the parameters between which the curve is smooth, ends included.
    """

    def __init__(self, evaluate: Callable[[Array], Derivatives], pieces: Array) -> None:
        self._evaluate = evaluate
        self._arc = _Cumulative(self._speed, pieces)
        self.length = float(self._arc.at_knots[-1])
        self._pace = 1.0 / self._speed(self._arc.knots)
        self.breaks = tuple(float(s) for s in self._arc(pieces[1:-1]))
        start = evaluate(pieces[:1])
        self._origin = (float(start.x[0]), float(start.y[0]))
        self._direction = float(np.arctan2(start.dy[0], start.dx[0]))

    def _speed(self, u: Array) -> Array:
        d = self._evaluate(u)
        return np.hypot(d.dx, d.dy)

    def _guess(self, s: Array) -> Array:
        """The inverse of the arc length by cubic Hermite interpolation between the knots."""
        knots, at_knots = self._arc.knots, self._arc.at_knots
        i = np.clip(np.searchsorted(at_knots, s, side="right") - 1, 0, len(knots) - 2)
        width = at_knots[i + 1] - at_knots[i]
        x = (s - at_knots[i]) / width
        rise = x * x * (3.0 - 2.0 * x)
        start, end = width * self._pace[i], width * self._pace[i + 1]
        bend = x * (1.0 - x) * ((1.0 - x) * start - x * end)
        guess: Array = knots[i] + rise * (knots[i + 1] - knots[i]) + bend
        return guess

    def parameter(self, s: Array) -> Array:
        """The parameter at arc length ``s``: cubic guess, then Newton to rounding."""
        first, last = self._arc.knots[0], self._arc.knots[-1]
        u = np.clip(self._guess(s), first, last)
        for _ in range(_MOST_STEPS):
            step = (self._arc(u) - s) / self._speed(u)
            u = np.clip(u - step, first, last)
            # The error of the next guess is of the order of the step's square.
            if np.all(np.abs(step) <= _SMALL_STEP * (last - first)):
                break
        return u

    def at(self, s: Array) -> CurvePoints:
        return _in_pieces(self._at, s)

    def _at(self, s: Array) -> CurvePoints:
        d = self._evaluate(self.parameter(s))
        x, y = d.x - self._origin[0], d.y - self._origin[1]
        c, sn = np.cos(self._direction), np.sin(self._direction)
        course = np.arctan2(d.dy, d.dx) - self._direction
        return CurvePoints(
            along=c * x + sn * y,
            across=c * y - sn * x,
            course=course,
            curvature=(d.dx * d.ddy - d.dy * d.ddx) / np.hypot(d.dx, d.dy) ** 3,
        )


class ClothoidCurve:
    """Clothoid, circular arc, clothoid: the curvature is piecewise linear in s."""

    def __init__(self, radius: float, angle: float, clothoid: float) -> None:
        self._clothoid = clothoid
        self._peak = np.sign(angle) / radius
        arc = radius * abs(angle) - clothoid
        self.length = arc + 2.0 * clothoid
        inner = (clothoid, clothoid + arc) if clothoid > 0.0 else ()
        self.breaks: tuple[float, ...] = ()
        pieces = np.unique(np.array([0.0, *inner, self.length]))
        panels = max(_PANELS_PER_PIECE, math.ceil(abs(angle) / _TURN_PER_PANEL))
        self._along = _Cumulative(lambda s: np.cos(self._course(s)), pieces, panels)
        self._across = _Cumulative(lambda s: np.sin(self._course(s)), pieces, panels)

    def _curvature(self, s: Array) -> Array:
        if self._clothoid == 0.0:
            return np.full_like(s, self._peak)
        from_end = np.minimum(s, self.length - s)
        # Clipped first: dividing by a vanishing clothoid would overflow.
        return self._peak * (np.clip(from_end, 0.0, self._clothoid) / self._clothoid)

    def _course(self, s: Array) -> Array:
        if self._clothoid == 0.0:
            return self._peak * s
        c = self._clothoid
        entry = np.minimum(s, c)
        arc = np.clip(s - c, 0.0, self.length - 2.0 * c)
        leave = np.clip(s - (self.length - c), 0.0, c)
        return self._peak * (entry**2 / (2.0 * c) + arc + leave - leave**2 / (2.0 * c))

    def at(self, s: Array) -> CurvePoints:
        return _in_pieces(self._at, s)

    def _at(self, s: Array) -> CurvePoints:
        return CurvePoints(self._along(s), self._across(s), self._course(s), self._curvature(s))
