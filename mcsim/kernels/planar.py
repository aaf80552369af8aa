"""Planar dead reckoning: the system of Eq. (2) and (3) of the planar paper; see ``frame``.

Trigonometry is gone: the heading is a unit vector, turned at each sample by a small angle with a
Taylor polynomial (see ``turn_little`` and ``turn``).  What is left are some 500 vector
instructions for 16 lanes and four samples, two thirds of them for the normals: nearly four cycles
per realization and sample where two units of 512 bits execute them, two where there are four.

The measured channels are forward acceleration, leftward acceleration and turn
(yaw rate times sampling interval), in this order everywhere.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import GROUP, LANES, WHITE_NOISE, draw_constants
from mcsim.kernels.parts import of
from mcsim.kernels.planar_steps import (
    EVEN,
    EVEN_EXACTLY,
    EVEN_LITTLE,
    VARYING,
    VARYING_EXACTLY,
    Remembering,
)
from mcsim.kernels.rotation import (
    LARGEST_TURN,
    LITTLE_TURN,
    angles_from,
    turn,
    turn_exactly,
    wrap,
)
from mcsim.kernels.system import add_linear, begin, draw_once, finish, keep, record, rows_of


class Motion(NamedTuple):
    """Where a vehicle is and moves: along, across (m), speed (m/s), heading, course (rad)."""

    along: float
    across: float
    speed: float
    heading: float
    course: float


class Deviations(NamedTuple):
    """Standard deviations of what a realization draws once, in the order of its constants.

    Offsets of the three channels, then initial speed (m/s), direction, heading, course (rad).
    """

    forward: float
    left: float
    turn: float
    speed: float
    direction: float
    heading: float
    course: float


#: Ways of taking a sample; little turns are taken where there are no offsets.
LITTLE, RECTANGULAR, RECTANGULAR_EXACTLY, TRAPEZOIDAL, TRAPEZOIDAL_EXACTLY = range(5)


class Numbers(NamedTuple):
    """The numbers of the planar system.

    Parameters
    ----------
    way : int
        Number of the step; see ``way_of``.
    interval : float
        Sampling interval T (s).
    previous_share : float
        Weight of the previous sample in the interval's mean, for the trapezoidal rule: 1/2 for
        momentary samples, 0 for samples that are already means over the interval.
    draws : bool
        Whether anything scales what a realization draws once.
    deviations : Deviations
    start, end : Motion
        Truth at sample 0 and at sample n; its course may be NaN there if undefined.
    """

    way: int
    interval: float
    previous_share: float
    draws: bool
    deviations: Deviations
    start: Motion
    end: Motion


@scalar
def _initial(system, constants, j):
    """The motion that a realization believes to start with."""
    start, deviations = system.start, system.deviations
    direction = deviations.direction * constants[4 * LANES + j]
    return Motion(
        start.along,
        start.across,
        start.speed + deviations.speed * constants[3 * LANES + j],
        start.heading + direction + deviations.heading * constants[5 * LANES + j],
        start.course + direction + deviations.course * constants[6 * LANES + j],
    )


@scalar
def _errors(system, motion):
    """Along, across, position, heading, course."""
    end = system.end
    along, across = motion.along - end.along, motion.across - end.across
    return (
        along,
        across,
        math.sqrt(along * along + across * across),
        wrap(motion.heading - end.heading),
        wrap(motion.course - end.course),
    )


@scalar
def _recorded(system, motion):
    """Along, across, velocity along and across, heading."""
    c, s = math.cos(motion.course), math.sin(motion.course)
    return motion.along, motion.across, motion.speed * c, motion.speed * s, motion.heading


def _steps(steps, exact):
    """The steps by way."""
    rectangular, trapezoidal = steps
    return rectangular, rectangular, exact.rectangular, trapezoidal, exact.trapezoidal


class Planar(Numbers):
    """The planar system, as the frame knows it."""

    __slots__ = ()

    STEPS = _steps(EVEN, EVEN_EXACTLY)
    FOURS = {  # noqa: RUF012 - of the class, not of its instances
        LITTLE: EVEN_LITTLE.rectangular._replace(offsets=False),
        RECTANGULAR: EVEN.rectangular,
        TRAPEZOIDAL: EVEN.trapezoidal,
    }
    STATE = len(Remembering._fields)
    CHANNELS = 3
    #: Channels that hold turns per interval.
    TURNS = (2,)
    STREAMS = (WHITE_NOISE,)
    #: Offsets of the channels, initial speed, direction, heading and course, a spare one, then
    #: the noise of sample 0, which the trapezoidal rule uses and which coloured noise starts
    #: from, and a spare one.
    CONSTANTS = 12
    FIXED, FIRST = (0,), (8,)
    #: Along, across, position, heading, course.
    ERRORS = 5
    #: Along, across, course, heading.
    LINEAR = (0, 1, 4, 3)
    #: Along, across, velocity along and across, heading.
    HISTORY = 5
    #: A row for angles at the start and the end.
    SPARE = 1
    #: For algorithms of a user's own: see ``custom``.
    INITIAL, ERRORS_OF, RECORDED = _initial, _errors, _recorded


class TimedPlanar(Planar):
    """The same at intervals that vary; see ``intervals``."""

    __slots__ = ()

    STEPS = _steps(VARYING, VARYING_EXACTLY)
    FOURS = {}  # noqa: RUF012 - of the class, not of its instances
    TIMED = True
    HISTORY = Planar.HISTORY + 1


def way_of(trapezoidal: bool, largest_turn: float, offsets: bool) -> int:
    """Which step to take; ``largest_turn`` (rad) bounds the turn per sample."""
    exact = largest_turn > LARGEST_TURN
    if trapezoidal:
        return TRAPEZOIDAL_EXACTLY if exact else TRAPEZOIDAL
    if exact:
        return RECTANGULAR_EXACTLY
    return LITTLE if largest_turn <= LITTLE_TURN and not offsets else RECTANGULAR


_, _LINEAR, _ANGLE, _ = rows_of(Planar)
_COS, _SIN, _VL, _VD, _PL, _PD, _FORWARD, _, _, _HALF_TURN = (
    LANES * row for row in range(len(Remembering._fields))
)


@of(draw_once, Planar)
def _draw_once(system, key, first, rows, constants):
    draw_constants(key, first, rows, constants)


@scalar
def _turned(direction, angle_row, rows, cos_row, sin_row):
    """Unit vectors at ``direction`` plus each lane's angle (radians, in row ``angle_row``)."""
    c0 = math.cos(direction)
    s0 = math.sin(direction)
    for j in range(LANES):
        rows[cos_row + j], rows[sin_row + j] = turn(c0, s0, rows[angle_row + j])
    for j in range(LANES):
        if abs(rows[angle_row + j]) > LARGEST_TURN:
            c, s = turn_exactly(c0, s0, rows[angle_row + j])
            rows[cos_row + j], rows[sin_row + j] = c, s


@of(begin, Planar)
def _begin(system, constants, sensors, scratch, rows):
    deviations, start, interval = system.deviations, system.start, system.interval
    for j in range(LANES):
        direction = deviations.direction * constants[4 * LANES + j]
        rows[_ANGLE + j] = direction + deviations.course * constants[6 * LANES + j]
        rows[_HALF_TURN + j] = direction + deviations.heading * constants[5 * LANES + j]
    _turned(start.heading, _HALF_TURN, rows, _COS, _SIN)
    _turned(start.course, _ANGLE, rows, _VL, _VD)
    for j in range(LANES):
        speed = (start.speed + deviations.speed * constants[3 * LANES + j]) / interval
        rows[_VL + j] *= speed
        rows[_VD + j] *= speed
        rows[_PL + j] = start.along / (interval * interval)
        rows[_PD + j] = start.across / (interval * interval)
        rows[_HALF_TURN + j] = 0.0


@of(keep, Planar)
def _keep(system, constants, measured, rows):
    for j in range(3 * LANES):
        rows[_FORWARD + j] = measured[j]


@scalar
def _add_linear_of_one(i, row, normals, sensitivity, rows):
    """Add sample ``i``'s noise, whose normals begin at ``row``, to the linear errors."""
    a0, a1, a2 = sensitivity[i, 0], sensitivity[i, 1], sensitivity[i, 2]
    b0, b1, b2 = sensitivity[i, 3], sensitivity[i, 4], sensitivity[i, 5]
    c0, c1, c2 = sensitivity[i, 6], sensitivity[i, 7], sensitivity[i, 8]
    h2 = sensitivity[i, 9]
    for j in range(LANES):
        x = np.float64(normals[row + j])
        y = np.float64(normals[row + LANES + j])
        z = np.float64(normals[row + 2 * LANES + j])
        rows[_LINEAR + j] += a0 * x + a1 * y + a2 * z
        rows[_LINEAR + LANES + j] += b0 * x + b1 * y + b2 * z
        rows[_LINEAR + 2 * LANES + j] += c0 * x + c1 * y + c2 * z
        rows[_LINEAR + 3 * LANES + j] += h2 * z


@scalar
def _add_linear_of_two(i, row, normals, sensitivity, rows):
    """The same for samples ``i`` and ``i + 1``: half of the loads and stores."""
    a0, a1, a2 = sensitivity[i, 0], sensitivity[i, 1], sensitivity[i, 2]
    b0, b1, b2 = sensitivity[i, 3], sensitivity[i, 4], sensitivity[i, 5]
    c0, c1, c2 = sensitivity[i, 6], sensitivity[i, 7], sensitivity[i, 8]
    g2 = sensitivity[i, 9]
    i += 1
    d0, d1, d2 = sensitivity[i, 0], sensitivity[i, 1], sensitivity[i, 2]
    e0, e1, e2 = sensitivity[i, 3], sensitivity[i, 4], sensitivity[i, 5]
    f0, f1, f2 = sensitivity[i, 6], sensitivity[i, 7], sensitivity[i, 8]
    h2 = sensitivity[i, 9]
    for j in range(LANES):
        a = rows[_LINEAR + j]
        b = rows[_LINEAR + LANES + j]
        c = rows[_LINEAR + 2 * LANES + j]
        h = rows[_LINEAR + 3 * LANES + j]
        x = np.float64(normals[row + j])
        y = np.float64(normals[row + LANES + j])
        z = np.float64(normals[row + 2 * LANES + j])
        a = a + a0 * x
        b = b + b0 * x
        c = c + c0 * x
        a = a + a1 * y
        b = b + b1 * y
        c = c + c1 * y
        a = a + a2 * z
        b = b + b2 * z
        c = c + c2 * z
        h = h + g2 * z
        x = np.float64(normals[row + 3 * LANES + j])
        y = np.float64(normals[row + 4 * LANES + j])
        z = np.float64(normals[row + 5 * LANES + j])
        a = a + d0 * x
        b = b + e0 * x
        c = c + f0 * x
        a = a + d1 * y
        b = b + e1 * y
        c = c + f1 * y
        a = a + d2 * z
        b = b + e2 * z
        c = c + f2 * z
        h = h + h2 * z
        rows[_LINEAR + j] = a
        rows[_LINEAR + LANES + j] = b
        rows[_LINEAR + 2 * LANES + j] = c
        rows[_LINEAR + 3 * LANES + j] = h


@of(add_linear, Planar)
def _add_linear(system, way, i, k, until, normals, weights, rows):
    if until - k == GROUP:
        _add_linear_of_two(i, 0, normals, weights, rows)
        _add_linear_of_two(i + 2, 6 * LANES, normals, weights, rows)
    else:
        for sample in range(k, until):
            _add_linear_of_one(i + sample, 3 * sample * LANES, normals, weights, rows)


@of(record, Planar)
def _record(system, number, asked, start, filled, rows, errors, linear, history):
    """The heading at a sample is half a turn past its mid-interval value."""
    interval = system.interval
    for j in range(filled):
        history[0, asked, start + j] = interval * interval * rows[_PL + j]
        history[1, asked, start + j] = interval * interval * rows[_PD + j]
        history[2, asked, start + j] = interval * rows[_VL + j]
        history[3, asked, start + j] = interval * rows[_VD + j]
        heading = math.atan2(rows[_SIN + j], rows[_COS + j]) + rows[_HALF_TURN + j]
        history[4, asked, start + j] = heading


@of(finish, Planar)
def _finish(system, rows, start, filled, errors):
    end, t2 = system.end, system.interval * system.interval
    for j in range(filled):
        along = t2 * rows[_PL + j] - end.along
        across = t2 * rows[_PD + j] - end.across
        errors[0, start + j] = along
        errors[1, start + j] = across
        errors[2, start + j] = math.sqrt(along * along + across * across)
    angles_from(end.heading, _COS, _SIN, rows, _ANGLE)
    for j in range(filled):
        errors[3, start + j] = wrap(rows[_ANGLE + j] + rows[_HALF_TURN + j])
    angles_from(end.course, _VL, _VD, rows, _ANGLE)
    for j in range(filled):
        errors[4, start + j] = rows[_ANGLE + j]
