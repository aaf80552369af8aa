"""Velocity runs whose accelerometer has more errors than white noise, many groups at once.

A group is turned on, rests, and then runs without a pause: its in-run noise goes on from the
first sample of the rest to the last one of the last run.  Every sample is measured (see
``measurement``), at rest as well, where the mean gives the initial tilt.  Groups of white noise
and offsets alone take the faster kernel of ``velocity``.

The linear error of a run needs one weight per normal for all the instants it is asked at: from
one instant to the next a normal acts by its own segment's weights, and what it has left in
the processes acts as their states, weighed where a segment begins.
"""

from __future__ import annotations

import math
from typing import NamedTuple

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
from mcsim.kernels.velocity import (
    GROUP_INPUTS,
    K0,
    KX,
    KY,
    KZ,
    LINEAR,
    N_STATE,
    SPEED,
    STAMP,
    STEPS,
    add_constants,
    add_linear,
    finish_errors,
    finish_linear,
    keep_run,
    start_groups,
    start_run,
    step_on,
)

Array = NDArray[np.float64]

CHANNELS = 3
#: Stream of a group for the white noise at rest; the runs have that of the faster kernel.
REST_NOISE = 3
#: Rows of the constants: the group's inputs, offsets of the axes, mixing coefficients.
OFFSETS, MIXING = GROUP_INPUTS, GROUP_INPUTS + CHANNELS


class LinearWeights(NamedTuple):
    """Linear errors of k instants in a group of N samples, the rest's first.

    samples : float64 (N, 4)
        Per unit normal: at rest of each axis' mean error, in a run of the velocity at the end
        of the sample's segment; the last column is the interval's.
    states : float64 (k, 3, p)
        Velocity at the end of each segment per state of a process at its beginning.
    constants : float64 (k, 17 + m)
        Velocity per unit normal of what a group draws once.
    rest : float64 (k, 3)
        Velocity per mean error of an axis at rest.
    """

    samples: Array
    states: Array
    constants: Array
    rest: Array


def no_weights() -> LinearWeights:
    """Weights where no linear errors are wanted."""
    nothing = np.zeros((0, 0))
    return LinearWeights(nothing, np.zeros((0, CHANNELS, 0)), nothing, nothing)


@scalar
def constant_rows(mixing):
    """Rows of what a group draws once, with ``mixing`` coefficients; a multiple of four."""
    return (MIXING + mixing + 3) // 4 * 4


@scalar
def _start_offsets(constants, deviations, offsets):
    for channel in range(CHANNELS):
        for j in range(LANES):
            normal = np.float64(constants[(OFFSETS + channel) * LANES + j])
            offsets[channel * LANES + j] = deviations[channel] * normal


@scalar
def _add_rest(row, normals, weights, measured, rest, rest_linear):
    """Add a sample at rest to the sums, and to the linear errors of the means."""
    for channel in range(CHANNELS):
        weight = weights[channel]
        own = normals[(row + channel) * LANES : (row + channel + 1) * LANES]
        value = measured[channel * LANES : (channel + 1) * LANES]
        total = rest[channel * LANES : (channel + 1) * LANES]
        linear = rest_linear[channel * LANES : (channel + 1) * LANES]
        for j in range(LANES):
            total[j] += value[j]
            linear[j] += weight * np.float64(own[j])


@scalar
def _add_states(weights, processes, state):
    """Add what the processes' states will make of the linear error until the segment's end."""
    linear = state[LINEAR : LINEAR + LANES]
    for channel in range(CHANNELS):
        for s in range(weights.shape[1]):
            weight = weights[channel, s]
            number = channel * weights.shape[1] + s
            own = processes[number * LANES : (number + 1) * LANES]
            for j in range(LANES):
                linear[j] += weight * own[j]


@scalar
def _advance(row, normals, measured, interval, time_error, difference, state):
    """One step of every lane's run with the measured raw output."""
    stamps = normals[(row + CHANNELS) * LANES : (row + CHANNELS + 1) * LANES]
    for j in range(LANES):
        e = np.float64(stamps[j])
        state[SPEED + j] = step_on(
            state[SPEED + j],
            e,
            state[STAMP + j],
            difference,
            state[K0 + j],
            state[KX + j],
            state[KY + j],
            state[KZ + j],
            measured[j],
            measured[LANES + j],
            measured[2 * LANES + j],
            interval,
            time_error,
        )
        state[STAMP + j] = e


@kernel
def simulate_measured(
    key: np.uint64,
    first: np.uint64,
    count: int,
    runs: int,
    at_rest: int,
    signals: Array,
    inputs: Array,
    uncertainties: Array,
    offset_deviations: Array,
    interval: float,
    time_error: float,
    stamps: bool,
    order: int,
    instants: NDArray[np.int64],
    truth: Array,
    weights: LinearWeights,
    given: NDArray[np.float32],
    errors: Array,
    linear: Array,
    curves: Array,
    terms: ErrorTerms,
) -> None:
    """Velocity errors of ``count`` groups of ``runs`` runs, from group ``first`` on.

    Parameters are those of ``mcsim.kernels.velocity.simulate``, and

    at_rest : int
        Samples at rest.
    signals : float64 (N, 6)
        Undisturbed raw output of the axes (fractions of g) at the samples of the rest and of
        all runs, and what of it the mixing coefficients act on.
    inputs, uncertainties : float64 (14,)
        As there, but the mean raw output at rest is measured.
    offset_deviations : float64 (3,)
        Standard deviations of the axes' constant offsets.
    weights : LinearWeights
    given : float32 (17 + k, count) or (0, 0)
        Normals for what a group draws once, instead of drawing them, unless empty; 17 + k is
        the least multiple of four that holds 17 + m.
    terms : ErrorTerms
        Of the three axes over all samples of a group; m are its mixing coefficients.
    """
    n_instants = len(instants)
    n = (len(signals) - at_rest) // runs
    with_linear = linear.shape[1] > 0
    with_curves = curves.shape[0] > 0
    with_given = given.shape[1] > 0
    difference = 1.0 if stamps else 0.0
    stamp_error = time_error * math.sqrt(0.5) if stamps else time_error
    drawn_rows = constant_rows(len(terms.mix_deviation))
    random_state = np.empty(4 * LANES, np.uint32)
    normals = np.empty(12 * LANES, np.float32)
    constants = np.zeros(drawn_rows * LANES, np.float32)
    scratch = make_scratch(terms)
    offsets = np.empty(CHANNELS * LANES, np.float64)
    measured = np.empty(CHANNELS * LANES, np.float64)
    rest = np.empty(CHANNELS * LANES, np.float64)
    rest_linear = np.empty(CHANNELS * LANES, np.float64)
    systematic = np.empty(LANES, np.float64)
    silent = np.zeros(4)
    state = np.zeros(N_STATE, np.float64)
    sums = np.empty((n_instants, 5, LANES), np.float64)
    for block in range((count + LANES - 1) // LANES):
        start = block * LANES
        filled = min(LANES, count - start)
        block_first = first + uint64(start)
        if with_given:
            take_constants(given, start, filled, drawn_rows, constants)
        else:
            draw_constants(key, block_first, drawn_rows, constants)
        start_measuring(key, block_first, terms, MIXING, constants, scratch)
        _start_offsets(constants, offset_deviations, offsets)

        seed_lanes(key, block_first, REST_NOISE, random_state)
        rest[:] = 0.0
        rest_linear[:] = 0.0
        for i in range(at_rest):
            part = i % GROUP
            if part == 0:
                draw_group(random_state, normals)
            row = CHANNELS * part
            measure(
                i, CHANNELS, row, normals, row, normals, signals, offsets, terms, scratch, measured
            )
            own = weights.samples[i] if with_linear else silent
            _add_rest(row, normals, own, measured, rest, rest_linear)
        rest /= at_rest
        start_groups(constants, inputs, uncertainties, order, rest, state)

        seed_lanes(key, block_first, WHITE_NOISE, random_state)
        for run in range(runs):
            if stamps:
                draw_group(random_state, normals)
            start_run(stamps, normals, state)
            begin = at_rest + run * n
            done = 0
            # Beyond the last instant the sensor goes on, until the next run.
            for segment in range(n_instants + 1):
                asked = segment < n_instants
                if with_linear and asked:
                    _add_states(weights.states[segment], scratch[1], state)
                end = instants[segment] if asked else n
                for i in range(done, end):
                    part = i % STEPS
                    if part == 0:
                        draw_group(random_state, normals)
                    row = 4 * part
                    if with_linear and asked:
                        add_linear(
                            begin + i, row * LANES, normals, weights.samples, difference, state
                        )
                    measure(
                        begin + i, CHANNELS, row, normals, row, normals, signals, offsets, terms,
                        scratch, measured,
                    )  # fmt: skip
                    _advance(row, normals, measured, interval, stamp_error, difference, state)
                done = end
                if asked:
                    keep_run(run, state, sums[segment])
                    if with_curves:
                        for j in range(filled):
                            curves[segment, run, start + j] = state[SPEED + j]
        for instant in range(n_instants):
            finish_errors(instant, start, filled, runs, truth[instant], sums[instant], errors)
            if with_linear:
                add_constants(weights.constants[instant], constants, systematic)
                _add_rest_weights(weights.rest[instant], rest_linear, systematic)
                finish_linear(instant, start, filled, runs, systematic, sums[instant], linear)


@scalar
def _add_rest_weights(weights, rest_linear, systematic):
    """Add what the linear errors of the means at rest make of the velocity."""
    for channel in range(CHANNELS):
        for j in range(LANES):
            systematic[j] += weights[channel] * rest_linear[channel * LANES + j]
