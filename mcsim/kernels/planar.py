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

What is left are some 500 vector instructions for 16 lanes and four samples, two thirds of them
for the normals: nearly four cycles per realization and sample where two units of 512 bits
execute them, two where there are four.

The measured channels are forward acceleration, leftward acceleration and turn
(yaw rate times sampling interval), in this order everywhere.
"""

from __future__ import annotations

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel
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
from mcsim.kernels.planar_ends import (
    add_linear,
    add_linear_of_two,
    finish_block,
    record_states,
    start_block,
    start_linear,
)
from mcsim.kernels.planar_layout import (
    ERRORS,
    HISTORY_ROWS,
    LINEAR_ERRORS,
    N_CONSTANTS,
    N_STATE,
    NOISE_0,
    OFFSETS,
)
from mcsim.kernels.planar_steps import (
    advance,
    advance_exactly,
    advance_four,
    advance_four_little,
    advance_trapezoidal,
    advance_trapezoidal_exactly,
    keep_measured,
    measure_plainly,
)
from mcsim.kernels.rotation import LARGEST_TURN, LITTLE_TURN

__all__ = ["ERRORS", "HISTORY_ROWS", "LINEAR_ERRORS", "N_CONSTANTS", "simulate"]

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
    n_constants = (N_CONSTANTS + len(terms.mix_deviation) + 3) // 4 * 4
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
    state = np.empty(N_STATE, np.float64)
    for block in range((count + LANES - 1) // LANES):
        start = block * LANES
        filled = min(LANES, count - start)
        block_first = first + uint64(start)
        if with_given:
            take_constants(given, start, filled, n_constants, constants)
        elif with_constants:
            draw_constants(key, block_first, n_constants, constants)
        start_block(constants, deviations, initial, interval, state)
        offsets = state[OFFSETS : OFFSETS + 3 * LANES]
        if with_linear:
            start_linear(constants, linear_constants, state)
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
                add_linear_of_two(i, 0, normals, sensitivity, state)
                add_linear_of_two(i + 2, 6 * LANES, normals, sensitivity, state)
            elif with_linear and not at_0:
                for k in range(size):
                    add_linear(i + k, k, normals, sensitivity, state)
            if by_fours and at_0:
                continue
            if by_fours and size == GROUP:
                if little:
                    advance_four_little(i, normals, signals, white, state)
                else:
                    advance_four(i, normals, signals, white, state)
                continue
            for k in range(size):
                sample = 0 if at_0 else i + k
                row = NOISE_0 if at_0 else 3 * k
                source = constants if at_0 else normals
                if plain:
                    measure_plainly(sample, row, source, signals, white, state, measured)
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
                    keep_measured(measured, state)
                elif trapezoidal and exact:
                    advance_trapezoidal_exactly(measured, previous_share, state)
                elif trapezoidal:
                    advance_trapezoidal(measured, previous_share, state)
                elif exact:
                    advance_exactly(measured, state)
                else:
                    advance(measured, state)
                if record:
                    record_states(state, sample, start, filled, interval, history)
        finish_block(state, start, filled, interval, final, errors, linear)
