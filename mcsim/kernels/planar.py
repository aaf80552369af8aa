"""Planar dead reckoning of many disturbed realizations, as lanes of a block.

Equations (2) and (3) of the planar paper.  Realizations are integrated side by
side, ``LANES`` at a time: every state variable is one row of a small array and
the innermost loop runs over lanes, which LLVM vectorises.  Noise is drawn four
samples ahead into a scratch array and used at once; nothing is kept per sample.

Two things are factored out of the loop.  The sampling interval: velocities are
summed as ``V = sum R a`` and positions as ``P = sum V`` and scaled at the end.
And trigonometry: the heading is carried as a rotation (cos, sin), turned at
each sample by a small angle with a Taylor polynomial (see ``turn``).

The measured channels are forward acceleration, leftward acceleration and yaw
rate, in this order everywhere.
"""

from __future__ import annotations

import math

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel, scalar
from mcsim.kernels.random import normal_pair, stream_words, xoshiro_next

Array = NDArray[np.float64]

LANES = 64
#: Number of samples drawn and integrated between two visits of the state rows.
GROUP = 4
#: Columns of the result: along, across, position, heading, course.
ERRORS = 5
#: Largest heading increment per sample (rad) for which ``turn`` errs by less than 1e-11.
LARGEST_TURN = 0.5

#: Streams of a realization: white noise of the samples, constants drawn once.
WHITE_NOISE, CONSTANTS = 0, 1
#: Constants: three miscalibrations, initial speed, direction, heading and course
#: errors, one spare, then the noise of sample 0 (used by the trapezoidal rule).
_N_CONSTANTS = 12

# Rows of the state array: rotation, sum of yaw rates, scaled velocity and position,
# the previous sample's three channels and the previous interval's turn.
_COS, _SIN, _YAW_SUM, _VL, _VD, _PL, _PD, _FORWARD, _LEFT, _YAW_RATE, _TURN = range(11)
_N_STATE = 11

#: Rows of a recorded history: along, across, velocity along, velocity across, heading.
HISTORY_ROWS = 5


@scalar
def turn(c, s, angle):
    """Rotate the unit vector (c, s) by ``angle``; Taylor series to the 9th order.

    The error per turn is below |angle|^10 / 10!: 3e-13 at 0.25 rad, 3e-10 at 0.5 rad.
    """
    q = angle * angle
    sin_a = angle * (1.0 + q * (-1 / 6 + q * (1 / 120 + q * (-1 / 5040 + q * (1 / 362880)))))
    cos_a = 1.0 + q * (-1 / 2 + q * (1 / 24 + q * (-1 / 720 + q * (1 / 40320))))
    return c * cos_a - s * sin_a, s * cos_a + c * sin_a


@scalar
def turn_exactly(c, s, angle):
    """Rotate the unit vector (c, s) by an angle of any size."""
    cos_a = math.cos(angle)
    sin_a = math.sin(angle)
    return c * cos_a - s * sin_a, s * cos_a + c * sin_a


def _make_steps(turn_by):
    """The two integrators' steps, with the given way of turning the heading."""

    @scalar
    def rectangular(c, s, vl, vd, pl, pd, forward, left, angle):
        """Eq. (2), (3): new heading first, then velocity, then position."""
        c, s = turn_by(c, s, angle)
        vl += c * forward - s * left
        vd += s * forward + c * left
        return c, s, vl, vd, pl + vl, pd + vd

    @scalar
    def trapezoidal(c, s, vl, vd, pl, pd, forward, left, angle):
        """(c, s) is the mid-interval heading, inputs are means over the interval."""
        c, s = turn_by(c, s, angle)
        al = c * forward - s * left
        ad = s * forward + c * left
        pl += vl + 0.5 * al
        pd += vd + 0.5 * ad
        return c, s, vl + al, vd + ad, pl, pd

    return rectangular, trapezoidal


_rectangular, _trapezoidal = _make_steps(turn)
_rectangular_exact, _trapezoidal_exact = _make_steps(turn_exactly)


@scalar
def _seed_lanes(key, first, stream, state):
    """Put the xoshiro state of ``LANES`` realizations from ``first`` on into ``state``."""
    for j in range(LANES):
        s0, s1, s2, s3 = stream_words(key, first + uint64(j), stream, 0)
        state[0, j] = s0
        state[1, j] = s1
        state[2, j] = s2
        state[3, j] = s3


@scalar
def _draw_constants(key, first, constants):
    """Twelve normals per lane for what a realization draws once."""
    for block in range(_N_CONSTANTS // 4):
        for j in range(LANES):
            w0, w1, w2, w3 = stream_words(key, first + uint64(j), CONSTANTS, block)
            z0, z1 = normal_pair(w0, w1)
            z2, z3 = normal_pair(w2, w3)
            constants[4 * block, j] = z0
            constants[4 * block + 1, j] = z1
            constants[4 * block + 2, j] = z2
            constants[4 * block + 3, j] = z3


@scalar
def _draw_group(state, normals):
    """Twelve normals per lane: three channels of ``GROUP`` samples."""
    for j in range(LANES):
        s0 = state[0, j]
        s1 = state[1, j]
        s2 = state[2, j]
        s3 = state[3, j]
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[0, j], normals[1, j] = normal_pair(a, b)
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[2, j], normals[3, j] = normal_pair(a, b)
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[4, j], normals[5, j] = normal_pair(a, b)
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[6, j], normals[7, j] = normal_pair(a, b)
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[8, j], normals[9, j] = normal_pair(a, b)
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[10, j], normals[11, j] = normal_pair(a, b)
        state[0, j] = s0
        state[1, j] = s1
        state[2, j] = s2
        state[3, j] = s3


@scalar
def _start(constants, deviations, initial, white, signals, interval, state):
    """State rows at sample 0, from the true state and the realization's initial errors.

    The previous-sample rows hold measured sample 0 (for the trapezoidal rule).
    """
    for j in range(LANES):
        direction = deviations[4] * constants[4, j]
        heading = initial[3] + direction + deviations[5] * constants[5, j]
        course = initial[4] + direction + deviations[6] * constants[6, j]
        speed = initial[2] + deviations[3] * constants[3, j]
        state[_COS, j] = math.cos(heading)
        state[_SIN, j] = math.sin(heading)
        state[_YAW_SUM, j] = heading / interval
        state[_VL, j] = speed * math.cos(course) / interval
        state[_VD, j] = speed * math.sin(course) / interval
        state[_PL, j] = initial[0] / (interval * interval)
        state[_PD, j] = initial[1] / (interval * interval)
        state[_FORWARD, j] = (
            signals[0, 0] + deviations[0] * constants[0, j] + white[0] * constants[8, j]
        )
        state[_LEFT, j] = (
            signals[1, 0] + deviations[1] * constants[1, j] + white[1] * constants[9, j]
        )
        state[_YAW_RATE, j] = (
            signals[2, 0] + deviations[2] * constants[2, j] + white[2] * constants[10, j]
        )
        state[_TURN, j] = 0.0


def _make_advance(rectangular, trapezoidal):
    """Advance a block by one sample, with the given steps."""

    @scalar
    def advance_rectangular(sample, k, normals, biases, signals, white, interval, state):
        f0 = signals[0, sample]
        l0 = signals[1, sample]
        w0 = signals[2, sample]
        for j in range(LANES):
            forward = f0 + biases[0, j] + white[0] * normals[3 * k, j]
            left = l0 + biases[1, j] + white[1] * normals[3 * k + 1, j]
            yaw_rate = w0 + biases[2, j] + white[2] * normals[3 * k + 2, j]
            state[_YAW_SUM, j] += yaw_rate
            (
                state[_COS, j],
                state[_SIN, j],
                state[_VL, j],
                state[_VD, j],
                state[_PL, j],
                state[_PD, j],
            ) = rectangular(
                state[_COS, j],
                state[_SIN, j],
                state[_VL, j],
                state[_VD, j],
                state[_PL, j],
                state[_PD, j],
                forward,
                left,
                interval * yaw_rate,
            )

    @scalar
    def advance_trapezoidal(
        sample, k, normals, biases, signals, white, interval, previous_share, state
    ):
        f0 = signals[0, sample]
        l0 = signals[1, sample]
        w0 = signals[2, sample]
        this_share = 1.0 - previous_share
        for j in range(LANES):
            forward = f0 + biases[0, j] + white[0] * normals[3 * k, j]
            left = l0 + biases[1, j] + white[1] * normals[3 * k + 1, j]
            yaw_rate = w0 + biases[2, j] + white[2] * normals[3 * k + 2, j]
            mean_forward = this_share * forward + previous_share * state[_FORWARD, j]
            mean_left = this_share * left + previous_share * state[_LEFT, j]
            mean_yaw_rate = this_share * yaw_rate + previous_share * state[_YAW_RATE, j]
            state[_FORWARD, j] = forward
            state[_LEFT, j] = left
            state[_YAW_RATE, j] = yaw_rate
            state[_YAW_SUM, j] += mean_yaw_rate
            # From the middle of the last interval to the middle of this one.
            half_turn = 0.5 * interval * mean_yaw_rate
            angle = state[_TURN, j] + half_turn
            state[_TURN, j] = half_turn
            (
                state[_COS, j],
                state[_SIN, j],
                state[_VL, j],
                state[_VD, j],
                state[_PL, j],
                state[_PD, j],
            ) = trapezoidal(
                state[_COS, j],
                state[_SIN, j],
                state[_VL, j],
                state[_VD, j],
                state[_PL, j],
                state[_PD, j],
                mean_forward,
                mean_left,
                angle,
            )

    return advance_rectangular, advance_trapezoidal


_advance_rectangular, _advance_trapezoidal = _make_advance(_rectangular, _trapezoidal)
_advance_rectangular_exactly, _advance_trapezoidal_exactly = _make_advance(
    _rectangular_exact, _trapezoidal_exact
)


@scalar
def _set_biases(constants, deviations, biases):
    for channel in range(3):
        for j in range(LANES):
            biases[channel, j] = deviations[channel] * constants[channel, j]


@scalar
def _wrap(angle):
    """Angle in (-pi, pi]."""
    turns = math.ceil((angle - math.pi) / (2.0 * math.pi))
    return angle - 2.0 * math.pi * turns


@scalar
def _record(state, sample, start, filled, interval, history):
    for j in range(filled):
        history[0, sample, start + j] = interval * interval * state[_PL, j]
        history[1, sample, start + j] = interval * interval * state[_PD, j]
        history[2, sample, start + j] = interval * state[_VL, j]
        history[3, sample, start + j] = interval * state[_VD, j]
        history[4, sample, start + j] = interval * state[_YAW_SUM, j]


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
    exact_turns: bool,
    errors: Array,
    history: Array,
) -> None:
    """Dead-reckon ``count`` realizations from number ``first`` on; their errors at the last sample.

    Parameters
    ----------
    key, first : uint64
        Key of the random numbers and index of the first realization.
    count : int
    signals : float64 (3, n + 1)
        Undisturbed forward and left acceleration (m/s^2) and yaw rate (rad/s) at
        samples 0 ... n; sample 0 is the known initial state.
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
    exact_turns : bool
        Exact sine and cosine; needed where a turn may exceed ``LARGEST_TURN``.
    errors : float64 (5, count), written
        along, across, position (m), heading, course (rad).
    history : float64 (HISTORY_ROWS, n + 1, count) or (0, 0, 0), written
        Reconstructed states at every sample, unless empty.
    """
    n = signals.shape[1] - 1
    record = history.shape[1] > 0
    random_state = np.empty((4, LANES), np.uint32)
    normals = np.empty((3 * GROUP, LANES), np.float32)
    constants = np.empty((_N_CONSTANTS, LANES), np.float32)
    biases = np.empty((3, LANES), np.float64)
    state = np.empty((_N_STATE, LANES), np.float64)
    t2 = interval * interval
    for block in range((count + LANES - 1) // LANES):
        start = block * LANES
        filled = min(LANES, count - start)
        block_first = first + uint64(start)
        _draw_constants(key, block_first, constants)
        _set_biases(constants, deviations, biases)
        _start(constants, deviations, initial, white, signals, interval, state)
        _seed_lanes(key, block_first, WHITE_NOISE, random_state)
        if record:
            _record(state, 0, start, filled, interval, history)
        for group in range((n + GROUP - 1) // GROUP):
            _draw_group(random_state, normals)
            for k in range(min(GROUP, n - group * GROUP)):
                i = group * GROUP + k + 1
                if trapezoidal:
                    if exact_turns:
                        _advance_trapezoidal_exactly(
                            i, k, normals, biases, signals, white, interval, previous_share, state
                        )
                    else:
                        _advance_trapezoidal(
                            i, k, normals, biases, signals, white, interval, previous_share, state
                        )
                elif exact_turns:
                    _advance_rectangular_exactly(
                        i, k, normals, biases, signals, white, interval, state
                    )
                else:
                    _advance_rectangular(i, k, normals, biases, signals, white, interval, state)
                if record:
                    _record(state, i, start, filled, interval, history)
        for j in range(filled):
            along = t2 * state[_PL, j] - final[0]
            across = t2 * state[_PD, j] - final[1]
            errors[0, start + j] = along
            errors[1, start + j] = across
            errors[2, start + j] = math.sqrt(along * along + across * across)
            errors[3, start + j] = _wrap(interval * state[_YAW_SUM, j] - final[2])
            course = math.atan2(state[_VD, j], state[_VL, j])
            errors[4, start + j] = _wrap(course - final[3])
