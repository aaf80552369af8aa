"""Sampling intervals that vary, as the steps of timed systems read them.

Sample i is taken at its instant, given by the intervals among the signals, and a little beside it:
instants err by normals, which sensors see as well (see the jitter in ``measurement``).  Its stamp
errs by a normal of its own, and some samples are lost.  A step reads the interval since the last
sample that arrived: by the stamps, or one sampling interval whatever they say.  A sample that is
lost has none, and leaves the state as it is.

Errors are those at the instant of the last sample.  To first order that is a last interval that
ends where it should, since the motion goes on alike from there.  The first and the last sample are
never lost, and the first one's instant is where time begins.

All is counted in sampling intervals.
"""

from __future__ import annotations

import numpy as np

from mcsim.kernels.lane_loops import row_of
from mcsim.kernels.lane_steps import is_timed, read_of
from mcsim.kernels.lanes import LANES, NORMALS, seed_lanes
from mcsim.kernels.parts import made
from mcsim.kernels.system import interval_place, read_interval, record_time, start_times

#: Stream of a realization for the stamps: errors of stamps, losses, errors of the first stamp.
TIMES = 4
#: Rows of scratch: how late a sample is, what its stamp adds, the time since the last that arrived.
ROWS = 3
_LATE, _STAMP, _SINCE = range(ROWS)


@made(start_times)
def _make_start_times(system):
    if not is_timed(system):
        return lambda system, key, first, streams, times: None
    place = 4 * (system.CHANNELS // 3) * LANES

    def start(system, key, first, streams, times):
        seed_lanes(key, first, TIMES, streams[place : place + 4 * LANES])
        times[:] = 0.0

    return start


@made(read_interval)
def _make_read_interval(system):
    if not is_timed(system):
        return _nothing
    behind, drawn = read_of(system) - 1, system.CHANNELS // 3 * NORMALS

    def read(system, clock, number, last, place, i, deviations, signals, normals, times, measured):
        own, given = row_of(measured, behind), signals[i, signals.shape[1] - 1]
        late, stamp, since = row_of(times, _LATE), row_of(times, _STAMP), row_of(times, _SINCE)
        row = drawn + 3 * place
        errs, chance = row_of(normals, row), row_of(normals, row + 1)
        before = row_of(normals, row + 2)
        if number == 1:
            for j in range(LANES):
                late[j], since[j] = 0.0, 0.0
                stamp[j] = clock.stamps * np.float64(before[j])
        for j in range(LANES):
            now, says = clock.jitter * deviations[j], clock.stamps * np.float64(errs[j])
            passed = since[j] + given + (now - late[j]) + (says - stamp[j])
            arrived = last or not chance[j] < clock.lost
            taken = 1.0 if clock.nominal else passed
            taken = taken - now if last else taken
            own[j] = taken if arrived else 0.0
            since[j] = 0.0 if arrived else passed
            late[j] = 0.0 if last else now
            stamp[j] = says

    return read


def _nothing(system, clock, number, last, place, i, deviations, signals, normals, times, measured):
    """The intervals are even."""


@made(record_time)
def _make_record_time(system):
    if not is_timed(system) or read_of(system) > system.CHANNELS + 1:
        return lambda system, asked, start, filled, times, history: None
    row = system.HISTORY - 1

    def record(system, asked, start, filled, times, history):
        for j in range(filled):
            history[row, asked, start + j] = system.interval * times[_LATE * LANES + j]

    return record


@made(interval_place)
def _make_interval_place(system):
    place = read_of(system) - 1 if is_timed(system) else -1
    return lambda system: place
