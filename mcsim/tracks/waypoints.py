"""A smooth track through given points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from annotated_types import Len

from mcsim.errors import InputError
from mcsim.scenario.fields import Length
from mcsim.tracks.track import DrivenTrackBlock, Track, along
from mcsim.trajectory.curves import Array, Derivatives, ParametricCurve

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

#: A spline through way-points that is slower than this (1 is the usual) turns on the spot.
_SLOWEST_PACE = 0.05

Waypoint = Annotated[tuple[Length, ...], Len(2, 2)]


class Waypoints(DrivenTrackBlock):
    """A smooth track (cubic spline) through given points."""

    shape: Literal["waypoints"]
    points: Annotated[tuple[Waypoint, ...], Len(2, 10_000)]
    """Points [x, y]; turned so that `along` is the initial direction of movement."""


def _curve(block: Waypoints) -> ParametricCurve:
    """A natural cubic spline over the chord length.

    Raises
    ------
    InputError
        Way-points that coincide or turn back on themselves.
    """
    from scipy.interpolate import CubicSpline

    xy = np.array(block.points)
    chords = np.hypot(*np.diff(xy, axis=0).T)
    if np.any(chords <= 0.0):
        i = int(np.argmax(chords <= 0.0))
        raise InputError(f"trajectory.points: points {i} and {i + 1} coincide")
    knots = np.concatenate([[0.0], np.cumsum(chords)])
    spline = CubicSpline(knots, xy, bc_type="natural")
    _refuse_turns(spline, knots)

    def evaluate(u: Array) -> Derivatives:
        (x, y), (dx, dy), (ddx, ddy) = (np.moveaxis(spline(u, nu), -1, 0) for nu in range(3))
        return Derivatives(x, y, dx, dy, ddx, ddy)

    curve = ParametricCurve(evaluate, knots)
    # A cubic spline is twice continuously differentiable: no jumps at the way-points.
    curve.breaks = ()
    return curve


def _refuse_turns(spline: CubicSpline, knots: Array) -> None:
    """Refuse a spline that nearly stops.

    It runs over its chord length at about unit speed; where it nearly stops, the track turns
    back on itself and has no course.
    """
    fine = np.linspace(knots[0], knots[-1], 64 * len(knots) + 1)
    pace = np.hypot(*spline(fine, 1).T)
    if pace.min() < _SLOWEST_PACE:
        nearest = int(np.argmin(np.abs(knots - fine[np.argmin(pace)])))
        raise InputError(
            f"trajectory.points: the track turns back on itself near point {nearest}; "
            "round the turn with further points"
        )


TRACK = Track("waypoints", Waypoints, along(_curve))
