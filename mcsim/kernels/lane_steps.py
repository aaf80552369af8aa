"""Loops over lanes around a system's steps: of samples as measured, or measured and taken at once.

They are made from a system's class while a kernel is compiled; a kernel that knows several ways of
taking a sample holds a loop for each and chooses by the way.
"""

from __future__ import annotations

from typing import Any

from mcsim.kernels.compilation import scalar
from mcsim.kernels.lanes import LANES, NORMALS
from mcsim.kernels.parts import loader, store, take
from mcsim.kernels.system import Step, rows_of


def bare_of(system):
    """Normals of a sample that the system's step reads as they are."""
    return getattr(system, "BARE", 0)


def is_timed(system):
    """Whether the system's step reads the interval before the sample."""
    return getattr(system, "TIMED", False)


def read_of(system: type[Any]) -> int:
    """How many numbers the system's step reads."""
    return int(system.CHANNELS + bare_of(system) + is_timed(system))


def by_measured(system):
    """The loop of one sample with what was measured, by way."""
    return _chosen(_by_step(enumerate(system.STEPS)), _loop_of_one, system)


def by_noise(system, samples):
    """The loop that measures some samples with noise and offsets and takes them at once, by way."""
    return _chosen_of_several(_by_step(system.FOURS.items()), _loop_of(samples), system)


def _by_step(ways):
    """Pairs of a step and of all the ways that take it."""
    found: dict[Step, list[int]] = {}
    for way, step in ways:
        found.setdefault(step, []).append(way)
    return [(step, tuple(taken)) for step, taken in found.items()]


@scalar
def disturbed(value, deviation, offset, normal):
    """What a channel measures where noise and an offset are all that disturbs it."""
    return value + offset + deviation * normal


@scalar
def _silent(value, deviation, offset, normal):
    return value + deviation * normal


def _loop_of_one(system, step):
    count, function, load = read_of(system), step.function, loader(step.state)
    moving = _leading(step.moving or len(step.state._fields))

    @scalar
    def loop(system, measured, rows):
        for j in range(LANES):
            store(rows, j, moving(function(system, load(rows, j), take(measured, j, count))))

    return loop


def _loop_of(samples):
    """Makes loops that measure some samples and take them at once."""

    def make(system, step):
        count, offsets, width = system.CHANNELS, rows_of(system)[0], 3 + bare_of(system)
        load, ideal = loader(step.state), _ideal(count)
        all_ideal = _each(ideal, samples)
        read = _read(count, bare_of(system), disturbed if step.offsets else _silent)
        move = _moves(step.function, read, samples, width)
        moving = _leading(step.moving or len(step.state._fields))

        @scalar
        def loop(system, i, signals, white, normals, rows):
            ideals, deviations = all_ideal(signals, i), ideal(white)
            for j in range(LANES):
                state, own = load(rows, j), take(rows, offsets + j, count)
                moved = move(system, state, ideals, deviations, own, normals, j)
                store(rows, j, moving(moved))

        return loop

    return make


def _leading(count):
    """The first variables of a state, as a tuple."""
    last = count - 1
    if not last:
        return scalar(lambda state: (state[0],))
    before = _leading(last)
    return scalar(lambda state: (*before(state), state[last]))


def _ideal(count):
    """Reads the first ``count`` numbers of a row: out of the lane loop, as a tuple."""
    last = count - 3
    if not last:
        return scalar(lambda row: (row[0], row[1], row[2]))
    before = _ideal(last)
    return scalar(lambda row: (*before(row), row[last], row[last + 1], row[last + 2]))


def _each(ideal, count):
    """The same of ``count`` samples."""
    last = count - 1
    if not last:
        return scalar(lambda signals, i: (ideal(signals[i]),))
    before = _each(ideal, last)
    return scalar(lambda signals, i: (*before(signals, i), ideal(signals[i + last])))


def _moves(function, read, count, width):
    """Moves a lane's state by ``count`` samples, whose normals take ``width`` rows each."""
    last = count - 1
    row = width * last

    if not last:

        @scalar
        def move(system, state, samples, deviations, own, normals, j):
            return function(system, state, read(samples[0], deviations, own, normals, 0, j))

        return move

    before = _moves(function, read, last, width)

    @scalar
    def move_on(system, state, samples, deviations, own, normals, j):
        moved = before(system, state, samples, deviations, own, normals, j)
        return function(system, moved, read(samples[last], deviations, own, normals, row, j))

    return move_on


def _read(count, bare, disturbed):
    """Measured channels of a lane's sample, whose normals begin at ``row``, then the bare ones."""
    channels = _read_channels(count, disturbed)
    if not bare:
        return channels

    @scalar
    def read(ideal, white, offsets, normals, row, j):
        normal = take(normals, (row + 3) * LANES + j, bare)
        return (*channels(ideal, white, offsets, normals, row, j), *normal)

    return read


def _read_channels(count, disturbed):
    last = count - 3
    group = last // 3 * NORMALS * LANES

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
    before = _read_channels(last, disturbed)

    @scalar
    def read(ideal, white, offsets, normals, row, j):
        return (
            *before(ideal, white, offsets, normals, row, j),
            *three(ideal, white, offsets, normals, row, j),
        )

    return read


def _chosen(steps, make, system):
    """The loop of the step of a way; ``steps`` are pairs of step and ways."""
    (step, ways), others = steps[0], steps[1:]
    loop = make(system, step)
    if not others:
        return lambda system, way, measured, rows: loop(system, measured, rows)
    other = scalar(_chosen(others, make, system))

    def choose(system, way, measured, rows):
        if way in ways:
            loop(system, measured, rows)
        else:
            other(system, way, measured, rows)

    return choose


def _chosen_of_several(steps, make, system):
    """The same for the samples of a draw."""
    (step, ways), others = steps[0], steps[1:]
    loop = make(system, step)
    if not others:
        return lambda system, way, i, signals, white, normals, rows: loop(
            system, i, signals, white, normals, rows
        )
    other = scalar(_chosen_of_several(others, make, system))

    def choose(system, way, i, signals, white, normals, rows):
        if way in ways:
            loop(system, i, signals, white, normals, rows)
        else:
            other(system, way, i, signals, white, normals, rows)

    return choose
