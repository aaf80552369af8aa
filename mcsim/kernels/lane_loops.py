"""Loops over lanes that any system gets from its class: random numbers, channels, steps.

They are made while a kernel is compiled, from what ``system`` says of the class.
"""

from __future__ import annotations

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lane_steps import bare_of, by_measured, by_noise, disturbed, is_timed, read_of
from mcsim.kernels.lanes import LANES, NORMALS, draw_group, seed_lanes
from mcsim.kernels.parts import made
from mcsim.kernels.system import (
    advance,
    advance_four,
    advance_plainly,
    draw,
    enter,
    finish,
    finish_linear,
    first_normals,
    goes_by_fours,
    leg,
    legs,
    linear_rows,
    numbers,
    outcome,
    read_bare,
    read_plainly,
    reads_late,
    remembers,
    rows_of,
    seed,
    start_linear,
    start_offsets,
)


@made(numbers)
def _make_numbers(system):
    streams = system.CHANNELS // 3 + is_timed(system)
    sizes = system.CHANNELS, read_of(system), streams, system.CONSTANTS, len(system.LINEAR)
    found = *sizes, *rows_of(system)
    return lambda system: found


@made(linear_rows)
def _make_linear_rows(system):
    rows = system.LINEAR
    return lambda system: rows


@made(legs)
def _make_legs(system):
    return lambda system: 1


@made(leg)
def _make_leg(system):
    return lambda system, number, n: (system.way, 0, n, 3, 0)


@made(seed)
def _make_seed(system):
    numbers = system.STREAMS

    def put(system, number, key, first, streams, normals):
        for three in range(len(numbers)):
            own = streams[4 * three * LANES : 4 * (three + 1) * LANES]
            seed_lanes(key, first, numbers[three], own)

    return put


@made(enter)
def _make_enter(system):
    return lambda system, number, constants, normals, rows: None


@made(start_linear)
def _make_start_linear(system):
    count, linear = len(system.LINEAR), rows_of(system)[1] // LANES

    def start(system, constants, weights, rows):
        for error in range(count):
            own = row_of(rows, linear + error)
            for j in range(LANES):
                own[j] = 0.0
            for k in range(weights.constants.shape[1]):
                weight, drawn = weights.constants[error, k], row_of(constants, k)
                for j in range(LANES):
                    own[j] += weight * drawn[j]

    return start


@made(finish_linear)
def _make_finish_linear(system):
    count, row = len(system.LINEAR), rows_of(system)[1] // LANES

    def finish(system, constants, weights, start, filled, rows, linear):
        for error in range(count):
            own = row_of(rows, row + error)
            for j in range(filled):
                linear[error, start + j] = own[j]

    return finish


@made(outcome)
def _make_outcome(system):
    return lambda system, rows, errors: finish(system, rows, 0, LANES, errors)


@made(draw)
def _make_draw(system):
    threes = system.CHANNELS // 3 + is_timed(system)
    if threes == 1:
        return lambda system, streams, normals: draw_group(streams, normals)

    def draw(system, streams, normals):
        for three in range(threes):
            own = streams[4 * three * LANES : 4 * (three + 1) * LANES]
            draw_group(own, normals[NORMALS * three * LANES : NORMALS * (three + 1) * LANES])

    return draw


@made(start_offsets)
def _make_start_offsets(system):
    count, fixed, offsets = system.CHANNELS, system.FIXED, rows_of(system)[0]

    def start(system, constants, rows):
        for channel in range(count):
            drawn = row_of(constants, fixed[channel // 3] + channel % 3)
            own, deviation = row_of(rows, offsets // LANES + channel), system.deviations[channel]
            for j in range(LANES):
                own[j] = deviation * drawn[j]

    return start


@made(first_normals)
def _make_first_normals(system):
    first = system.FIRST
    if not first:
        return lambda system, constants, normals: None

    def put(system, constants, normals):
        for three in range(len(first)):
            for channel in range(3):
                drawn = row_of(constants, first[three] + channel)
                own = row_of(normals, NORMALS * three + channel)
                for j in range(LANES):
                    own[j] = drawn[j]

    return put


@made(advance)
def _make_advance(system):
    return by_measured(system)


@made(advance_four)
def _make_advance_four(system):
    if not system.FOURS:
        return lambda system, way, i, signals, white, normals, rows: None
    return by_noise(system, NORMALS // (3 + bare_of(system)))


@made(advance_plainly)
def _make_advance_plainly(system):
    width = 3 + bare_of(system)
    if not getattr(system, "SINGLY", False):

        def advance_measured(system, way, i, row, signals, white, normals, rows, measured):
            read_plainly(system, i, row, signals, white, normals, rows, measured)
            read_bare(system, width, row, normals, measured)
            advance(system, way, measured, rows)

        return advance_measured
    take_one = scalar(by_noise(system, 1))

    def advance_at_once(system, way, i, row, signals, white, normals, rows, measured):
        take_one(system, way, i, signals, white, normals[row * LANES :], rows)

    return advance_at_once


@made(goes_by_fours)
def _make_goes_by_fours(system):
    ways = tuple(system.FOURS) or (-1,)
    return lambda system, way: way in ways


@made(remembers)
def _make_remembers(system):
    fewest = min(len(step.state._fields) for step in system.STEPS)
    ways = tuple(
        way for way, step in enumerate(system.STEPS) if len(step.state._fields) > fewest
    ) or (-1,)
    return lambda system: system.way in ways


@made(reads_late)
def _make_reads_late(system):
    ways = getattr(system, "LATE", ()) or (-1,)
    return lambda system: system.way in ways


@made(read_plainly)
def _make_read_plainly(system):
    count, offsets = system.CHANNELS, rows_of(system)[0]

    def read(system, i, row, signals, white, normals, rows, measured):
        for channel in range(count):
            value, deviation = signals[i, channel], white[channel]
            drawn = row_of(normals, channel // 3 * NORMALS + row + channel % 3)
            offset, own = row_of(rows, offsets // LANES + channel), row_of(measured, channel)
            for j in range(LANES):
                own[j] = disturbed(value, deviation, offset[j], drawn[j])

    return read


@made(read_bare)
def _make_readbare_of(system):
    count, bare = system.CHANNELS, bare_of(system)
    if not bare:
        return lambda system, width, row, normals, measured: None

    def read(system, width, row, normals, measured):
        for number in range(width - 3):
            drawn, own = row_of(normals, row + 3 + number), row_of(measured, count + number)
            for j in range(LANES):
                own[j] = drawn[j]

    return read


@scalar
def row_of(array, number):
    """Row ``number`` of a flat array; see ``measurement``."""
    return array[number * LANES : (number + 1) * LANES]
