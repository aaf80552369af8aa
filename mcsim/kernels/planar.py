"""Planar dead reckoning of many disturbed realizations, as lanes of a block.

Equations (2) and (3) of the planar paper.  Realizations are integrated side by
side, ``LANES`` at a time: every state variable is one row of a small array and
the innermost loop runs over lanes, which LLVM vectorises.  Noise is drawn four
samples ahead into a scratch array and used at once; nothing is kept per sample.

What makes it fast, measured in ``benchmarks/``:

* Scratch arrays are flat, rows at constant offsets: LLVM then knows that rows do
  not overlap and needs no checks.
* Four samples are integrated between loading and storing a lane's state.
* The sampling interval is factored out: velocities are summed as ``V = sum R a``
  and positions as ``P = sum V``, angles come as increments, and all is scaled at
  the end.
* Trigonometry is gone: the heading is a unit vector, turned at each sample by a
  small angle with a Taylor polynomial (see ``turn_little`` and ``turn``).

The measured channels are forward acceleration, leftward acceleration and turn
(yaw rate times sampling interval), in this order everywhere.
"""

from __future__ import annotations

import math

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel, scalar
from mcsim.kernels.lanes import (
    GROUP,
    LANES,
    WHITE_NOISE,
    draw_constants,
    draw_group,
    seed_lanes,
    take_constants,
)
from mcsim.kernels.measurement import ErrorTerms, make_scratch, measure, start_measuring
from mcsim.kernels.rotation import (
    LARGEST_TURN,
    LITTLE_TURN,
    angles_from,
    turn,
    turn_exactly,
    turn_little,
    wrap,
)

Array = NDArray[np.float64]

#: Rows of the result: along, across, position, heading, course.
ERRORS = 5
#: Rows of the linear errors: along, across, course, heading.
LINEAR_ERRORS = 4
#: Normals drawn once per realization.
N_CONSTANTS = 12
#: Row of the constants where the normals of sample 0 begin.
_NOISE_0 = 8
# Constants of a realization (see ``lanes``): three miscalibrations, initial speed,
# direction, heading and course errors, one spare, then the noise of sample 0, which the
# trapezoidal rule uses and which coloured noise starts from, one spare; mixing coefficients.

# Rows of the state: heading vector, velocity, position, four linear errors, the
# previous sample's channels, half of the previous interval's turn, three offsets, and
# one for angles at the start and the end.
_COS, _SIN, _VL, _VD, _PL, _PD = (LANES * row for row in range(6))
_LINEAR = LANES * 6
_FORWARD, _LEFT, _YAW, _HALF_TURN = (LANES * row for row in range(10, 14))
_OFFSETS = LANES * 14
_COURSE = LANES * 17
_N_STATE = LANES * 18

#: Rows of a recorded history: along, across, velocity along, velocity across, heading.
HISTORY_ROWS = 5


def _make_steps(turn_by):
    """The two integrators' steps, with the given way of turning the heading."""

    @scalar
    def rectangular(c, s, vl, vd, pl, pd, forward, left, angle):
        """Eq. (2), (3): new heading first, then velocity, then position."""
        c, s = turn_by(c, s, angle)
        vl = vl + c * forward
        vl = vl - s * left
        vd = vd + s * forward
        vd = vd + c * left
        return c, s, vl, vd, pl + vl, pd + vd

    @scalar
    def trapezoidal(c, s, vl, vd, pl, pd, forward, left, angle):
        """(c, s) is the mid-interval heading, inputs are means over the interval."""
        c, s = turn_by(c, s, angle)
        al = c * forward - s * left
        ad = s * forward + c * left
        return c, s, vl + al, vd + ad, pl + (vl + 0.5 * al), pd + (vd + 0.5 * ad)

    return rectangular, trapezoidal


_step_little, _ = _make_steps(turn_little)
_step, _trapezoidal_step = _make_steps(turn)
_step_exactly, _trapezoidal_step_exactly = _make_steps(turn_exactly)


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
def _start(constants, deviations, initial, interval, state):
    """State rows at sample 0, from the true state and the realization's constants."""
    for j in range(LANES):
        direction = deviations[4] * constants[4 * LANES + j]
        state[_COURSE + j] = direction + deviations[6] * constants[6 * LANES + j]
        state[_HALF_TURN + j] = direction + deviations[5] * constants[5 * LANES + j]
    _turned(initial[3], _HALF_TURN, state, _COS, _SIN)
    _turned(initial[4], _COURSE, state, _VL, _VD)
    for j in range(LANES):
        speed = (initial[2] + deviations[3] * constants[3 * LANES + j]) / interval
        state[_VL + j] *= speed
        state[_VD + j] *= speed
        state[_PL + j] = initial[0] / (interval * interval)
        state[_PD + j] = initial[1] / (interval * interval)
        state[_HALF_TURN + j] = 0.0
    for channel in range(3):
        row = channel * LANES
        for j in range(LANES):
            state[_OFFSETS + row + j] = deviations[channel] * constants[row + j]


@scalar
def _measure_plainly(i, row, normals, signals, white, state, measured):
    """Measured channels of sample ``i`` where offsets and white noise are all there is."""
    for channel in range(3):
        value, deviation = signals[i, channel], white[channel]
        own = channel * LANES
        drawn = normals[row * LANES + own : row * LANES + own + LANES]
        for j in range(LANES):
            measured[own + j] = value + state[_OFFSETS + own + j] + deviation * drawn[j]


@scalar
def _keep_measured(measured, state):
    """Sample 0 as the previous one (for the trapezoidal rule)."""
    for j in range(3 * LANES):
        state[_FORWARD + j] = measured[j]


@scalar
def _start_linear(constants, linear_constants, state):
    """Linear errors from what is drawn once per realization."""
    for error in range(LINEAR_ERRORS):
        row = _LINEAR + error * LANES
        for j in range(LANES):
            state[row + j] = 0.0
        for k in range(linear_constants.shape[1]):
            weight = linear_constants[error, k]
            for j in range(LANES):
                state[row + j] += weight * constants[k * LANES + j]


def _make_advance_four(step, with_offsets):
    """Advance a block by four samples, rectangular, with or without constant offsets."""

    @scalar
    def disturbed(undisturbed, offset, noise):
        return undisturbed + offset + noise if with_offsets else undisturbed + noise

    @scalar
    def advance_four(i, normals, signals, white, state):
        f0, l0, w0 = signals[i, 0], signals[i, 1], signals[i, 2]
        f1, l1, w1 = signals[i + 1, 0], signals[i + 1, 1], signals[i + 1, 2]
        f2, l2, w2 = signals[i + 2, 0], signals[i + 2, 1], signals[i + 2, 2]
        f3, l3, w3 = signals[i + 3, 0], signals[i + 3, 1], signals[i + 3, 2]
        sf, sl, sw = white[0], white[1], white[2]
        for j in range(LANES):
            c, s = state[_COS + j], state[_SIN + j]
            vl, vd = state[_VL + j], state[_VD + j]
            pl, pd = state[_PL + j], state[_PD + j]
            bf = state[_OFFSETS + j]
            bl = state[_OFFSETS + LANES + j]
            bw = state[_OFFSETS + 2 * LANES + j]
            forward = disturbed(f0, bf, sf * normals[j])
            left = disturbed(l0, bl, sl * normals[LANES + j])
            angle = disturbed(w0, bw, sw * normals[2 * LANES + j])
            c, s, vl, vd, pl, pd = step(c, s, vl, vd, pl, pd, forward, left, angle)
            forward = disturbed(f1, bf, sf * normals[3 * LANES + j])
            left = disturbed(l1, bl, sl * normals[4 * LANES + j])
            angle = disturbed(w1, bw, sw * normals[5 * LANES + j])
            c, s, vl, vd, pl, pd = step(c, s, vl, vd, pl, pd, forward, left, angle)
            forward = disturbed(f2, bf, sf * normals[6 * LANES + j])
            left = disturbed(l2, bl, sl * normals[7 * LANES + j])
            angle = disturbed(w2, bw, sw * normals[8 * LANES + j])
            c, s, vl, vd, pl, pd = step(c, s, vl, vd, pl, pd, forward, left, angle)
            forward = disturbed(f3, bf, sf * normals[9 * LANES + j])
            left = disturbed(l3, bl, sl * normals[10 * LANES + j])
            angle = disturbed(w3, bw, sw * normals[11 * LANES + j])
            c, s, vl, vd, pl, pd = step(c, s, vl, vd, pl, pd, forward, left, angle)
            state[_COS + j], state[_SIN + j] = c, s
            state[_VL + j], state[_VD + j] = vl, vd
            state[_PL + j], state[_PD + j] = pl, pd

    return advance_four


#: The fast paths: little turns and nothing but noise, and everything else.
_advance_four_little = _make_advance_four(_step_little, with_offsets=False)
_advance_four = _make_advance_four(_step, with_offsets=True)


def _make_advance(rectangular, trapezoidal):
    """Advance a block by one measured sample, with the given steps."""

    @scalar
    def advance_rectangular(measured, state):
        for j in range(LANES):
            c, s, vl, vd, pl, pd = rectangular(
                state[_COS + j],
                state[_SIN + j],
                state[_VL + j],
                state[_VD + j],
                state[_PL + j],
                state[_PD + j],
                measured[j],
                measured[LANES + j],
                measured[2 * LANES + j],
            )
            state[_COS + j], state[_SIN + j] = c, s
            state[_VL + j], state[_VD + j] = vl, vd
            state[_PL + j], state[_PD + j] = pl, pd

    @scalar
    def advance_trapezoidal(measured, previous_share, state):
        share = 1.0 - previous_share
        for j in range(LANES):
            forward, left = measured[j], measured[LANES + j]
            angle = measured[2 * LANES + j]
            half_turn = 0.5 * (share * angle + previous_share * state[_YAW + j])
            c, s, vl, vd, pl, pd = trapezoidal(
                state[_COS + j],
                state[_SIN + j],
                state[_VL + j],
                state[_VD + j],
                state[_PL + j],
                state[_PD + j],
                share * forward + previous_share * state[_FORWARD + j],
                share * left + previous_share * state[_LEFT + j],
                # From the middle of the last interval to the middle of this one.
                state[_HALF_TURN + j] + half_turn,
            )
            state[_COS + j], state[_SIN + j] = c, s
            state[_VL + j], state[_VD + j] = vl, vd
            state[_PL + j], state[_PD + j] = pl, pd
            state[_FORWARD + j], state[_LEFT + j] = forward, left
            state[_YAW + j], state[_HALF_TURN + j] = angle, half_turn

    return advance_rectangular, advance_trapezoidal


_advance, _advance_trapezoidal = _make_advance(_step, _trapezoidal_step)
_advance_exactly, _advance_trapezoidal_exactly = _make_advance(
    _step_exactly, _trapezoidal_step_exactly
)


@scalar
def _add_linear(i, k, normals, sensitivity, state):
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
        state[_LINEAR + j] += a0 * x + a1 * y + a2 * z
        state[_LINEAR + LANES + j] += b0 * x + b1 * y + b2 * z
        state[_LINEAR + 2 * LANES + j] += c0 * x + c1 * y + c2 * z
        state[_LINEAR + 3 * LANES + j] += h2 * z


@scalar
def _add_linear_of_two(i, row, normals, sensitivity, state):
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
        a = state[_LINEAR + j]
        b = state[_LINEAR + LANES + j]
        c = state[_LINEAR + 2 * LANES + j]
        h = state[_LINEAR + 3 * LANES + j]
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
        state[_LINEAR + j] = a
        state[_LINEAR + LANES + j] = b
        state[_LINEAR + 2 * LANES + j] = c
        state[_LINEAR + 3 * LANES + j] = h


@scalar
def _record(state, sample, start, filled, interval, history):
    """States after ``sample``; the heading there is half a turn past its mid-interval value."""
    for j in range(filled):
        history[0, sample, start + j] = interval * interval * state[_PL + j]
        history[1, sample, start + j] = interval * interval * state[_PD + j]
        history[2, sample, start + j] = interval * state[_VL + j]
        history[3, sample, start + j] = interval * state[_VD + j]
        heading = math.atan2(state[_SIN + j], state[_COS + j]) + state[_HALF_TURN + j]
        history[4, sample, start + j] = heading


@scalar
def _finish(state, start, filled, interval, final, errors, linear):
    """Errors at the last sample; linear errors where they are wanted."""
    t2 = interval * interval
    for j in range(filled):
        along = t2 * state[_PL + j] - final[0]
        across = t2 * state[_PD + j] - final[1]
        errors[0, start + j] = along
        errors[1, start + j] = across
        errors[2, start + j] = math.sqrt(along * along + across * across)
    angles_from(final[2], _COS, _SIN, state, _COURSE)
    for j in range(filled):
        errors[3, start + j] = wrap(state[_COURSE + j] + state[_HALF_TURN + j])
    angles_from(final[3], _VL, _VD, state, _COURSE)
    for j in range(filled):
        errors[4, start + j] = state[_COURSE + j]
    if linear.shape[1] > 0:
        for error in range(LINEAR_ERRORS):
            for j in range(filled):
                linear[error, start + j] = state[_LINEAR + error * LANES + j]


@kernel
def simulate(
    key: np.uint64,
    first: np.uint64,
    count: int,
    signals: Array,
    white: Array,
    deviations: Array,
    initial: Array,
    final: Array,
    interval: float,
    trapezoidal: bool,
    previous_share: float,
    largest_turn: float,
    sensitivity: Array,
    linear_constants: Array,
    given: NDArray[np.float32],
    errors: Array,
    linear: Array,
    history: Array,
    terms: ErrorTerms,
) -> None:
    """Dead-reckon ``count`` realizations from number ``first`` on; their errors at the last sample.

    Parameters
    ----------
    key, first : uint64
        Key of the random numbers and index of the first realization.
    count : int
    signals : float64 (n + 1, 3)
        Undisturbed forward and left acceleration (m/s^2) and turn per interval (rad)
        at samples 0 ... n; sample 0 is the known initial state.
    white : float64 (3,)
        Standard deviation of the white noise of one sample, per channel.
    deviations : float64 (7,)
        Standard deviations of what is drawn once per realization: miscalibration of
        the three channels, then initial speed (m/s), direction, heading, course (rad).
    initial : float64 (5,)
        True state at sample 0: along, across (m), speed (m/s), heading, course (rad).
    final : float64 (4,)
        Truth at sample n: along, across (m), heading, course (rad; NaN if undefined).
    interval : float
        Sampling interval T (s).
    trapezoidal : bool
        Trapezoidal rule with mid-interval heading instead of Eq. (2)-(3).
    previous_share : float
        Weight of the previous sample in the interval's mean: 1/2 for momentary
        samples, 0 for samples that are already means over the interval.
    largest_turn : float
        A bound of the turn per sample (rad); it decides how headings are turned.
    sensitivity : float64 (n + 1, 10)
        Linear errors per unit normal of each channel and sample: along, across and course
        from each channel, heading from the turn.
    linear_constants : float64 (4, 12 + m)
        Linear errors per unit normal of each constant.
    given : float32 (k, count) or (0, 0)
        Normals for what is drawn once per realization, instead of drawing them, unless empty;
        k is the least multiple of four that holds 12 + m.
    errors : float64 (5, count), written
        along, across, position (m), heading, course (rad).
    linear : float64 (4, count) or (4, 0), written
        Linear errors of the same realizations, unless empty.
    history : float64 (HISTORY_ROWS, n + 1, count) or (0, 0, 0), written
        Reconstructed states at every sample, unless empty.
    terms : ErrorTerms
        Everything beyond white noise and offsets, for the three channels; m are its mixing
        coefficients.
    """
    n = signals.shape[0] - 1
    n_constants = (N_CONSTANTS + len(terms.mix_to) + 3) // 4 * 4
    plain = terms.innovation.shape[0] == 0
    record = history.shape[1] > 0
    with_linear = linear.shape[1] > 0
    with_given = given.shape[1] > 0
    little = largest_turn <= LITTLE_TURN
    exact = largest_turn > LARGEST_TURN
    for channel in range(3):
        little = little and deviations[channel] == 0.0
    # What nothing scales need not be drawn; the trapezoidal rule uses sample 0's noise.
    with_constants = trapezoidal or not plain
    for k in range(deviations.shape[0]):
        with_constants = with_constants or deviations[k] != 0.0
    by_fours = plain and not (trapezoidal or exact or record)
    random_state = np.empty(4 * LANES, np.uint32)
    normals = np.empty(3 * GROUP * LANES, np.float32)
    constants = np.zeros(n_constants * LANES, np.float32)
    scratch = make_scratch(terms)
    measured = np.empty(3 * LANES, np.float64)
    state = np.empty(_N_STATE, np.float64)
    for block in range((count + LANES - 1) // LANES):
        start = block * LANES
        filled = min(LANES, count - start)
        block_first = first + uint64(start)
        if with_given:
            take_constants(given, start, filled, n_constants, constants)
        elif with_constants:
            draw_constants(key, block_first, n_constants, constants)
        _start(constants, deviations, initial, interval, state)
        offsets = state[_OFFSETS : _OFFSETS + 3 * LANES]
        if with_linear:
            _start_linear(constants, linear_constants, state)
        seed_lanes(key, block_first, WHITE_NOISE, random_state)
        if not plain:
            start_measuring(key, block_first, terms, N_CONSTANTS, constants, scratch)
        for i in range(-3, n + 1, GROUP):
            # Sample 0 comes alone, with normals of its own among the constants.
            at_0 = i < 0
            size = 1 if at_0 else min(GROUP, n + 1 - i)
            if not at_0:
                draw_group(random_state, normals)
            if with_linear and not at_0 and size == GROUP:
                _add_linear_of_two(i, 0, normals, sensitivity, state)
                _add_linear_of_two(i + 2, 6 * LANES, normals, sensitivity, state)
            elif with_linear and not at_0:
                for k in range(size):
                    _add_linear(i + k, k, normals, sensitivity, state)
            if by_fours and at_0:
                continue
            if by_fours and size == GROUP:
                if little:
                    _advance_four_little(i, normals, signals, white, state)
                else:
                    _advance_four(i, normals, signals, white, state)
                continue
            for k in range(size):
                sample = 0 if at_0 else i + k
                row = _NOISE_0 if at_0 else 3 * k
                source = constants if at_0 else normals
                if plain:
                    _measure_plainly(sample, row, source, signals, white, state, measured)
                else:
                    measure(
                        sample,
                        3,
                        row,
                        source,
                        row,
                        source,
                        signals,
                        offsets,
                        terms,
                        scratch,
                        measured,
                    )
                if at_0:
                    _keep_measured(measured, state)
                elif trapezoidal and exact:
                    _advance_trapezoidal_exactly(measured, previous_share, state)
                elif trapezoidal:
                    _advance_trapezoidal(measured, previous_share, state)
                elif exact:
                    _advance_exactly(measured, state)
                else:
                    _advance(measured, state)
                if record:
                    _record(state, sample, start, filled, interval, history)
        _finish(state, start, filled, interval, final, errors, linear)
