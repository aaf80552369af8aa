"""Loops over lanes that any system gets from its class: random numbers, channels, steps.

They are made while a kernel is compiled, from what ``system`` says of the class.
"""

from __future__ import annotations

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import GROUP, LANES, draw_group, seed_lanes
from mcsim.kernels.parts import loader, made, store, take
from mcsim.kernels.system import (
    Step,
    advance,
    advance_four,
    draw,
    first_normals,
    goes_by_fours,
    linear_rows,
    numbers,
    read_plainly,
    reads_late,
    remembers,
    rows_of,
    seed,
    start_offsets,
)


@made(numbers)
def _make_numbers(system):
    found = system.CHANNELS, system.CONSTANTS, len(system.LINEAR), *rows_of(system)
    return lambda system: found


@made(linear_rows)
def _make_linear_rows(system):
    rows = system.LINEAR
    return lambda system: rows


@made(seed)
def _make_seed(system):
    numbers = system.STREAMS

    def put(system, key, first, streams):
        for three in range(len(numbers)):
            own = streams[4 * three * LANES : 4 * (three + 1) * LANES]
            seed_lanes(key, first, numbers[three], own)

    return put


@made(draw)
def _make_draw(system):
    threes = system.CHANNELS // 3
    if threes == 1:
        return lambda system, streams, normals: draw_group(streams, normals)

    def draw(system, streams, normals):
        for three in range(threes):
            own = streams[4 * three * LANES : 4 * (three + 1) * LANES]
            draw_group(own, normals[12 * three * LANES : 12 * (three + 1) * LANES])

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

    def put(system, constants, normals):
        for three in range(len(first)):
            for channel in range(3):
                drawn = row_of(constants, first[three] + channel)
                own = row_of(normals, 3 * GROUP * three + channel)
                for j in range(LANES):
                    own[j] = drawn[j]

    return put


@made(advance)
def _make_advance(system):
    return _chosen(_by_step(enumerate(system.STEPS)), _loop_of_one, system)


@made(advance_four)
def _make_advance_four(system):
    return _chosen_of_four(_by_step(system.FOURS.items()), _loop_of_four, system)


def _by_step(ways):
    """Pairs of a step and of all the ways that take it."""
    found: dict[Step, list[int]] = {}
    for way, step in ways:
        found.setdefault(step, []).append(way)
    return [(step, tuple(taken)) for step, taken in found.items()]


@made(goes_by_fours)
def _make_goes_by_fours(system):
    ways = tuple(system.FOURS)
    return lambda system: system.way in ways


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

    def read(system, i, k, signals, white, normals, rows, measured):
        for channel in range(count):
            value, deviation = signals[i, channel], white[channel]
            drawn = row_of(normals, (channel // 3 * GROUP + k) * 3 + channel % 3)
            offset, own = row_of(rows, offsets // LANES + channel), row_of(measured, channel)
            for j in range(LANES):
                own[j] = _disturbed(value, deviation, offset[j], drawn[j])

    return read


@scalar
def row_of(array, number):
    """Row ``number`` of a flat array; see ``measurement``."""
    return array[number * LANES : (number + 1) * LANES]


@scalar
def _disturbed(value, deviation, offset, normal):
    return value + offset + deviation * normal


@scalar
def _silent(value, deviation, offset, normal):
    return value + deviation * normal


def _loop_of_one(system, step):
    count, function, load = system.CHANNELS, step.function, loader(step.state)

    @scalar
    def loop(system, measured, rows):
        for j in range(LANES):
            store(rows, j, function(system, load(rows, j), take(measured, j, count)))

    return loop


def _loop_of_four(system, step):
    count, offsets = system.CHANNELS, rows_of(system)[0]
    function, load = step.function, loader(step.state)
    ideal, read = _ideal(count), _read(count, _disturbed if step.offsets else _silent)

    @scalar
    def loop(system, i, signals, white, normals, rows):
        first, second = ideal(signals[i]), ideal(signals[i + 1])
        third, fourth = ideal(signals[i + 2]), ideal(signals[i + 3])
        deviations = ideal(white)
        for j in range(LANES):
            state, own = load(rows, j), take(rows, offsets + j, count)
            state = function(system, state, read(first, deviations, own, normals, 0, j))
            state = function(system, state, read(second, deviations, own, normals, 3, j))
            state = function(system, state, read(third, deviations, own, normals, 6, j))
            state = function(system, state, read(fourth, deviations, own, normals, 9, j))
            store(rows, j, state)

    return loop


def _ideal(count):
    """Reads the first ``count`` numbers of a row: out of the lane loop, as a tuple."""
    last = count - 3
    if not last:
        return scalar(lambda row: (row[0], row[1], row[2]))
    before = _ideal(last)
    return scalar(lambda row: (*before(row), row[last], row[last + 1], row[last + 2]))


def _read(count, disturbed):
    """Measured channels of a lane's sample, whose normals begin at ``row`` of their group."""
    last = count - 3
    group = last * GROUP * LANES

    @scalar
    def three(ideal, white, offsets, normals, row, j):
        a, b, c = take(normals, group + row * LANES + j, 3)
        return (
            disturbed(ideal[last], white[last], offsets[last], a),
            disturbed(ideal[last + 1], white[last + 1], offsets[last + 1], b),
            disturbed(ideal[last + 2], white[last + 2], offsets[last + 2], c),
        )

    if not last:
        return three
    before = _read(last, disturbed)

    @scalar
    def read(ideal, white, offsets, normals, row, j):
        return (
            *before(ideal, white, offsets, normals, row, j),
            *three(ideal, white, offsets, normals, row, j),
        )

    return read


def _chosen(steps, make, system):
    """The loop of the step that the system's way says; ``steps`` are pairs of step and ways."""
    (step, ways), others = steps[0], steps[1:]
    loop = make(system, step)
    if not others:
        return lambda system, measured, rows: loop(system, measured, rows)
    other = scalar(_chosen(others, make, system))

    def choose(system, measured, rows):
        if system.way in ways:
            loop(system, measured, rows)
        else:
            other(system, measured, rows)

    return choose


def _chosen_of_four(steps, make, system):
    """The same for four samples."""
    (step, ways), others = steps[0], steps[1:]
    loop = make(system, step)
    if not others:
        return lambda system, i, signals, white, normals, rows: loop(
            system, i, signals, white, normals, rows
        )
    other = scalar(_chosen_of_four(others, make, system))

    def choose(system, i, signals, white, normals, rows):
        if system.way in ways:
            loop(system, i, signals, white, normals, rows)
        else:
            other(system, i, signals, white, normals, rows)

    return choose
