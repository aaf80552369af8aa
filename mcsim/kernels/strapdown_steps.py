"""One sample of the strapdown system: the four rules, as steps of the frame.

A step reads what was measured in the order of the channels: forward, left, yaw turn, up, roll
turn, pitch turn; then the interval before the sample in sampling intervals, where it varies.  Where
it does not it is the number one, which the compiler leaves out.
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
from mcsim.kernels.system import Step, as_read, with_one


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


class Rules(NamedTuple):
    """Steps of the rules."""

    rectangular: Step
    forward_euler: Step
    trapezoidal: Step


def _make_steps(increment_of, complete):
    """Steps with the given way of turning rotation vectors to increments."""

    @scalar
    def rectangular(system, state, read):
        """New attitude first, then velocity, then position."""
        w, x, y, z, vl, vd, vh, pl, pd, ph = state
        f, g, c, h, a, b, r = complete(read)
        d, a, b, c = increment_of(r * a, r * b, r * c)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        al, ad, ah = rotate(w, x, y, z, f, g, h)
        vl, vd, vh = vl + r * al, vd + r * ad, vh + r * (ah - system.gravity)
        return State(w, x, y, z, vl, vd, vh, pl + r * vl, pd + r * vd, ph + r * vh)

    @scalar
    def forward_euler(system, state, read):
        """Position from the old velocity, velocity from the old attitude."""
        w, x, y, z, vl, vd, vh, pl, pd, ph = state
        f, g, c, h, a, b, r = complete(read)
        pl, pd, ph = pl + r * vl, pd + r * vd, ph + r * vh
        al, ad, ah = rotate(w, x, y, z, f, g, h)
        d, a, b, c = increment_of(r * a, r * b, r * c)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        vl, vd, vh = vl + r * al, vd + r * ad, vh + r * (ah - system.gravity)
        return State(w, x, y, z, vl, vd, vh, pl, pd, ph)

    @scalar
    def forward_euler_late(system, state, read):
        """The same with the sample before: the interval that it acts in ends with this one."""
        before = (state.forward, state.left, state.yaw, state.up, state.roll, state.pitch)
        w, x, y, z, vl, vd, vh, pl, pd, ph = forward_euler(
            system, _moving(state), (*before, read[6])
        )
        return Remembering(w, x, y, z, vl, vd, vh, pl, pd, ph, *_last(state, read))

    @scalar
    def trapezoidal(system, state, read):
        """Half of the turn before the interval's mean acceleration acts, half after it."""
        w, x, y, z = state.w, state.x, state.y, state.z
        vl, vd, vh = state.vl, state.vd, state.vh
        own = complete(read)
        r = own[6]
        f, g, h, a, b, c = _mean(system, state, own)
        d, a, b, c = increment_of(0.5 * a, 0.5 * b, 0.5 * c)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        al, ad, ah = rotate(w, x, y, z, f, g, h)
        al, ad, ah = r * al, r * ad, r * (ah - system.gravity)
        w, x, y, z = compose(w, x, y, z, d, a, b, c)
        return Remembering(
            w,
            x,
            y,
            z,
            vl + al,
            vd + ad,
            vh + ah,
            state.pl + r * (vl + 0.5 * al),
            state.pd + r * (vd + 0.5 * ad),
            state.ph + r * (vh + 0.5 * ah),
            *_last(state, own),
        )

    if complete is as_read:
        return Rules(
            Step(rectangular, State),
            Step(forward_euler_late, Remembering),
            Step(trapezoidal, Remembering),
        )
    return Rules(
        Step(rectangular, State), Step(forward_euler, State), Step(trapezoidal, Remembering)
    )


@scalar
def _moving(x):
    """What the samples move, without the last of them."""
    return State(x.w, x.x, x.y, x.z, x.vl, x.vd, x.vh, x.pl, x.pd, x.ph)


@scalar
def _last(x, own):
    """The last sample that has arrived."""
    forward, left, yaw, up, roll, pitch, r = own
    taken = r != 0.0
    return (
        forward if taken else x.forward,
        left if taken else x.left,
        yaw if taken else x.yaw,
        up if taken else x.up,
        roll if taken else x.roll,
        pitch if taken else x.pitch,
    )


@scalar
def _mean(system, state, own):
    """Mean of two samples over the interval of the second, and their corrections; turns of it all.

    ``system.coning``, 1/12 or none, is the weight of what two neighbouring samples tell of the
    turning within the interval: sculling ``turn_0 x f + f_0 x turn``, coning ``turn_0 x turn``;
    exact for rates that change linearly.
    """
    f0, g0, h0 = state.forward, state.left, state.up
    a0, b0, c0 = state.roll, state.pitch, state.yaw
    f, g, c, h, a, b, r = own
    previous_share, coning = system.previous_share, system.coning
    share = 1.0 - previous_share
    s1, s2, s3 = cross(a0, b0, c0, f, g, h)
    r1, r2, r3 = cross(f0, g0, h0, a, b, c)
    k1, k2, k3 = cross(a0, b0, c0, a, b, c)
    return (
        share * f + previous_share * f0 + coning * (r * (s1 + r1)),
        share * g + previous_share * g0 + coning * (r * (s2 + r2)),
        share * h + previous_share * h0 + coning * (r * (s3 + r3)),
        r * (share * a + previous_share * a0 + coning * (r * k1)),
        r * (share * b + previous_share * b0 + coning * (r * k2)),
        r * (share * c + previous_share * c0 + coning * (r * k3)),
    )


EVEN_LITTLE = _make_steps(increment_little, with_one)
EVEN, VARYING = _make_steps(increment, with_one), _make_steps(increment, as_read)
EVEN_EXACTLY, VARYING_EXACTLY = (_make_steps(increment_exactly, way) for way in (with_one, as_read))
