"""One sample of the strapdown system: the four rules, as steps of the frame.

A step reads what was measured in the order of the channels: forward, left, yaw turn, up, roll
turn, pitch turn.
"""

from __future__ import annotations

from typing import NamedTuple

from mcsim.kernels.compilation import scalar
from mcsim.kernels.quaternion import (
    compose,
    cross,
    increment,
    increment_exactly,
    increment_little,
    rotate,
)
from mcsim.kernels.system import Step


class State(NamedTuple):
    """Quaternion, velocity and position, these divided by the interval and its square."""

    w: float
    x: float
    y: float
    z: float
    vl: float
    vd: float
    vh: float
    pl: float
    pd: float
    ph: float


class Remembering(NamedTuple):
    """The same, then the last sample's channels in their order."""

    w: float
    x: float
    y: float
    z: float
    vl: float
    vd: float
    vh: float
    pl: float
    pd: float
    ph: float
    forward: float
    left: float
    yaw: float
    up: float
    roll: float
    pitch: float


def _make_steps(increment_of):
    """Steps with the given way of turning rotation vectors to increments."""

    @scalar
    def rectangular(system, state, read):
        """New attitude first, then velocity, then position."""
        w, x, y, z, vl, vd, vh, pl, pd, ph = state
        f, g, c, h, a, b = read
        d, a, b, c = increment_of(a, b, c)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        al, ad, ah = rotate(w, x, y, z, f, g, h)
        vl, vd, vh = vl + al, vd + ad, vh + (ah - system.gravity)
        return State(w, x, y, z, vl, vd, vh, pl + vl, pd + vd, ph + vh)

    @scalar
    def forward_euler(system, state, read):
        """Position from the old velocity, velocity from the old attitude."""
        w, x, y, z, vl, vd, vh, pl, pd, ph = state
        f, g, c, h, a, b = read
        pl, pd, ph = pl + vl, pd + vd, ph + vh
        al, ad, ah = rotate(w, x, y, z, f, g, h)
        d, a, b, c = increment_of(a, b, c)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        return State(w, x, y, z, vl + al, vd + ad, vh + (ah - system.gravity), pl, pd, ph)

    @scalar
    def trapezoidal(system, state, read):
        """Half of the turn before the interval's mean acceleration acts, half after it."""
        w, x, y, z = state.w, state.x, state.y, state.z
        vl, vd, vh = state.vl, state.vd, state.vh
        f, g, h, a, b, c = _mean(system, state, read)
        d, a, b, c = increment_of(0.5 * a, 0.5 * b, 0.5 * c)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        al, ad, ah = rotate(w, x, y, z, f, g, h)
        ah = ah - system.gravity
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        return Remembering(
            w,
            x,
            y,
            z,
            vl + al,
            vd + ad,
            vh + ah,
            state.pl + (vl + 0.5 * al),
            state.pd + (vd + 0.5 * ad),
            state.ph + (vh + 0.5 * ah),
            *read,
        )

    return Step(rectangular, State), Step(forward_euler, State), Step(trapezoidal, Remembering)


@scalar
def _mean(system, state, read):
    """Mean of two samples over the interval of the second, and their corrections.

    ``system.coning``, 1/12 or none, is the weight of what two neighbouring samples tell of the
    turning within the interval: sculling ``turn_0 x f + f_0 x turn``, coning ``turn_0 x turn``;
    exact for rates that change linearly.
    """
    f0, g0, h0 = state.forward, state.left, state.up
    a0, b0, c0 = state.roll, state.pitch, state.yaw
    f, g, c, h, a, b = read
    previous_share, coning = system.previous_share, system.coning
    share = 1.0 - previous_share
    s1, s2, s3 = cross(a0, b0, c0, f, g, h)
    r1, r2, r3 = cross(f0, g0, h0, a, b, c)
    k1, k2, k3 = cross(a0, b0, c0, a, b, c)
    return (
        share * f + previous_share * f0 + coning * (s1 + r1),
        share * g + previous_share * g0 + coning * (s2 + r2),
        share * h + previous_share * h0 + coning * (s3 + r3),
        share * a + previous_share * a0 + coning * k1,
        share * b + previous_share * b0 + coning * k2,
        share * c + previous_share * c0 + coning * k3,
    )


RECTANGULAR_LITTLE, _, _ = _make_steps(increment_little)
RECTANGULAR, FORWARD_EULER, TRAPEZOIDAL = _make_steps(increment)
RECTANGULAR_EXACTLY, FORWARD_EULER_EXACTLY, TRAPEZOIDAL_EXACTLY = _make_steps(increment_exactly)
