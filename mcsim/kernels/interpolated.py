"""Planar dead reckoning between samples: cubics through four neighbours, integrated by Gauss nodes.

The signals of the interval from sample ``i - 2`` to ``i - 1`` are the cubics through the samples
``i - 3 ... i``; heading, velocity and position are the integrals of these, with two nodes of Gauss
and Legendre, which leaves an error of the fourth order.  A step therefore integrates the interval
*before* its sample: what is known of a sample by cubics is known one sample later.  What must be
known at once, and the end of a run, extrapolates the next sample by the parabola through the last
three; so does the beginning, backwards.

Samples are momentary values.  White noise gains nothing and loses nothing: each sample counts with
the weight of one interval, but for the first and last few.

One polynomial serves turns of all sizes up to ``LARGEST_TURN``, which is more than a sample of any
use has.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from mcsim.kernels.compilation import scalar
from mcsim.kernels.custom import Custom
from mcsim.kernels.parts import of
from mcsim.kernels.planar import Motion, Planar
from mcsim.kernels.system import Step, begin


class State(NamedTuple):
    """Heading vector, velocity (m/s) and position (m) one sample ago, and the last three samples.

    ``age`` counts the steps, up to two.
    """

    c: float
    s: float
    u: float
    v: float
    along: float
    across: float
    forward_0: float
    left_0: float
    turn_0: float
    forward_1: float
    left_1: float
    turn_1: float
    forward_2: float
    left_2: float
    turn_2: float
    age: float


#: Gauss nodes of the interval from 0 to 1, of equal weights.
EARLY, LATE = 0.5 - math.sqrt(3.0) / 6.0, 0.5 + math.sqrt(3.0) / 6.0


def value_weights(x):
    """Weights of the samples at -1, 0, 1, 2 in the value of their cubic at ``x`` (Lagrange)."""
    return (
        -x * (x - 1.0) * (x - 2.0) / 6.0,
        (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0,
        -(x + 1.0) * x * (x - 2.0) / 2.0,
        (x + 1.0) * x * (x - 1.0) / 6.0,
    )


def integral_weights(x):
    """Weights of the same samples in the integral of their cubic from 0 to ``x``."""
    a, b, c = x**4 / 4.0, x**3 / 3.0, x**2 / 2.0
    return (
        -(a - 3.0 * b + 2.0 * c) / 6.0,
        (a - 2.0 * b - c + 2.0 * x) / 2.0,
        -(a - b - 2.0 * c) / 2.0,
        (a - c) / 6.0,
    )


_VALUE_EARLY, _VALUE_LATE = value_weights(EARLY), value_weights(LATE)
_TURN_EARLY, _TURN_LATE = integral_weights(EARLY), integral_weights(LATE)
_TURN_WHOLE = integral_weights(1.0)


#: Largest turn within an interval (rad) that is turned by; it errs by less than 7e-8 there.
LARGEST_TURN = 3.0
#: By which a cubic's integral may exceed the largest of its samples.
OVERSHOOT = 7.0 / 6.0
_SINE = [(-1.0) ** k / math.factorial(2 * k + 1) for k in range(9)]
_COSINE = [(-1.0) ** k / math.factorial(2 * k) for k in range(1, 9)]
_S0, _S1, _S2, _S3, _S4, _S5, _S6, _S7, _S8 = _SINE
_C1, _C2, _C3, _C4, _C5, _C6, _C7, _C8 = _COSINE


@scalar
def _turned(c, s, angle):
    """Rotate (c, s) by an angle: Taylor series to the 17th order, error |angle|^18 / 18!."""
    q = angle * angle
    sine = _S4 + q * (_S5 + q * (_S6 + q * (_S7 + q * _S8)))
    sine = angle * (_S0 + q * (_S1 + q * (_S2 + q * (_S3 + q * sine))))
    cosine = _C4 + q * (_C5 + q * (_C6 + q * (_C7 + q * _C8)))
    cosine_less_1 = q * (_C1 + q * (_C2 + q * (_C3 + q * cosine)))
    return c + c * cosine_less_1 - s * sine, s + s * cosine_less_1 + c * sine


@scalar
def _weighed(weights, a, b, c, d):
    return weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d


@scalar
def _before(a, b, c):
    """The sample before three, on the parabola through them."""
    return 3.0 * (a - b) + c


@scalar
def _interval(system, x, first, second, third, fourth):
    """The interval between the middle two of four samples, from the motion at its beginning."""
    t = system.interval
    f0, l0, w0 = first
    f1, l1, w1 = second
    f2, l2, w2 = third
    f3, l3, w3 = fourth
    c1, s1 = _turned(x.c, x.s, _weighed(_TURN_EARLY, w0, w1, w2, w3))
    c2, s2 = _turned(x.c, x.s, _weighed(_TURN_LATE, w0, w1, w2, w3))
    c, s = _turned(x.c, x.s, _weighed(_TURN_WHOLE, w0, w1, w2, w3))
    fe, le = _weighed(_VALUE_EARLY, f0, f1, f2, f3), _weighed(_VALUE_EARLY, l0, l1, l2, l3)
    fl, ll = _weighed(_VALUE_LATE, f0, f1, f2, f3), _weighed(_VALUE_LATE, l0, l1, l2, l3)
    # Velocity gained at each node; an early gain acts on the position for longer.
    ue, ve = 0.5 * t * (c1 * fe - s1 * le), 0.5 * t * (s1 * fe + c1 * le)
    ul, vl = 0.5 * t * (c2 * fl - s2 * ll), 0.5 * t * (s2 * fl + c2 * ll)
    along = x.along + t * (x.u + (1.0 - EARLY) * ue + (1.0 - LATE) * ul)
    across = x.across + t * (x.v + (1.0 - EARLY) * ve + (1.0 - LATE) * vl)
    return c, s, x.u + (ue + ul), x.v + (ve + vl), along, across


@scalar
def _step(system, x, read):
    f, l, w = read  # noqa: E741 - left
    first, second = x.age < 0.5, x.age < 1.5
    f0 = _before(x.forward_1, x.forward_2, f) if second else x.forward_0
    l0 = _before(x.left_1, x.left_2, l) if second else x.left_0
    w0 = _before(x.turn_1, x.turn_2, w) if second else x.turn_0
    c, s, u, v, along, across = _interval(
        system,
        x,
        (f0, l0, w0),
        (x.forward_1, x.left_1, x.turn_1),
        (x.forward_2, x.left_2, x.turn_2),
        read,
    )
    # There is no interval before sample 0.
    return State(
        x.c if first else c,
        x.s if first else s,
        x.u if first else u,
        x.v if first else v,
        x.along if first else along,
        x.across if first else across,
        x.forward_1,
        x.left_1,
        x.turn_1,
        x.forward_2,
        x.left_2,
        x.turn_2,
        f,
        l,
        w,
        x.age + 1.0 if second else x.age,
    )


@scalar
def _start(system, motion, read):
    forward, left, angle = read
    c, s = math.cos(motion.heading), math.sin(motion.heading)
    u, v = motion.speed * math.cos(motion.course), motion.speed * math.sin(motion.course)
    return State(
        c, s, u, v, motion.along, motion.across,
        forward, left, angle, forward, left, angle, forward, left, angle, 0.0,
    )  # fmt: skip


@scalar
def _end(system, x):
    """The motion at the last sample; its interval has no sample after it yet."""
    c, s, u, v, along, across = x.c, x.s, x.u, x.v, x.along, x.across
    if x.age > 0.5:
        f0, l0, w0 = x.forward_0, x.left_0, x.turn_0
        if x.age < 1.5:  # two samples: the straight line through them
            f0, l0 = 2.0 * x.forward_1 - x.forward_2, 2.0 * x.left_1 - x.left_2
            w0 = 2.0 * x.turn_1 - x.turn_2
        after = (
            _before(x.forward_2, x.forward_1, f0),
            _before(x.left_2, x.left_1, l0),
            _before(x.turn_2, x.turn_1, w0),
        )
        c, s, u, v, along, across = _interval(
            system,
            x,
            (f0, l0, w0),
            (x.forward_1, x.left_1, x.turn_1),
            (x.forward_2, x.left_2, x.turn_2),
            after,
        )
    return Motion(along, across, math.sqrt(u * u + v * v), math.atan2(s, c), math.atan2(v, u))


_TAKEN = Step(_step, State)


class Interpolated(Custom, Planar):
    """The planar system with signals that are interpolated between samples."""

    __slots__ = ()

    STEPS = (_TAKEN,)
    FOURS = {0: _TAKEN}  # noqa: RUF012 - of the class, not of its instances
    STATE = len(State._fields)
    START, END = staticmethod(_start), staticmethod(_end)


@of(begin, Interpolated)
def _begin(system, constants, sensors, scratch, rows):
    """Nothing: the state begins with what is measured at sample 0."""
