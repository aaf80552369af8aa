"""Strapdown dead reckoning in space: the system of the application note; see ``frame``.

The measured specific force is turned into the level frame and gravity is added,
``a_I = R a_m - (0, 0, g)`` (height counts upwards here, downwards in the note), then summed to
velocity and position.  The attitude is a unit quaternion, turned at each sample by a rotation
vector (see ``quaternion``).  Four rules share everything else:

* rectangular: attitude, velocity, position, each from the one before: in the plane this is
  the planar kernel's recursion, Eq. (2)-(3) of the planar paper.
* forward Euler: position, velocity, attitude, each from the old values: the note's
  ``v[k+1] = v[k] + T a_I[k]``, ``r[k+1] = r[k] + T v[k]``.  Its sample k stands in row k + 1.
* trapezoidal: interval means turned by the mid-interval attitude; second order.
* two-sample: the same with the coning and sculling terms of two neighbouring samples
  (Savage, "Strapdown inertial navigation integration algorithm design", 1998).

Random numbers: forward and left acceleration and yaw rate take the planar system's streams,
so that on a level road with a stiff vehicle both see the same noise; the other three
channels take streams of their own.  Channels are ordered accordingly, everywhere: forward,
left, yaw turn, then up, roll turn, pitch turn (turns are rates times sampling interval).
"""

from __future__ import annotations

import math

import numpy as np

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import CONSTANTS, GROUP, LANES, draw_normals
from mcsim.kernels.measurement import expect_after_rest, mean_at_rest
from mcsim.kernels.parts import of
from mcsim.kernels.quaternion import LOCKED
from mcsim.kernels.rotation import LARGEST_TURN, angles_from, turn, turn_exactly, wrap
from mcsim.kernels.strapdown_system import (
    AT_ORIGIN,
    COURSE,
    DIRECTION,
    FIRST_OF_REST,
    FIRST_PLANAR,
    FIRST_SPATIAL,
    HEADING,
    MIXING_CONSTANTS,
    NO_DEVIATIONS,
    PITCH,
    REST,
    ROLL,
    SPATIAL,
    SPATIAL_CONSTANTS,
    SPEED,
    TURNS,
    Deviations,
    Force,
    Motion,
    Strapdown,
    TimedStrapdown,
    way_of,
)
from mcsim.kernels.system import add_linear, begin, draw_once, finish, keep, record, rows_of

__all__ = [
    "AT_ORIGIN",
    "COURSE",
    "DIRECTION",
    "FIRST_PLANAR",
    "FIRST_SPATIAL",
    "HEADING",
    "NO_DEVIATIONS",
    "PITCH",
    "REST",
    "ROLL",
    "SPATIAL",
    "SPEED",
    "TURNS",
    "Deviations",
    "Force",
    "Motion",
    "Strapdown",
    "TimedStrapdown",
    "way_of",
]

_OFFSETS, _LINEAR, _SPARE, _ = rows_of(Strapdown)
_W, _X, _Y, _Z, _VL, _VD, _VH, _PL, _PD, _PH, _PREVIOUS = (LANES * row for row in range(11))
_A, _B, _C, _D, _E, _F, _G, _H = (_SPARE + LANES * row for row in range(8))


@of(draw_once, Strapdown)
def _draw_once(system, key, first, rows, constants):
    half = 12
    draw_normals(key, first, CONSTANTS, half, constants)
    draw_normals(key, first, SPATIAL_CONSTANTS, half, constants[half * LANES :])
    draw_normals(key, first, MIXING_CONSTANTS, rows - 2 * half, constants[2 * half * LANES :])


@scalar
def _turned_halves(angle, extra_row, rows, cos_row, sin_row):
    """Cosines and sines of half of ``angle`` plus each lane's own (radians)."""
    c0 = math.cos(0.5 * angle)
    s0 = math.sin(0.5 * angle)
    for j in range(LANES):
        rows[cos_row + j], rows[sin_row + j] = turn(c0, s0, 0.5 * rows[extra_row + j])
    for j in range(LANES):
        if abs(rows[extra_row + j]) > LARGEST_TURN:
            c, s = turn_exactly(c0, s0, 0.5 * rows[extra_row + j])
            rows[cos_row + j], rows[sin_row + j] = c, s


@scalar
def _start_motion(system, constants, rows):
    """Velocity and position rows; the direction error turns the velocity about the vertical."""
    deviations, start, interval = system.deviations, system.start, system.interval
    for j in range(LANES):
        direction = deviations.direction * constants[DIRECTION * LANES + j]
        course = deviations.course * constants[COURSE * LANES + j]
        # Twice the angle: the rows get cosine and sine of its half.
        rows[_A + j] = 2.0 * (direction + course)
        heading = deviations.heading * constants[HEADING * LANES + j]
        rows[_B + j] = direction + heading
    _turned_halves(2.0 * start.course, _A, rows, _VL, _VD)
    cos_climb = math.cos(start.climb)
    sin_climb = math.sin(start.climb)
    t2 = interval * interval
    for j in range(LANES):
        speed = (start.speed + deviations.speed * constants[SPEED * LANES + j]) / interval
        rows[_VL + j] *= speed * cos_climb
        rows[_VD + j] *= speed * cos_climb
        rows[_VH + j] = speed * sin_climb
        rows[_PL + j] = start.along / t2
        rows[_PD + j] = start.across / t2
        rows[_PH + j] = start.height / t2


@scalar
def _mean_at_rest(axis, system, constants, terms, scratch, rows):
    """Mean measured specific force at rest of one axis (0, 1, 2), into the rows E, F or G.

    It holds the offset that the sensor keeps, what mixing makes of gravity, in-run noise, and
    the digital output's steps and limits.
    """
    channel = 3 if axis == 2 else axis
    coefficients, hidden = scratch[0], scratch[3]
    own = rows[_E + axis * LANES : _E + (axis + 1) * LANES]
    deviation = system.deviations[FIRST_OF_REST + axis]
    for j in range(LANES):
        noise = deviation * constants[(REST + axis) * LANES + j]
        own[j] = system.rest[axis] + rows[_OFFSETS + channel * LANES + j] + noise
    for entry in range(len(terms.mix_to)):
        if terms.mix_to[entry] == channel:
            value = terms.mix_levelled[entry]
            mixed = coefficients[entry * LANES : (entry + 1) * LANES]
            for j in range(LANES):
                own[j] += mixed[j] * value
    if len(hidden) > 0:
        samples, spread = terms.rest_samples[1], terms.levelling_spread[channel]
        largest, resolution = terms.ranges[channel], terms.resolutions[channel]
        row = (len(terms.mix_to) + 12 + channel) * LANES
        for j in range(LANES):
            mean = mean_at_rest(
                own[j] + hidden[channel * LANES + j],
                coefficients[row + j],
                samples,
                spread,
                largest,
                resolution,
            )
            own[j] = mean - hidden[(6 + channel) * LANES + j]


@scalar
def _level(system, constants, terms, scratch, rows):
    """Roll and pitch errors (rows C, D) that levelling by the mean specific force at rest makes.

    ``roll = atan2(left, up)``, ``pitch = atan2(-forward, |(left, up)|)``.
    """
    start = system.start
    for axis in range(3):
        _mean_at_rest(axis, system, constants, terms, scratch, rows)
    for j in range(LANES):
        forward, left, up = rows[_E + j], rows[_F + j], rows[_G + j]
        across = math.sqrt(left * left + up * up)
        rows[_C + j] += wrap(math.atan2(left, up) - start.roll)
        rows[_D + j] += wrap(math.atan2(-forward, across) - start.pitch)


@scalar
def _start_attitude(start, rows):
    """Quaternion rows from true angles and errors in the rows _C, _D, _B."""
    _turned_halves(start.roll, _C, rows, _E, _F)
    _turned_halves(start.pitch, _D, rows, _G, _H)
    _turned_halves(start.heading, _B, rows, _C, _D)
    for j in range(LANES):
        cr, sr = rows[_E + j], rows[_F + j]
        cp, sp = rows[_G + j], rows[_H + j]
        ch, sh = rows[_C + j], rows[_D + j]
        rows[_W + j] = cr * cp * ch + sr * sp * sh
        rows[_X + j] = sr * cp * ch - cr * sp * sh
        rows[_Y + j] = cr * sp * ch + sr * cp * sh
        rows[_Z + j] = cr * cp * sh - sr * sp * ch


@of(begin, Strapdown)
def _begin(system, constants, sensors, scratch, rows):
    deviations, start, terms = system.deviations, system.start, sensors.terms
    _start_motion(system, constants, rows)
    for j in range(LANES):
        rows[_C + j] = deviations.roll * constants[ROLL * LANES + j]
        rows[_D + j] = deviations.pitch * constants[PITCH * LANES + j]
    if system.levelled:
        _level(system, constants, terms, scratch, rows)
        if terms.innovation.shape[0] > 0:
            for axis in range(3):
                normals = constants[(REST + axis) * LANES : (REST + axis + 1) * LANES]
                expect_after_rest(3 if axis == 2 else axis, normals, terms, scratch[1])
    _start_attitude(start, rows)


@of(keep, Strapdown)
def _keep(system, constants, measured, rows):
    for j in range(6 * LANES):
        rows[_PREVIOUS + j] = measured[j]


@of(add_linear, Strapdown)
def _add_linear(system, way, i, k, until, normals, weights, rows):
    # Rows count from a slice: LLVM then knows that none is negative.
    own = normals[3 * k * LANES :]
    for sample in range(until - k):
        _add_linear_of_one(i + k + sample, 3 * sample * LANES, own, weights, rows)


@scalar
def _add_linear_of_one(i, row, normals, sensitivity, rows):
    """One loop over lanes, written out: each normal is read and converted once."""
    further = row + 3 * GROUP * LANES
    w = sensitivity[i]
    a0, a1, a2, a3, a4, a5 = w[0], w[1], w[2], w[3], w[4], w[5]
    b0, b1, b2, b3, b4, b5 = w[6], w[7], w[8], w[9], w[10], w[11]
    c0, c1, c2, c3, c4, c5 = w[12], w[13], w[14], w[15], w[16], w[17]
    d0, d1, d2, d3, d4, d5 = w[18], w[19], w[20], w[21], w[22], w[23]
    e2, e4, e5 = w[24], w[25], w[26]
    f2, f4, f5 = w[27], w[28], w[29]
    g2, g4, g5 = w[30], w[31], w[32]
    for j in range(LANES):
        x0 = np.float64(normals[row + j])
        x1 = np.float64(normals[row + LANES + j])
        x2 = np.float64(normals[row + 2 * LANES + j])
        x3 = np.float64(normals[further + j])
        x4 = np.float64(normals[further + LANES + j])
        x5 = np.float64(normals[further + 2 * LANES + j])
        to = _LINEAR + j
        rows[to] += a0 * x0 + a1 * x1 + a2 * x2 + a3 * x3 + a4 * x4 + a5 * x5
        rows[to + LANES] += b0 * x0 + b1 * x1 + b2 * x2 + b3 * x3 + b4 * x4 + b5 * x5
        rows[to + 2 * LANES] += c0 * x0 + c1 * x1 + c2 * x2 + c3 * x3 + c4 * x4 + c5 * x5
        rows[to + 3 * LANES] += d0 * x0 + d1 * x1 + d2 * x2 + d3 * x3 + d4 * x4 + d5 * x5
        rows[to + 4 * LANES] += e2 * x2 + e4 * x4 + e5 * x5
        rows[to + 5 * LANES] += f2 * x2 + f4 * x4 + f5 * x5
        rows[to + 6 * LANES] += g2 * x2 + g4 * x4 + g5 * x5


@scalar
def _axes(rows):
    """Direction cosines that Euler angles need: forward and up as rows _A ... _E.

    _A, _B, _C: the forward axis along, across, upwards; _D, _E: the left and up axes upwards.
    """
    for j in range(LANES):
        w, x, y, z = rows[_W + j], rows[_X + j], rows[_Y + j], rows[_Z + j]
        rows[_A + j] = 1.0 - 2.0 * (y * y + z * z)
        rows[_B + j] = 2.0 * (x * y + w * z)
        rows[_C + j] = 2.0 * (x * z - w * y)
        rows[_D + j] = 2.0 * (y * z + w * x)
        rows[_E + j] = 1.0 - 2.0 * (x * x + y * y)


@scalar
def _unlock(rows):
    """Euler angles' convention where the pitch is ±90°: no roll, the heading turns it all."""
    for j in range(LANES):
        forward = rows[_A + j] * rows[_A + j] + rows[_B + j] * rows[_B + j]
        if forward < LOCKED * LOCKED:
            w, x, y, z = rows[_W + j], rows[_X + j], rows[_Y + j], rows[_Z + j]
            rows[_A + j] = 1.0 - 2.0 * (x * x + z * z)
            rows[_B + j] = 2.0 * (w * z - x * y)
            rows[_D + j] = 0.0
            rows[_E + j] = 1.0
            rows[_F + j] = 0.0
        else:
            rows[_F + j] = math.sqrt(forward)


@of(record, Strapdown)
def _record(system, number, asked, start, filled, rows, errors, linear, history):
    interval = system.interval
    t2 = interval * interval
    _axes(rows)
    _unlock(rows)
    for j in range(filled):
        history[0, asked, start + j] = t2 * rows[_PL + j]
        history[1, asked, start + j] = t2 * rows[_PD + j]
        history[2, asked, start + j] = t2 * rows[_PH + j]
        history[3, asked, start + j] = interval * rows[_VL + j]
        history[4, asked, start + j] = interval * rows[_VD + j]
        history[5, asked, start + j] = interval * rows[_VH + j]
        history[6, asked, start + j] = math.atan2(rows[_D + j], rows[_E + j])
        history[7, asked, start + j] = math.atan2(-rows[_C + j], rows[_F + j])
        history[8, asked, start + j] = math.atan2(rows[_B + j], rows[_A + j])


@of(finish, Strapdown)
def _finish(system, rows, start, filled, errors):
    end, t2 = system.end, system.interval * system.interval
    for j in range(filled):
        along = t2 * rows[_PL + j] - end.along
        across = t2 * rows[_PD + j] - end.across
        height = t2 * rows[_PH + j] - end.height
        errors[0, start + j] = along
        errors[1, start + j] = across
        errors[2, start + j] = height
        errors[3, start + j] = math.sqrt(along * along + across * across + height * height)
    _axes(rows)
    _unlock(rows)
    for j in range(LANES):
        rows[_C + j] = -rows[_C + j]
    angles_from(end.roll, _E, _D, rows, _G)
    angles_from(end.pitch, _F, _C, rows, _H)
    for j in range(filled):
        errors[4, start + j] = rows[_G + j]
        errors[5, start + j] = rows[_H + j]
    angles_from(end.heading, _A, _B, rows, _G)
    angles_from(end.course, _VL, _VD, rows, _H)
    for j in range(filled):
        errors[6, start + j] = rows[_G + j]
        errors[7, start + j] = rows[_H + j]
