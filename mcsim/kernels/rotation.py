"""Unit vectors in place of angles: turned at every sample, read as angles at the end."""

from __future__ import annotations

import math

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import LANES

#: Largest turn per sample (rad) that ``turn_little`` and ``turn`` are used for: they
#: err by less than 7e-15 and 3e-10 there.
LITTLE_TURN, LARGEST_TURN = 0.004, 0.5


@scalar
def turn_little(c, s, angle):
    """Rotate (c, s) by a small angle: Taylor series to the 4th order, error |angle|^5 / 120."""
    q = angle * angle
    sin_a = angle + angle * q * (-1 / 6)
    cos_a_less_1 = q * (-1 / 2 + q * (1 / 24))
    return c + c * cos_a_less_1 - s * sin_a, s + s * cos_a_less_1 + c * sin_a


@scalar
def turn(c, s, angle):
    """Rotate (c, s) by an angle: Taylor series to the 9th order, error |angle|^10 / 10!."""
    q = angle * angle
    sin_a = angle + angle * q * (-1 / 6 + q * (1 / 120 + q * (-1 / 5040 + q * (1 / 362880))))
    cos_a_less_1 = q * (-1 / 2 + q * (1 / 24 + q * (-1 / 720 + q * (1 / 40320))))
    return c + c * cos_a_less_1 - s * sin_a, s + s * cos_a_less_1 + c * sin_a


@scalar
def turn_exactly(c, s, angle):
    """Rotate (c, s) by an angle of any size."""
    cos_a = math.cos(angle)
    sin_a = math.sin(angle)
    return c * cos_a - s * sin_a, s * cos_a + c * sin_a


@scalar
def wrap(angle):
    """Angle in (-pi, pi]."""
    turns = math.ceil((angle - math.pi) / (2.0 * math.pi))
    return angle - 2.0 * math.pi * turns


@scalar
def angles_from(direction, x_row, y_row, state, angle_row):
    """Angles of the lanes' vectors from a direction, in (-pi, pi].

    A first guess from the tangent is corrected by what a turn back by it leaves:
    exact to rounding below 0.4 rad; the few lanes beyond use the arc tangent.
    """
    c0 = math.cos(direction)
    s0 = math.sin(direction)
    for j in range(LANES):
        c = c0 * state[x_row + j] + s0 * state[y_row + j]
        s = c0 * state[y_row + j] - s0 * state[x_row + j]
        tangent = s / c
        guess = tangent - tangent * tangent * tangent * (1 / 3)
        c, s = turn(c, s, -guess)
        rest = s / c
        q = rest * rest
        state[angle_row + j] = guess + (rest + rest * q * (-1 / 3 + q * (1 / 5)))
    for j in range(LANES):
        c = c0 * state[x_row + j] + s0 * state[y_row + j]
        s = c0 * state[y_row + j] - s0 * state[x_row + j]
        if not abs(s) < 0.4 * c:
            state[angle_row + j] = math.atan2(s, c)
