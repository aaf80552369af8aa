"""The shapes of track that a scenario can name, as plane curves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mcsim.errors import InputError
from mcsim.scenario.tracks import (
    Curve,
    DoubleLaneChange,
    LaneChange,
    Straight,
    Waypoints,
)
from mcsim.trajectory.curves import (
    Array,
    ClothoidCurve,
    Derivatives,
    ParametricCurve,
    PlaneCurve,
)

#: A spline through way-points that is slower than this (1 is the usual) turns on the spot.
_SLOWEST_PACE = 0.05
#: A displacement across the road and its first two derivatives with respect to l.
Profile = Callable[[Array], tuple[Array, Array, Array]]


def curve_of(shape: Straight | LaneChange | DoubleLaneChange | Curve | Waypoints) -> PlaneCurve:
    """The curve of a scenario's track.

    Raises
    ------
    InputError
        Way-points that coincide or turn back on themselves.
    """
    match shape:
        case Straight():
            return _graph(lambda u: (0.0 * u, 0.0 * u, 0.0 * u), [0.0, shape.length])
        case LaneChange():
            profile = lane_change(shape.shape, shape.length, shape.width)
            return _graph(profile, [0.0, shape.length])
        case DoubleLaneChange():
            return _double_lane_change(shape)
        case Curve():
            return ClothoidCurve(shape.radius, shape.angle, shape.clothoid)
        case Waypoints():
            return _through(shape.points)


def lane_change(profile: str, length: float, width: float) -> Profile:
    """Displacement across the road over 0 <= l <= L.

    ``half_cosine`` is Eq. (1) of the planar paper; ``quintic`` is the polynomial
    whose slope and curvature vanish at both ends.
    """

    def half_cosine(u: Array) -> tuple[Array, Array, Array]:
        k = np.pi / length
        cos = np.cos(k * u)
        return (
            0.5 * width * (1.0 - cos),
            0.5 * width * k * np.sin(k * u),
            0.5 * width * k**2 * cos,
        )

    def quintic(u: Array) -> tuple[Array, Array, Array]:
        x = u / length
        return (
            width * x**3 * (10.0 - 15.0 * x + 6.0 * x**2),
            width / length * 30.0 * x**2 * (1.0 - x) ** 2,
            width / length**2 * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        )

    return {"half_cosine": half_cosine, "quintic": quintic}[profile]


def _graph(profile: Profile, pieces: list[float]) -> ParametricCurve:
    """The graph of a displacement over the distance along the road."""

    def evaluate(u: Array) -> Derivatives:
        d, slope, bend = profile(u)
        return Derivatives(u, d, np.ones_like(u), slope, np.zeros_like(u), bend)

    return ParametricCurve(evaluate, np.array(pieces))


def _double_lane_change(shape: DoubleLaneChange) -> ParametricCurve:
    out = lane_change(shape.profile, shape.length, shape.width)
    back_at = shape.length + shape.gap
    end = back_at + shape.length

    def profile(u: Array) -> tuple[Array, Array, Array]:
        d, slope, bend = out(np.clip(u, 0.0, shape.length))
        e, fall, dip = out(np.clip(u - back_at, 0.0, shape.length))
        going = u <= shape.length
        returning = u >= back_at
        return (
            d - e,
            np.where(going, slope, 0.0) - np.where(returning, fall, 0.0),
            np.where(going, bend, 0.0) - np.where(returning, dip, 0.0),
        )

    return _graph(profile, sorted({0.0, shape.length, back_at, end}))


def _through(points: tuple[tuple[float, ...], ...]) -> ParametricCurve:
    """A natural cubic spline over the chord length."""
    from scipy.interpolate import CubicSpline

    xy = np.array(points)
    chords = np.hypot(*np.diff(xy, axis=0).T)
    if np.any(chords <= 0.0):
        i = int(np.argmax(chords <= 0.0))
        raise InputError(f"trajectory.points: points {i} and {i + 1} coincide")
    knots = np.concatenate([[0.0], np.cumsum(chords)])
    spline = CubicSpline(knots, xy, bc_type="natural")

    def evaluate(u: Array) -> Derivatives:
        (x, y), (dx, dy), (ddx, ddy) = (np.moveaxis(spline(u, nu), -1, 0) for nu in range(3))
        return Derivatives(x, y, dx, dy, ddx, ddy)

    # The spline runs over its chord length at about unit speed; where it nearly stops,
    # the track turns back on itself and has no course.
    fine = np.linspace(knots[0], knots[-1], 64 * len(knots) + 1)
    pace = np.hypot(*spline(fine, 1).T)
    if pace.min() < _SLOWEST_PACE:
        nearest = int(np.argmin(np.abs(knots - fine[np.argmin(pace)])))
        raise InputError(
            f"trajectory.points: the track turns back on itself near point {nearest}; "
            "round the turn with further points"
        )
    curve = ParametricCurve(evaluate, knots)
    # A cubic spline is twice continuously differentiable: no jumps at the way-points.
    curve.breaks = ()
    return curve
