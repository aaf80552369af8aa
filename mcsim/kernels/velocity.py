"""Velocity by integration of a tri-axial accelerometer, many groups of runs at once.

Groups are the realizations: what is drawn once per group (calibration, rest phase, tilt,
gravity) belongs to all its runs, noise and time errors to every step of every run.  Groups
are integrated side by side, ``LANES`` at a time.

The corrected, tilt-corrected acceleration is linear in the raw output,

    aX = kx (rx - Bx) + ky (ry - By) + kz (rz - Bz),    k = (p lx. - q lz.) g,

with p, q from the tilt: Eq. (15) has p = 1 and q = theta.  So a group needs four numbers
only, and a step eight multiplications.
"""

from __future__ import annotations

import math

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel, scalar
from mcsim.kernels.lanes import (
    LANES,
    WHITE_NOISE,
    draw_constants,
    draw_group,
    seed_lanes,
    take_constants,
)

Array = NDArray[np.float64]

#: What a group draws once: lxx, lxy, lxz, lzx, lzy, lzz, Bx, By, Bz, means of the raw output
#: at rest (x, y, z), the change of tilt, gravity; two spare.
GROUP_INPUTS, DRAWN = 14, 16
_LXX, _LXY, _LXZ, _LZX, _LZY, _LZZ, _BX, _BY, _BZ, _RX, _RY, _RZ, _TILT, _G = range(GROUP_INPUTS)
#: How the tilt enters, as numbers.
FIRST_ORDER, SECOND_ORDER, EXACT = range(3)
#: Steps of four channels (three axes and the interval) that one draw of twelve normals serves.
STEPS = 3

# Rows of the state: factors of the raw output and constant of the acceleration, velocity,
# linear error, the last stamp's normal, and the same for the linear error.
KX, KY, KZ, K0, SPEED, LINEAR, STAMP, LINEAR_STAMP = (LANES * row for row in range(8))
N_STATE = LANES * 8


@scalar
def tilt_factors(theta, order):
    """p and q in aX = (p acx - q acz) g."""
    if order == EXACT:
        return math.cos(theta), math.sin(theta)
    if order == SECOND_ORDER:
        return 1.0 / (1.0 + theta * theta), theta / (1.0 + theta * theta)
    return 1.0, theta


@scalar
def drawn(k, j, inputs, uncertainties, constants):
    """Input ``k`` of lane ``j``: its estimate and what was drawn for it."""
    return inputs[k] + uncertainties[k] * np.float64(constants[k * LANES + j])


@scalar
def _draw_rest(constants, inputs, uncertainties, rest):
    """Mean raw output at rest, rows x, y, z."""
    for axis in range(3):
        for j in range(LANES):
            rest[axis * LANES + j] = drawn(_RX + axis, j, inputs, uncertainties, constants)


@scalar
def start_groups(constants, inputs, uncertainties, order, rest, state):
    """The four numbers of each lane, Eq. (4), (5), (15), (19), (20).

    Rows of ``rest`` are the mean raw output of x, y, z at rest.
    """
    for j in range(LANES):
        x = 0.0
        z = 0.0
        for axis in range(3):
            raw = rest[axis * LANES + j]
            raw -= drawn(_BX + axis, j, inputs, uncertainties, constants)
            x += drawn(_LXX + axis, j, inputs, uncertainties, constants) * raw
            z += drawn(_LZX + axis, j, inputs, uncertainties, constants) * raw
        change = drawn(_TILT, j, inputs, uncertainties, constants)
        p, q = tilt_factors(math.atan2(x, z) + change, order)
        g = drawn(_G, j, inputs, uncertainties, constants)
        k0 = 0.0
        for axis in range(3):
            lx = drawn(_LXX + axis, j, inputs, uncertainties, constants)
            lz = drawn(_LZX + axis, j, inputs, uncertainties, constants)
            k = (p * lx - q * lz) * g
            state[KX + axis * LANES + j] = k
            k0 -= k * drawn(_BX + axis, j, inputs, uncertainties, constants)
        state[K0 + j] = k0


@scalar
def start_run(stamps, normals, state):
    """Standstill; the first of the normals is the first stamp's, if stamps err."""
    for j in range(LANES):
        first_stamp = np.float64(normals[j]) if stamps else 0.0
        state[SPEED + j] = 0.0
        state[LINEAR + j] = 0.0
        state[STAMP + j] = first_stamp
        state[LINEAR_STAMP + j] = first_stamp


@scalar
def step_on(v, e, before, difference, k0, kx, ky, kz, x, y, z, interval, time_error):
    """Velocity after one step, Eq. (24); ``e`` and ``before`` scale the interval's error."""
    step = interval + time_error * (e - difference * before)
    return v + (k0 + kx * x + ky * y + kz * z) * step


@scalar
def _advance_three(i, normals, raw, white, interval, time_error, difference, state):
    """Three steps of every lane's run, all that one draw of normals serves."""
    x0, y0, z0 = raw[i, 0], raw[i, 1], raw[i, 2]
    x1, y1, z1 = raw[i + 1, 0], raw[i + 1, 1], raw[i + 1, 2]
    x2, y2, z2 = raw[i + 2, 0], raw[i + 2, 1], raw[i + 2, 2]
    wx, wy, wz = white[0], white[1], white[2]
    for j in range(LANES):
        k0, kx, ky, kz = state[K0 + j], state[KX + j], state[KY + j], state[KZ + j]
        v = state[SPEED + j]
        before = state[STAMP + j]
        e0 = np.float64(normals[3 * LANES + j])
        e1 = np.float64(normals[7 * LANES + j])
        e2 = np.float64(normals[11 * LANES + j])
        x = x0 + wx * normals[j]
        y = y0 + wy * normals[LANES + j]
        z = z0 + wz * normals[2 * LANES + j]
        v = step_on(v, e0, before, difference, k0, kx, ky, kz, x, y, z, interval, time_error)
        x = x1 + wx * normals[4 * LANES + j]
        y = y1 + wy * normals[5 * LANES + j]
        z = z1 + wz * normals[6 * LANES + j]
        v = step_on(v, e1, e0, difference, k0, kx, ky, kz, x, y, z, interval, time_error)
        x = x2 + wx * normals[8 * LANES + j]
        y = y2 + wy * normals[9 * LANES + j]
        z = z2 + wz * normals[10 * LANES + j]
        v = step_on(v, e2, e1, difference, k0, kx, ky, kz, x, y, z, interval, time_error)
        state[SPEED + j] = v
        state[STAMP + j] = e2


@scalar
def _advance(i, row, normals, raw, white, interval, time_error, difference, state):
    """One step of every lane's run."""
    sx, sy, sz = raw[i, 0], raw[i, 1], raw[i, 2]
    wx, wy, wz = white[0], white[1], white[2]
    for j in range(LANES):
        e = np.float64(normals[row + 3 * LANES + j])
        state[SPEED + j] = step_on(
            state[SPEED + j],
            e,
            state[STAMP + j],
            difference,
            state[K0 + j],
            state[KX + j],
            state[KY + j],
            state[KZ + j],
            sx + wx * normals[row + j],
            sy + wy * normals[row + LANES + j],
            sz + wz * normals[row + 2 * LANES + j],
            interval,
            time_error,
        )
        state[STAMP + j] = e


@scalar
def add_linear(i, row, normals, weights, difference, state):
    """Add the step's share of the linear error; before the step itself, which moves the stamp."""
    a, b, c, d = weights[i, 0], weights[i, 1], weights[i, 2], weights[i, 3]
    for j in range(LANES):
        e = np.float64(normals[row + 3 * LANES + j])
        state[LINEAR + j] += (
            a * normals[row + j]
            + b * normals[row + LANES + j]
            + c * normals[row + 2 * LANES + j]
            + d * (e - difference * state[LINEAR_STAMP + j])
        )
        state[LINEAR_STAMP + j] = e


@kernel
def simulate(
    key: np.uint64,
    first: np.uint64,
    count: int,
    runs: int,
    raw: Array,
    inputs: Array,
    uncertainties: Array,
    white: Array,
    interval: float,
    time_error: float,
    stamps: bool,
    order: int,
    instants: NDArray[np.int64],
    truth: Array,
    step_weights: Array,
    group_weights: Array,
    given: NDArray[np.float32],
    errors: Array,
    linear: Array,
    curves: Array,
) -> None:
    """Velocity errors of ``count`` groups of ``runs`` runs, from group ``first`` on.

    Parameters
    ----------
    key, first : uint64
        Key of the random numbers and index of the first group.
    count, runs : int
    raw : float64 (n, 3)
        Undisturbed raw output of the axes (fractions of g) at the steps.
    inputs, uncertainties : float64 (14,)
        Estimates and standard uncertainties of what a group draws once: lxx, lxy, lxz, lzx,
        lzy, lzz, Bx, By, Bz, mean raw output at rest (x, y, z), tilt change (rad), g (m/s^2).
    white : float64 (3,)
        Standard deviation of one raw sample (fractions of g).
    interval, time_error : float
        Nominal interval between samples and its standard uncertainty (s).
    stamps : bool
        Time stamps err, so that neighbouring intervals err oppositely; else intervals err
        independently.
    order : int
        ``FIRST_ORDER``, ``SECOND_ORDER`` or ``EXACT`` tilt correction.
    instants : int64 (k,)
        Numbers of steps, ascending, after which errors are wanted.
    truth : float64 (k,)
        True velocity then (m/s).
    step_weights : float64 (n, 4)
        Linear error per unit normal of each step's three axes and interval.
    group_weights : float64 (k, 14)
        Linear error at each instant per unit normal of what a group draws once.
    given : float32 (16, count) or (0, 0)
        Normals for what a group draws once, instead of drawing them, unless empty.
    errors : float64 (3 k, count), written
        At each instant: error of the group's first run, error of the mean of all runs,
        sample standard deviation of the runs (m/s).
    linear : float64 (3 k, count) or (3 k, 0), written
        Linear errors of the same (zero for the standard deviation), unless empty.
    curves : float64 (k, runs, count) or (0, 0, 0), written
        Velocities of every run at the instants, unless empty.
    """
    n_instants = len(instants)
    with_linear = linear.shape[1] > 0
    with_curves = curves.shape[0] > 0
    with_given = given.shape[1] > 0
    difference = 1.0 if stamps else 0.0
    stamp_error = time_error * math.sqrt(0.5) if stamps else time_error
    random_state = np.empty(4 * LANES, np.uint32)
    normals = np.empty(12 * LANES, np.float32)
    constants = np.zeros(DRAWN * LANES, np.float32)
    rest = np.empty(3 * LANES, np.float64)
    systematic = np.empty(LANES, np.float64)
    state = np.zeros(N_STATE, np.float64)
    # Sums over the runs, shifted by the first run so that none of the digits is lost.
    sums = np.empty((n_instants, 5, LANES), np.float64)
    for block in range((count + LANES - 1) // LANES):
        start = block * LANES
        filled = min(LANES, count - start)
        block_first = first + uint64(start)
        if with_given:
            take_constants(given, start, filled, DRAWN, constants)
        else:
            draw_constants(key, block_first, DRAWN, constants)
        _draw_rest(constants, inputs, uncertainties, rest)
        start_groups(constants, inputs, uncertainties, order, rest, state)
        seed_lanes(key, block_first, WHITE_NOISE, random_state)
        for run in range(runs):
            if stamps:
                draw_group(random_state, normals)  # the first of them is the first stamp's
            start_run(stamps, normals, state)
            done = 0
            for instant in range(n_instants):
                i = done
                while i < instants[instant]:
                    part = i % STEPS
                    if part == 0:
                        draw_group(random_state, normals)
                    row = 4 * part * LANES
                    size = STEPS if part == 0 and i + STEPS <= instants[instant] else 1
                    if with_linear:
                        for k in range(size):
                            linear_row = row + 4 * k * LANES
                            add_linear(i + k, linear_row, normals, step_weights, difference, state)
                    if size == STEPS:
                        _advance_three(
                            i, normals, raw, white, interval, stamp_error, difference, state
                        )
                    else:
                        _advance(
                            i, row, normals, raw, white, interval, stamp_error, difference, state
                        )
                    i += size
                done = instants[instant]
                keep_run(run, state, sums[instant])
                if with_curves:
                    for j in range(filled):
                        curves[instant, run, start + j] = state[SPEED + j]
        for instant in range(n_instants):
            finish_errors(instant, start, filled, runs, truth[instant], sums[instant], errors)
            if with_linear:
                add_constants(group_weights[instant], constants, systematic)
                finish_linear(instant, start, filled, runs, systematic, sums[instant], linear)


@scalar
def keep_run(run, state, sums):
    """Rows of ``sums``: first run, its linear error; then of the others, as differences to
    the first: sum, sum of squares, sum of linear errors."""
    if run == 0:
        for j in range(LANES):
            sums[0, j] = state[SPEED + j]
            sums[1, j] = state[LINEAR + j]
            sums[2, j] = 0.0
            sums[3, j] = 0.0
            sums[4, j] = 0.0
    else:
        for j in range(LANES):
            more = state[SPEED + j] - sums[0, j]
            sums[2, j] += more
            sums[3, j] += more * more
            sums[4, j] += state[LINEAR + j] - sums[1, j]


@scalar
def finish_errors(instant, start, filled, runs, truth, sums, errors):
    """Errors of the first run and of the mean, and the scatter of the runs."""
    row = 3 * instant
    for j in range(filled):
        mean = sums[2, j] / runs
        errors[row, start + j] = sums[0, j] - truth
        errors[row + 1, start + j] = sums[0, j] + mean - truth
        spread = sums[3, j] - runs * mean * mean
        errors[row + 2, start + j] = math.sqrt(max(spread, 0.0) / (runs - 1)) if runs > 1 else 0.0


@scalar
def add_constants(weights, constants, systematic):
    """Linear error that the constants with weights make, written into ``systematic``."""
    for j in range(LANES):
        total = 0.0
        for k in range(len(weights)):
            total += weights[k] * np.float64(constants[k * LANES + j])
        systematic[j] = total


@scalar
def finish_linear(instant, start, filled, runs, systematic, sums, linear):
    """Linear errors of the same; there is none of the scatter."""
    row = 3 * instant
    for j in range(filled):
        linear[row, start + j] = systematic[j] + sums[1, j]
        linear[row + 1, start + j] = systematic[j] + sums[1, j] + sums[4, j] / runs
        linear[row + 2, start + j] = 0.0
