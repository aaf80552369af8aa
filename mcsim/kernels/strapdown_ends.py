"""Start and end of the strapdown kernel's block: initial state, recorded states, end errors."""

from __future__ import annotations

import math

import numpy as np

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import LANES
from mcsim.kernels.measurement import mean_at_rest
from mcsim.kernels.rotation import (
    LARGEST_TURN,
    angles_from,
    turn,
    turn_exactly,
    wrap,
)
from mcsim.kernels.strapdown_layout import (
    CHANNELS,
    COURSE,
    DIRECTION,
    FIRST_PLANAR,
    FIRST_SPATIAL,
    FORCE,
    HEADING,
    LINEAR,
    LINEAR_ERRORS,
    LOCKED,
    OFFSETS,
    PD,
    PH,
    PITCH,
    PL,
    PREVIOUS,
    REST,
    ROLL,
    SPATIAL,
    SPEED,
    VD,
    VH,
    VL,
    A,
    B,
    C,
    D,
    E,
    F,
    G,
    H,
    W,
    X,
    Y,
    Z,
)
from mcsim.kernels.strapdown_steps import measured


@scalar
def _turned_halves(angle, extra_row, state, cos_row, sin_row):
    """Cosines and sines of half of ``angle`` plus each lane's own (radians)."""
    c0 = math.cos(0.5 * angle)
    s0 = math.sin(0.5 * angle)
    for j in range(LANES):
        state[cos_row + j], state[sin_row + j] = turn(c0, s0, 0.5 * state[extra_row + j])
    for j in range(LANES):
        if abs(state[extra_row + j]) > LARGEST_TURN:
            c, s = turn_exactly(c0, s0, 0.5 * state[extra_row + j])
            state[cos_row + j], state[sin_row + j] = c, s


@scalar
def _start_motion(constants, deviations, initial, interval, state):
    """Velocity and position rows; the direction error turns the velocity about the vertical."""
    for j in range(LANES):
        direction = deviations[DIRECTION] * constants[DIRECTION * LANES + j]
        course = deviations[COURSE] * constants[COURSE * LANES + j]
        # Twice the angle: the rows get cosine and sine of its half.
        state[A + j] = 2.0 * (direction + course)
        heading = deviations[HEADING] * constants[HEADING * LANES + j]
        state[B + j] = direction + heading
    _turned_halves(2.0 * initial[8], A, state, VL, VD)
    cos_climb = math.cos(initial[4])
    sin_climb = math.sin(initial[4])
    t2 = interval * interval
    for j in range(LANES):
        speed = (initial[3] + deviations[SPEED] * constants[SPEED * LANES + j]) / interval
        state[VL + j] *= speed * cos_climb
        state[VD + j] *= speed * cos_climb
        state[VH + j] = speed * sin_climb
        state[PL + j] = initial[0] / t2
        state[PD + j] = initial[1] / t2
        state[PH + j] = initial[2] / t2


@scalar
def _mean_at_rest(axis, rest, constants, deviations, terms, scratch, state):
    """Mean measured specific force at rest of one axis (0, 1, 2), into the rows E, F or G.

    It holds the offset that the sensor keeps, what mixing makes of gravity, in-run noise, and
    the digital output's steps and limits.
    """
    channel = 3 if axis == 2 else axis
    coefficients, hidden = scratch[0], scratch[3]
    own = state[E + axis * LANES : E + (axis + 1) * LANES]
    for j in range(LANES):
        noise = deviations[REST + axis] * constants[(REST + axis) * LANES + j]
        own[j] = rest[axis] + state[OFFSETS + channel * LANES + j] + noise
    for entry in range(len(terms.mix_to)):
        source = terms.mix_from[entry]
        if terms.mix_to[entry] == channel and FORCE[source]:
            value = rest[2] if source == 3 else rest[source]
            value -= terms.mix_calibrated[entry]
            mixed = coefficients[entry * LANES : (entry + 1) * LANES]
            for j in range(LANES):
                own[j] += mixed[j] * value
    if len(hidden) > 0:
        samples, spread = terms.rest_samples[1], terms.levelling_spread[channel]
        largest, resolution = terms.ranges[channel], terms.resolutions[channel]
        row = (len(terms.mix_to) + 2 * CHANNELS + channel) * LANES
        for j in range(LANES):
            mean = mean_at_rest(
                own[j] + hidden[channel * LANES + j],
                coefficients[row + j],
                samples,
                spread,
                largest,
                resolution,
            )
            own[j] = mean - hidden[(CHANNELS + channel) * LANES + j]


@scalar
def _level(constants, deviations, rest, initial, terms, scratch, state):
    """Roll and pitch errors (rows C, D) that levelling by the mean specific force at rest makes.

    ``roll = atan2(left, up)``, ``pitch = atan2(-forward, |(left, up)|)``.
    """
    for axis in range(3):
        _mean_at_rest(axis, rest, constants, deviations, terms, scratch, state)
    for j in range(LANES):
        forward, left, up = state[E + j], state[F + j], state[G + j]
        across = math.sqrt(left * left + up * up)
        state[C + j] += wrap(math.atan2(left, up) - initial[5])
        state[D + j] += wrap(math.atan2(-forward, across) - initial[6])


@scalar
def _start_attitude(initial, state):
    """Quaternion rows from true angles (initial 5 ... 7) and errors in the rows C, D, B."""
    _turned_halves(initial[5], C, state, E, F)
    _turned_halves(initial[6], D, state, G, H)
    _turned_halves(initial[7], B, state, C, D)
    for j in range(LANES):
        cr, sr = state[E + j], state[F + j]
        cp, sp = state[G + j], state[H + j]
        ch, sh = state[C + j], state[D + j]
        state[W + j] = cr * cp * ch + sr * sp * sh
        state[X + j] = sr * cp * ch - cr * sp * sh
        state[Y + j] = cr * sp * ch + sr * cp * sh
        state[Z + j] = cr * cp * sh - sr * sp * ch


@scalar
def _constant_of(channel, planar, spatial):
    """Number of a channel's constant; the planar channels' lie apart from the others'."""
    return planar + channel if channel < 3 else spatial + channel - 3


@scalar
def start_block(
    constants,
    deviations,
    initial,
    rest,
    levelled,
    signals,
    interval,
    terms,
    scratch,
    state,
):
    """State rows at sample 0, from the true state and the realization's constants."""
    for channel in range(CHANNELS):
        row = channel * LANES
        fixed = _constant_of(channel, 0, SPATIAL)
        first = _constant_of(channel, FIRST_PLANAR, FIRST_SPATIAL)
        for j in range(LANES):
            offset = deviations[fixed] * constants[fixed * LANES + j]
            noise = deviations[first] * constants[first * LANES + j]
            state[OFFSETS + row + j] = offset
            state[PREVIOUS + row + j] = measured(signals[0, channel], offset, noise)
    _start_motion(constants, deviations, initial, interval, state)
    for j in range(LANES):
        state[C + j] = deviations[ROLL] * constants[ROLL * LANES + j]
        state[D + j] = deviations[PITCH] * constants[PITCH * LANES + j]
    if levelled:
        _level(constants, deviations, rest, initial, terms, scratch, state)
    _start_attitude(initial, state)


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
def add_linear(i, k, noise, sensitivity, state):
    """Add sample ``i``'s noise to the linear errors.

    One loop over lanes, written out: each normal is read and converted once.
    """
    planar, spatial = noise
    row = 3 * k * LANES
    w = sensitivity[i]
    a0, a1, a2, a3, a4, a5 = w[0], w[1], w[2], w[3], w[4], w[5]
    b0, b1, b2, b3, b4, b5 = w[6], w[7], w[8], w[9], w[10], w[11]
    c0, c1, c2, c3, c4, c5 = w[12], w[13], w[14], w[15], w[16], w[17]
    d0, d1, d2, d3, d4, d5 = w[18], w[19], w[20], w[21], w[22], w[23]
    e2, e4, e5 = w[24], w[25], w[26]
    f2, f4, f5 = w[27], w[28], w[29]
    g2, g4, g5 = w[30], w[31], w[32]
    for j in range(LANES):
        x0 = np.float64(planar[row + j])
        x1 = np.float64(planar[row + LANES + j])
        x2 = np.float64(planar[row + 2 * LANES + j])
        x3 = np.float64(spatial[row + j])
        x4 = np.float64(spatial[row + LANES + j])
        x5 = np.float64(spatial[row + 2 * LANES + j])
        to = LINEAR + j
        state[to] += a0 * x0 + a1 * x1 + a2 * x2 + a3 * x3 + a4 * x4 + a5 * x5
        state[to + LANES] += b0 * x0 + b1 * x1 + b2 * x2 + b3 * x3 + b4 * x4 + b5 * x5
        state[to + 2 * LANES] += c0 * x0 + c1 * x1 + c2 * x2 + c3 * x3 + c4 * x4 + c5 * x5
        state[to + 3 * LANES] += d0 * x0 + d1 * x1 + d2 * x2 + d3 * x3 + d4 * x4 + d5 * x5
        state[to + 4 * LANES] += e2 * x2 + e4 * x4 + e5 * x5
        state[to + 5 * LANES] += f2 * x2 + f4 * x4 + f5 * x5
        state[to + 6 * LANES] += g2 * x2 + g4 * x4 + g5 * x5


@scalar
def _axes(state):
    """Direction cosines that Euler angles need: forward and up as rows A ... E.

    A, B, C: the forward axis along, across, upwards; D, E: the left and up axes upwards.
    """
    for j in range(LANES):
        w, x, y, z = state[W + j], state[X + j], state[Y + j], state[Z + j]
        state[A + j] = 1.0 - 2.0 * (y * y + z * z)
        state[B + j] = 2.0 * (x * y + w * z)
        state[C + j] = 2.0 * (x * z - w * y)
        state[D + j] = 2.0 * (y * z + w * x)
        state[E + j] = 1.0 - 2.0 * (x * x + y * y)


@scalar
def _unlock(state):
    """Euler angles' convention where the pitch is ±90°: no roll, the heading turns it all."""
    for j in range(LANES):
        forward = state[A + j] * state[A + j] + state[B + j] * state[B + j]
        if forward < LOCKED * LOCKED:
            w, x, y, z = state[W + j], state[X + j], state[Y + j], state[Z + j]
            state[A + j] = 1.0 - 2.0 * (x * x + z * z)
            state[B + j] = 2.0 * (w * z - x * y)
            state[D + j] = 0.0
            state[E + j] = 1.0
            state[F + j] = 0.0
        else:
            state[F + j] = math.sqrt(forward)


@scalar
def record_states(state, sample, start, filled, interval, history):
    """States after ``sample``."""
    t2 = interval * interval
    _axes(state)
    _unlock(state)
    for j in range(filled):
        history[0, sample, start + j] = t2 * state[PL + j]
        history[1, sample, start + j] = t2 * state[PD + j]
        history[2, sample, start + j] = t2 * state[PH + j]
        history[3, sample, start + j] = interval * state[VL + j]
        history[4, sample, start + j] = interval * state[VD + j]
        history[5, sample, start + j] = interval * state[VH + j]
        history[6, sample, start + j] = math.atan2(state[D + j], state[E + j])
        history[7, sample, start + j] = math.atan2(-state[C + j], state[F + j])
        history[8, sample, start + j] = math.atan2(state[B + j], state[A + j])


@scalar
def finish_block(state, start, filled, interval, final, errors, linear):
    """Errors at the last sample; linear errors where they are wanted."""
    t2 = interval * interval
    for j in range(filled):
        along = t2 * state[PL + j] - final[0]
        across = t2 * state[PD + j] - final[1]
        height = t2 * state[PH + j] - final[2]
        errors[0, start + j] = along
        errors[1, start + j] = across
        errors[2, start + j] = height
        errors[3, start + j] = math.sqrt(along * along + across * across + height * height)
    _axes(state)
    _unlock(state)
    for j in range(LANES):
        state[C + j] = -state[C + j]
    angles_from(final[3], E, D, state, G)
    angles_from(final[4], F, C, state, H)
    for j in range(filled):
        errors[4, start + j] = state[G + j]
        errors[5, start + j] = state[H + j]
    angles_from(final[5], A, B, state, G)
    angles_from(final[6], VL, VD, state, H)
    for j in range(filled):
        errors[6, start + j] = state[G + j]
        errors[7, start + j] = state[H + j]
    if linear.shape[1] > 0:
        for error in range(LINEAR_ERRORS):
            for j in range(filled):
                linear[error, start + j] = state[LINEAR + error * LANES + j]
