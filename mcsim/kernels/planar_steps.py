"""One sample of the planar system: the two rules, at even intervals and at varying ones.

A step reads the channels and the interval before the sample in sampling intervals; where they are
even it is the number one, which the compiler leaves out.
"""

from __future__ import annotations

from typing import NamedTuple

from mcsim.kernels.compilation import scalar
from mcsim.kernels.rotation import turn, turn_exactly, turn_little
from mcsim.kernels.system import Step, as_read, with_one


class State(NamedTuple):
    """Heading vector, velocity and position, these divided by the interval and its square."""

    c: float
    s: float
    vl: float
    vd: float
    pl: float
    pd: float


class Remembering(NamedTuple):
    """The same, then the last sample's channels and half of the last interval's turn."""

    c: float
    s: float
    vl: float
    vd: float
    pl: float
    pd: float
    forward: float
    left: float
    yaw: float
    half_turn: float


class Rules(NamedTuple):
    """Steps of the two rules."""

    rectangular: Step
    trapezoidal: Step


def _make_steps(turn_by, complete):
    """The two rules' steps, with the given way of turning the heading."""

    @scalar
    def rectangular(system, x, read):
        """Eq. (2), (3): new heading first, then velocity, then position."""
        forward, left, angle, r = complete(read)
        c, s = turn_by(x.c, x.s, r * angle)
        vl = x.vl + c * (r * forward)
        vl = vl - s * (r * left)
        vd = x.vd + s * (r * forward)
        vd = vd + c * (r * left)
        return State(c, s, vl, vd, x.pl + r * vl, x.pd + r * vd)

    @scalar
    def trapezoidal(system, x, read):
        """The mid-interval heading turns the interval's mean acceleration."""
        forward, left, angle, r = complete(read)
        before = system.previous_share
        share = 1.0 - before
        half_turn = 0.5 * (r * (share * angle + before * x.yaw))
        # From the middle of the last interval to the middle of this one.
        c, s = turn_by(x.c, x.s, x.half_turn + half_turn)
        f = r * (share * forward + before * x.forward)
        g = r * (share * left + before * x.left)
        al = c * f - s * g
        ad = s * f + c * g
        taken = r != 0.0
        return Remembering(
            c,
            s,
            x.vl + al,
            x.vd + ad,
            x.pl + r * (x.vl + 0.5 * al),
            x.pd + r * (x.vd + 0.5 * ad),
            forward if taken else x.forward,
            left if taken else x.left,
            angle if taken else x.yaw,
            half_turn,
        )

    return Rules(Step(rectangular, State), Step(trapezoidal, Remembering))


EVEN_LITTLE = _make_steps(turn_little, with_one)
EVEN, VARYING = _make_steps(turn, with_one), _make_steps(turn, as_read)
EVEN_EXACTLY, VARYING_EXACTLY = (_make_steps(turn_exactly, way) for way in (with_one, as_read))
