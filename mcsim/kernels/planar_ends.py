"""Begin and end of the planar kernel's blocks, their linear errors and recorded states."""

from __future__ import annotations

import math

import numpy as np

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import LANES
from mcsim.kernels.planar_layout import (
    COS,
    COURSE,
    HALF_TURN,
    LINEAR,
    LINEAR_ERRORS,
    OFFSETS,
    PD,
    PL,
    SIN,
    VD,
    VL,
)
from mcsim.kernels.rotation import LARGEST_TURN, angles_from, turn, turn_exactly, wrap


@scalar
def _turned(direction, angle_row, state, cos_row, sin_row):
    """Unit vectors at ``direction`` plus each lane's angle (radians, in row ``angle_row``)."""
    c0 = math.cos(direction)
    s0 = math.sin(direction)
    for j in range(LANES):
        state[cos_row + j], state[sin_row + j] = turn(c0, s0, state[angle_row + j])
    for j in range(LANES):
        if abs(state[angle_row + j]) > LARGEST_TURN:
            c, s = turn_exactly(c0, s0, state[angle_row + j])
            state[cos_row + j], state[sin_row + j] = c, s


@scalar
def start_block(constants, deviations, initial, interval, state):
    """State rows at sample 0, from the true state and the realization's constants."""
    for j in range(LANES):
        direction = deviations[4] * constants[4 * LANES + j]
        state[COURSE + j] = direction + deviations[6] * constants[6 * LANES + j]
        state[HALF_TURN + j] = direction + deviations[5] * constants[5 * LANES + j]
    _turned(initial[3], HALF_TURN, state, COS, SIN)
    _turned(initial[4], COURSE, state, VL, VD)
    for j in range(LANES):
        speed = (initial[2] + deviations[3] * constants[3 * LANES + j]) / interval
        state[VL + j] *= speed
        state[VD + j] *= speed
        state[PL + j] = initial[0] / (interval * interval)
        state[PD + j] = initial[1] / (interval * interval)
        state[HALF_TURN + j] = 0.0
    for channel in range(3):
        row = channel * LANES
        for j in range(LANES):
            state[OFFSETS + row + j] = deviations[channel] * constants[row + j]


@scalar
def start_linear(constants, linear_constants, state):
    """Linear errors from what is drawn once per realization."""
    for error in range(LINEAR_ERRORS):
        row = LINEAR + error * LANES
        for j in range(LANES):
            state[row + j] = 0.0
        for k in range(linear_constants.shape[1]):
            weight = linear_constants[error, k]
            for j in range(LANES):
                state[row + j] += weight * constants[k * LANES + j]


@scalar
def add_linear(i, k, normals, sensitivity, state):
    """Add sample ``i``'s noise to the linear errors."""
    row = 3 * k * LANES
    a0, a1, a2 = sensitivity[i, 0], sensitivity[i, 1], sensitivity[i, 2]
    b0, b1, b2 = sensitivity[i, 3], sensitivity[i, 4], sensitivity[i, 5]
    c0, c1, c2 = sensitivity[i, 6], sensitivity[i, 7], sensitivity[i, 8]
    h2 = sensitivity[i, 9]
    for j in range(LANES):
        x = np.float64(normals[row + j])
        y = np.float64(normals[row + LANES + j])
        z = np.float64(normals[row + 2 * LANES + j])
        state[LINEAR + j] += a0 * x + a1 * y + a2 * z
        state[LINEAR + LANES + j] += b0 * x + b1 * y + b2 * z
        state[LINEAR + 2 * LANES + j] += c0 * x + c1 * y + c2 * z
        state[LINEAR + 3 * LANES + j] += h2 * z


@scalar
def add_linear_of_two(i, row, normals, sensitivity, state):
    """The same for samples ``i`` and ``i + 1``, whose normals begin at ``row``."""
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
        a = state[LINEAR + j]
        b = state[LINEAR + LANES + j]
        c = state[LINEAR + 2 * LANES + j]
        h = state[LINEAR + 3 * LANES + j]
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
        state[LINEAR + j] = a
        state[LINEAR + LANES + j] = b
        state[LINEAR + 2 * LANES + j] = c
        state[LINEAR + 3 * LANES + j] = h


@scalar
def record_states(state, sample, start, filled, interval, history):
    """States after ``sample``; the heading there is half a turn past its mid-interval value."""
    for j in range(filled):
        history[0, sample, start + j] = interval * interval * state[PL + j]
        history[1, sample, start + j] = interval * interval * state[PD + j]
        history[2, sample, start + j] = interval * state[VL + j]
        history[3, sample, start + j] = interval * state[VD + j]
        heading = math.atan2(state[SIN + j], state[COS + j]) + state[HALF_TURN + j]
        history[4, sample, start + j] = heading


@scalar
def finish_block(state, start, filled, interval, final, errors, linear):
    """Errors at the last sample; linear errors where they are wanted."""
    t2 = interval * interval
    for j in range(filled):
        along = t2 * state[PL + j] - final[0]
        across = t2 * state[PD + j] - final[1]
        errors[0, start + j] = along
        errors[1, start + j] = across
        errors[2, start + j] = math.sqrt(along * along + across * across)
    angles_from(final[2], COS, SIN, state, COURSE)
    for j in range(filled):
        errors[3, start + j] = wrap(state[COURSE + j] + state[HALF_TURN + j])
    angles_from(final[3], VL, VD, state, COURSE)
    for j in range(filled):
        errors[4, start + j] = state[COURSE + j]
    if linear.shape[1] > 0:
        for error in range(LINEAR_ERRORS):
            for j in range(filled):
                linear[error, start + j] = state[LINEAR + error * LANES + j]
