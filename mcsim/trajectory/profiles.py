"""Displacements across the road over the distance along it, and the curves that they make."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mcsim.trajectory.curves import Array, Derivatives, ParametricCurve

#: A displacement across the road and its first two derivatives with respect to l.
Profile = Callable[[Array], tuple[Array, Array, Array]]


def lane_change(profile: str, length: float, width: float) -> Profile:
    """Displacement across the road over 0 <= l <= L.

    ``half_cosine`` is Eq. (1) of the planar paper; ``quintic`` is the polynomial
    whose slope and curvature vanish at both ends, ``nonic`` the one of ninth degree, where two
    more derivatives do: its curvature has no kink.
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

    def nonic(u: Array) -> tuple[Array, Array, Array]:
        x = u / length
        y = x * (1.0 - x)
        rise = 126.0 + x * (-420.0 + x * (540.0 + x * (-315.0 + x * 70.0)))
        return (
            width * x**5 * rise,
            width / length * 630.0 * y**4,
            width / length**2 * 2520.0 * y**3 * (1.0 - 2.0 * x),
        )

    return {"half_cosine": half_cosine, "quintic": quintic, "nonic": nonic}[profile]


def graph(profile: Profile, pieces: list[float]) -> ParametricCurve:
    """The graph of a displacement over the distance l along the road.

    ``pieces`` (m) are the distances between which it is smooth, ends included.
    """

    def evaluate(u: Array) -> Derivatives:
        d, slope, bend = profile(u)
        return Derivatives(u, d, np.ones_like(u), slope, np.zeros_like(u), bend)

    return ParametricCurve(evaluate, np.array(pieces))
