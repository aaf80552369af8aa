"""Strapdown dead reckoning in space of many disturbed realizations, as lanes of a block.

The application note's equations: the measured specific force is turned into the level frame
and gravity is added, ``a_I = R a_m - (0, 0, g)`` (height counts upwards here, downwards in
the note), then summed to velocity and position.  The attitude is a unit quaternion, turned at
each sample by a rotation vector (see ``quaternion``).  Four integrators share everything else:

* ``RECTANGULAR``: attitude, velocity, position, each from the one before: in the plane this is
  the planar kernel's recursion, Eq. (2)-(3) of the planar paper.
* ``FORWARD_EULER``: position, velocity, attitude, each from the old values: the note's
  ``v[k+1] = v[k] + T a_I[k]``, ``r[k+1] = r[k] + T v[k]``.  Its sample k stands in row k + 1.
* ``TRAPEZOIDAL``: interval means turned by the mid-interval attitude; second order.
* ``TWO_SAMPLE``: the same with the coning and sculling terms of two neighbouring samples
  (Savage, "Strapdown inertial navigation integration algorithm design", 1998).

Random numbers: forward and left acceleration and yaw rate take the planar kernel's streams,
so that on a level road with a stiff vehicle both kernels see the same noise; the other three
channels take streams of their own.  Channels are ordered accordingly, everywhere: forward,
left, yaw turn, then up, roll turn, pitch turn (turns are rates times sampling interval).

As in the planar kernel the sampling interval is factored out of the sums and angles come as
increments.
"""

from __future__ import annotations

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel
from mcsim.kernels.lanes import (
    CONSTANTS,
    GROUP,
    LANES,
    WHITE_NOISE,
    draw_group,
    draw_normals,
    seed_lanes,
    take_constants,
)
from mcsim.kernels.measurement import (
    ErrorTerms,
    expect_after_rest,
    make_scratch,
    measure,
    start_measuring,
)
from mcsim.kernels.quaternion import LARGEST_ROTATION, LITTLE_ROTATION
from mcsim.kernels.strapdown_ends import (
    add_linear,
    finish_block,
    record_states,
    start_block,
    start_linear,
)
from mcsim.kernels.strapdown_layout import (
    CHANNELS,
    COURSE,
    DIRECTION,
    ERRORS,
    FIRST_PLANAR,
    FIRST_SPATIAL,
    FORWARD_EULER,
    HEADING,
    HISTORY_ROWS,
    LINEAR_ERRORS,
    MIXING_CONSTANTS,
    N_CONSTANTS,
    N_STATE,
    OFFSETS,
    PITCH,
    PREVIOUS,
    RECTANGULAR,
    REST,
    ROLL,
    SPATIAL,
    SPATIAL_CONSTANTS,
    SPATIAL_NOISE,
    SPEED,
    TRAPEZOIDAL,
    TWO_SAMPLE,
    WEIGHTS,
)
from mcsim.kernels.strapdown_steps import (
    advance,
    advance_euler,
    advance_euler_exactly,
    advance_exactly,
    advance_four,
    advance_four_little,
    advance_two_samples,
    advance_two_samples_exactly,
    advance_two_samples_four,
)

__all__ = [
    "CHANNELS",
    "COURSE",
    "DIRECTION",
    "ERRORS",
    "FIRST_PLANAR",
    "FIRST_SPATIAL",
    "FORWARD_EULER",
    "HEADING",
    "HISTORY_ROWS",
    "LINEAR_ERRORS",
    "N_CONSTANTS",
    "PITCH",
    "RECTANGULAR",
    "REST",
    "ROLL",
    "SPATIAL",
    "SPEED",
    "TRAPEZOIDAL",
    "TWO_SAMPLE",
    "WEIGHTS",
    "simulate",
]

Array = NDArray[np.float64]


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
    rest: Array,
    levelled: bool,
    gravity: float,
    interval: float,
    method: int,
    previous_share: float,
    largest_turn: float,
    sensitivity: Array,
    linear_constants: Array,
    errors: Array,
    linear: Array,
    history: Array,
    given: NDArray[np.float32],
    terms: ErrorTerms,
) -> None:
    """Reconstruct ``count`` realizations from number ``first`` on; their errors at the last sample.

    Parameters
    ----------
    key, first : uint64
        Key of the random numbers and index of the first realization.
    count : int
    signals : float64 (n + 1, 6)
        Undisturbed specific force (m/s^2) and turns per interval (rad) at samples 0 ... n,
        in the order forward, left, yaw, up, roll, pitch; sample 0 is the known initial state.
        For ``FORWARD_EULER`` row k + 1 holds sample k.
    white : float64 (6,)
        Standard deviation of the white noise of one sample, per channel.
    deviations : float64 (24,)
        Standard deviation of each constant of a realization, in the order of this module.
    initial : float64 (9,)
        True state at sample 0: along, across, height (m), speed (m/s), climb
        spare, roll, pitch, heading, course (rad).
    final : float64 (7,)
        Truth at sample n: along, across, height (m), roll, pitch, heading, course (rad; NaN
        if undefined).
    rest : float64 (3,)
        Specific force at rest in the initial attitude: forward, left, up (m/s^2).
    levelled : bool
        Roll and pitch are initialised from the measured specific force at rest.
    gravity : float
        m/s^2, downwards.
    interval : float
        Sampling interval T (s).
    method : int
        ``RECTANGULAR``, ``FORWARD_EULER``, ``TRAPEZOIDAL`` or ``TWO_SAMPLE``.
    previous_share : float
        Weight of the previous sample in the interval's mean, for the last two: 1/2 for
        momentary samples, 0 for samples that are already means over the interval.
    largest_turn : float
        A bound of the rotation per sample (rad); it decides how rotations are computed.
    sensitivity : float64 (n + 1, WEIGHTS)
        Linear errors per unit normal at each sample: along, across, height and course from
        each channel, then roll, pitch and heading from the turns (yaw, roll, pitch).
    linear_constants : float64 (7, 24 + m)
        Linear errors per unit normal of each constant.
    errors : float64 (8, count), written
        along, across, height, position (m), roll, pitch, heading, course (rad).
    linear : float64 (7, count) or (7, 0), written
        Linear errors of the same realizations, unless empty.
    history : float64 (HISTORY_ROWS, n + 1, count) or (0, 0, 0), written
        Reconstructed states at every sample, unless empty.
    given : float32 (24 + k, count) or (0, 0)
        Normals for what is drawn once per realization, instead of drawing them, unless empty;
        k is the least multiple of four that holds the m mixing coefficients.
    terms : ErrorTerms
        Everything beyond white noise and offsets, for the six channels.
    """
    n = signals.shape[0] - 1
    record = history.shape[1] > 0
    with_linear = linear.shape[1] > 0
    little = largest_turn <= LITTLE_ROTATION
    exact = largest_turn > LARGEST_ROTATION
    one_sample = method in (RECTANGULAR, FORWARD_EULER)
    # Weights of the previous sample, and of coning and sculling.
    mean = (0.0 if one_sample else previous_share, 1 / 12 if method == TWO_SAMPLE else 0.0)
    with_constants = levelled
    for k in range(N_CONSTANTS):
        with_constants = with_constants or deviations[k] != 0.0
    planar_state = np.empty(4 * LANES, np.uint32)
    spatial_state = np.empty(4 * LANES, np.uint32)
    planar = np.empty(3 * GROUP * LANES, np.float32)
    spatial = np.empty(3 * GROUP * LANES, np.float32)
    noise = planar, spatial
    mixed = (len(terms.mix_deviation) + 3) // 4 * 4
    plain = terms.innovation.shape[0] == 0
    with_given = given.shape[1] > 0
    with_constants = with_constants or not plain
    constants = np.zeros((N_CONSTANTS + mixed) * LANES, np.float32)
    scratch = make_scratch(terms)
    offsets = np.empty(CHANNELS * LANES, np.float64)
    # Where disturbed values are made beforehand, they stand in the place of the offsets and the
    # steps add nothing to them.
    still, silent = np.zeros((1, CHANNELS)), np.zeros(CHANNELS)
    state = np.empty(N_STATE, np.float64)
    half = N_CONSTANTS // 2
    for block in range((count + LANES - 1) // LANES):
        start = block * LANES
        filled = min(LANES, count - start)
        block_first = first + uint64(start)
        if with_given:
            take_constants(given, start, filled, N_CONSTANTS + mixed, constants)
        elif with_constants:
            draw_normals(key, block_first, CONSTANTS, half, constants)
            draw_normals(key, block_first, SPATIAL_CONSTANTS, half, constants[half * LANES :])
            further = constants[N_CONSTANTS * LANES :]
            draw_normals(key, block_first, MIXING_CONSTANTS, mixed, further)
        if not plain:
            start_measuring(key, block_first, terms, N_CONSTANTS, constants, scratch)
        start_block(
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
        )
        if with_linear:
            start_linear(constants, linear_constants, state)
        seed_lanes(key, block_first, WHITE_NOISE, planar_state)
        seed_lanes(key, block_first, SPATIAL_NOISE, spatial_state)
        if record:
            record_states(state, 0, start, filled, interval, history)
        measured = state[OFFSETS : OFFSETS + CHANNELS * LANES]
        if not plain:
            offsets[:] = measured
        if levelled and not plain:
            for axis in range(3):
                normals = constants[(REST + axis) * LANES : (REST + axis + 1) * LANES]
                expect_after_rest(3 if axis == 2 else axis, normals, terms, scratch[1])
        # The forward Euler rule reads sample 0 in its first step.
        if not plain and method != FORWARD_EULER:
            measure(
                0,
                CHANNELS,
                FIRST_PLANAR,
                constants,
                FIRST_SPATIAL,
                constants,
                signals,
                offsets,
                terms,
                scratch,
                measured,
            )
            state[PREVIOUS : PREVIOUS + CHANNELS * LANES] = measured
        for i in range(1, n + 1, GROUP):
            draw_group(planar_state, planar)
            draw_group(spatial_state, spatial)
            size = min(GROUP, n + 1 - i)
            if with_linear:
                for k in range(size):
                    add_linear(i + k, k, noise, sensitivity, state)
            if plain and size == GROUP and not (exact or record or method == FORWARD_EULER):
                if method == RECTANGULAR and little:
                    advance_four_little(i, noise, signals, white, gravity, state)
                elif method == RECTANGULAR:
                    advance_four(i, noise, signals, white, gravity, state)
                else:
                    advance_two_samples_four(i, noise, signals, white, gravity, mean, state)
                continue
            for k in range(size):
                row, ideal, deviation = i + k, signals, white
                if not plain:
                    measure(
                        i + k,
                        CHANNELS,
                        3 * k,
                        planar,
                        3 * k,
                        spatial,
                        signals,
                        offsets,
                        terms,
                        scratch,
                        measured,
                    )
                    row, ideal, deviation = 0, still, silent
                if exact and method == RECTANGULAR:
                    advance_exactly(row, k, noise, ideal, deviation, gravity, mean, state)
                elif exact and method == FORWARD_EULER:
                    advance_euler_exactly(row, k, noise, ideal, deviation, gravity, mean, state)
                elif exact:
                    advance_two_samples_exactly(
                        row, k, noise, ideal, deviation, gravity, mean, state
                    )
                elif method == RECTANGULAR:
                    advance(row, k, noise, ideal, deviation, gravity, state)
                elif method == FORWARD_EULER:
                    advance_euler(row, k, noise, ideal, deviation, gravity, state)
                else:
                    advance_two_samples(row, k, noise, ideal, deviation, gravity, mean, state)
                if record:
                    record_states(state, i + k, start, filled, interval, history)
        finish_block(state, start, filled, interval, final, errors, linear)
