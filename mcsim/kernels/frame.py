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
from mcsim.kernels.intervals import ROWS
from mcsim.kernels.lane_loops import row_of
from mcsim.kernels.lanes import LANES, NORMALS, take_constants
from mcsim.kernels.measurement import make_scratch, measure, start_measuring
from mcsim.kernels.system import (
    Results,
    Sensors,
    Weights,
    add_linear,
    advance,
    advance_four,
    advance_plainly,
    begin,
    draw,
    draw_once,
    enter,
    finish,
    finish_linear,
    first_normals,
    goes_by_fours,
    keep,
    leg,
    legs,
    numbers,
    read_bare,
    read_interval,
    read_plainly,
    reads_late,
    record,
    record_time,
    remembers,
    seed,
    start_linear,
    start_offsets,
    start_times,
)


@scalar
def _next_instant(instants, asked, count):
    """The sample of instant ``asked``, or one beyond the leg's last."""
    return instants[asked] if asked < len(instants) else count + 1


@scalar
def _expect(asked, weights, processes, rows):
    """Add what the processes' states make of the linear errors until the next instant."""
    if asked < weights.shape[0]:
        for error in range(weights.shape[1]):
            own = row_of(rows, error)
            for state in range(weights.shape[2]):
                weight, value = weights[asked, error, state], row_of(processes, state)
                for j in range(LANES):
                    own[j] += weight * value[j]


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
        at most the system's constants and the mixing coefficients, in multiples of four, and
        what is missing is zero.
    results : Results
        Written.
    """
    n_channels, n_read, threes, n_fixed, _, at_offsets, at_linear, _, end = numbers(system)
    signals, white, terms, clock = sensors
    errors, linear, history, instants = results
    n = signals.shape[0] - 1
    n_constants = (n_fixed + len(terms.mix_deviation) + 3) // 4 * 4
    plain = terms.innovation.shape[0] == 0
    with_linear = linear.shape[1] > 0
    with_given = given.shape[1] > 0
    streams = np.empty(4 * threes * LANES, np.uint32)
    normals = np.empty(NORMALS * threes * LANES, np.float32)
    constants = np.zeros(n_constants * LANES, np.float32)
    scratch = make_scratch(terms)
    measured = np.empty(n_read * LANES, np.float64)
    times = np.empty(ROWS * LANES, np.float64)
    deviations = scratch[0][len(terms.mix_deviation) * LANES :]
    rows = np.empty(end, np.float64)
    offsets = rows[at_offsets : at_offsets + n_channels * LANES]
    for block in range((count + LANES - 1) // LANES):
        start = block * LANES
        filled = min(LANES, count - start)
        block_first = first + uint64(start)
        if with_given:
            take_constants(given, start, filled, len(given), constants)
        elif system.draws or not plain:
            draw_once(system, key, block_first, n_constants, constants)
        if not plain:
            start_measuring(key, block_first, terms, n_fixed, constants, scratch)
        start_times(system, key, block_first, streams, times)
        start_offsets(system, constants, rows)
        begin(system, constants, sensors, scratch, rows)
        if with_linear:
            start_linear(system, constants, weights, rows)
        if (not plain or remembers(system)) and not reads_late(system):
            first_normals(system, constants, normals)
            if plain:
                read_plainly(system, 0, 0, signals, white, normals, rows, measured)
            else:
                measure(
                    0, n_channels, 0, normals, NORMALS, normals, signals, offsets, terms,
                    scratch, measured,
                )  # fmt: skip
            keep(system, constants, measured, rows)
        for number in range(legs(system)):
            way, before, samples, width, asked = leg(system, number, n)
            by_fours = plain and goes_by_fours(system, way)
            group = NORMALS // width
            seed(system, number, key, block_first, streams, normals)
            enter(system, number, constants, normals, rows)
            instant = _next_instant(instants, asked, samples)
            if instant == 0:
                record(system, number, asked, start, filled, rows, errors, linear, history)
                record_time(system, asked, start, filled, times, history)
                asked += 1
                instant = _next_instant(instants, asked, samples)
            if with_linear:
                _expect(asked, weights.states, scratch[1], rows[at_linear:])
            for i in range(1, samples + 1, group):
                size = min(group, samples + 1 - i)
                draw(system, streams, normals)
                k = 0
                while k < size:
                    # Of the samples drawn, those until the next instant.
                    until = min(size, instant + 1 - i)
                    if with_linear:
                        add_linear(
                            system, way, before + i, k, until, normals, weights.samples, rows
                        )
                    if by_fours and until - k == group:
                        advance_four(system, way, before + i, signals, white, normals, rows)
                        k = until
                    while k < until:
                        at, row = before + i + k, width * k
                        last = i + k == samples
                        if plain:
                            read_interval(
                                system, clock, i + k, last, k, at, deviations, signals, normals,
                                times, measured,
                            )  # fmt: skip
                            advance_plainly(
                                system, way, at, row, signals, white, normals, rows, measured
                            )
                        else:
                            # Rows count from slices: LLVM then knows that none is negative.
                            measure(
                                at, n_channels, 0, normals[row * LANES :], 0,
                                normals[(NORMALS + row) * LANES :], signals, offsets, terms,
                                scratch, measured,
                            )  # fmt: skip
                            read_bare(system, width, row, normals, measured)
                            read_interval(
                                system, clock, i + k, last, k, at, deviations, signals, normals,
                                times, measured,
                            )  # fmt: skip
                            advance(system, way, measured, rows)
                        k += 1
                    if i + k > instant:
                        record(system, number, asked, start, filled, rows, errors, linear, history)
                        record_time(system, asked, start, filled, times, history)
                        asked += 1
                        instant = _next_instant(instants, asked, samples)
                        if with_linear:
                            _expect(asked, weights.states, scratch[1], rows[at_linear:])
        finish(system, rows, start, filled, errors)
        if with_linear:
            finish_linear(system, constants, weights, start, filled, rows, linear)
