"""Dead reckoning of many disturbed realizations, as lanes of a block: one frame for every system.

Realizations are integrated side by side, ``LANES`` at a time: every state variable is one row of
a small array and the innermost loop runs over lanes, which LLVM vectorises.  Noise is drawn four
samples ahead into a scratch array and used at once; nothing is kept per sample.

What a system adds stands in ``system``; loops over lanes that all have alike in ``lane_loops``.

What makes it fast, measured in ``benchmarks/``:

* Scratch arrays are flat, rows at constant offsets: LLVM then knows that rows do
  not overlap and needs no checks.
* Four samples are integrated between loading and storing a lane's state.
* The sampling interval is factored out: velocities are summed as ``V = sum R a``
  and positions as ``P = sum V``, angles come as increments, and all is scaled at
  the end.
* Numbers and arrays of a system are apart: tuples that hold arrays would be counted at every
  sample.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel, scalar
from mcsim.kernels.lane_loops import row_of
from mcsim.kernels.lanes import GROUP, LANES, take_constants
from mcsim.kernels.measurement import make_scratch, measure, start_measuring
from mcsim.kernels.system import (
    Results,
    Sensors,
    Weights,
    add_linear,
    advance,
    advance_four,
    begin,
    draw,
    draw_once,
    finish,
    first_normals,
    goes_by_fours,
    keep,
    numbers,
    read_plainly,
    reads_late,
    record,
    remembers,
    seed,
    start_offsets,
)


@scalar
def _start_linear(constants, weights, errors, rows):
    """Linear errors from what is drawn once per realization."""
    for error in range(errors):
        own = row_of(rows, error)
        for j in range(LANES):
            own[j] = 0.0
        for k in range(weights.shape[1]):
            weight, drawn = weights[error, k], row_of(constants, k)
            for j in range(LANES):
                own[j] += weight * drawn[j]


@kernel
def simulate(
    system: Any,
    key: np.uint64,
    first: np.uint64,
    count: int,
    sensors: Sensors,
    weights: Weights,
    given: NDArray[np.float32],
    results: Results,
) -> None:
    """Dead-reckon ``count`` realizations from number ``first`` on; their errors at the last sample.

    Parameters
    ----------
    system : NamedTuple
        The numbers of a system; its class says how it moves.
    key, first : uint64
        Key of the random numbers and index of the first realization.
    count : int
    sensors : Sensors
    weights : Weights
        For linear errors; empty where they are not wanted.
    given : float32 (k, count) or (0, 0)
        Normals for what is drawn once per realization, instead of drawing them, unless empty;
        k are the system's constants and the mixing coefficients, in multiples of four.
    results : Results
        Written.
    """
    n_channels, n_fixed, n_linear, at_offsets, at_linear, _, end = numbers(system)
    signals, white, terms = sensors
    errors, linear, history = results
    n = signals.shape[0] - 1
    n_constants = n_fixed + (len(terms.mix_deviation) + 3) // 4 * 4
    plain = terms.innovation.shape[0] == 0
    recorded = history.shape[1] > 0
    with_linear = linear.shape[1] > 0
    with_given = given.shape[1] > 0
    by_fours = plain and not recorded and goes_by_fours(system)
    threes = n_channels // 3
    streams = np.empty(4 * threes * LANES, np.uint32)
    normals = np.empty(3 * GROUP * threes * LANES, np.float32)
    constants = np.zeros(n_constants * LANES, np.float32)
    scratch = make_scratch(terms)
    measured = np.empty(n_channels * LANES, np.float64)
    rows = np.empty(end, np.float64)
    offsets = rows[at_offsets : at_offsets + n_channels * LANES]
    for block in range((count + LANES - 1) // LANES):
        start = block * LANES
        filled = min(LANES, count - start)
        block_first = first + uint64(start)
        if with_given:
            take_constants(given, start, filled, n_constants, constants)
        elif system.draws or not plain:
            draw_once(system, key, block_first, n_constants, constants)
        if not plain:
            start_measuring(key, block_first, terms, n_fixed, constants, scratch)
        start_offsets(system, constants, rows)
        begin(system, constants, sensors, scratch, rows)
        if with_linear:
            _start_linear(constants, weights.constants, n_linear, rows[at_linear:])
        seed(system, key, block_first, streams)
        if (not plain or remembers(system)) and not reads_late(system):
            first_normals(system, constants, normals)
            if plain:
                read_plainly(system, 0, 0, signals, white, normals, rows, measured)
            else:
                measure(
                    0, n_channels, 0, normals, 3 * GROUP, normals, signals, offsets, terms,
                    scratch, measured,
                )  # fmt: skip
            keep(system, constants, measured, rows)
        if recorded:
            record(system, rows, 0, start, filled, history)
        for i in range(1, n + 1, GROUP):
            size = min(GROUP, n + 1 - i)
            draw(system, streams, normals)
            if with_linear:
                add_linear(system, i, size, normals, weights.samples, rows)
            if by_fours and size == GROUP:
                advance_four(system, i, signals, white, normals, rows)
                continue
            for k in range(size):
                if plain:
                    read_plainly(system, i + k, k, signals, white, normals, rows, measured)
                else:
                    measure(
                        i + k, n_channels, 3 * k, normals, 3 * (GROUP + k), normals, signals,
                        offsets, terms, scratch, measured,
                    )  # fmt: skip
                advance(system, measured, rows)
                if recorded:
                    record(system, rows, i + k, start, filled, history)
        finish(system, rows, start, filled, errors)
        if with_linear:
            for error in range(n_linear):
                own = row_of(rows, at_linear // LANES + error)
                for j in range(filled):
                    linear[error, start + j] = own[j]
