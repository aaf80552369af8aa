"""From a path to a log, whatever kind of file it is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from mcsim.errors import InputError
from mcsim.logs.checks import check_gravity
from mcsim.logs.clock import Clock, mend_clock
from mcsim.logs.formats import read_table
from mcsim.logs.model import ACCELEROMETER, KIND, Array, Channel, Log, ReadOptions
from mcsim.logs.names import CHANNELS, TIME
from mcsim.logs.table import Table
from mcsim.logs.timing import HIGHEST_RATE, LOWEST_RATE, Spacing, check_stamps, unstamped
from mcsim.units import KINDS


def read_log(path: Path, options: ReadOptions | None = None, at_rest: bool = True) -> Log:
    """Read a static log of any format that ``LOG_FORMATS`` lists.

    Where the sensor is not ``at_rest`` in one position, its mean says nothing of its unit.

    Raises
    ------
    InputError
        One message that says what is wrong with which file, row or column.
    """
    options = options or ReadOptions()
    if not path.exists():
        raise InputError(f"{path}: no such file")
    if options.rate is not None and not LOWEST_RATE <= options.rate <= HIGHEST_RATE:
        raise InputError(
            f"--rate {options.rate:g} Hz: must lie between {LOWEST_RATE:g} Hz and "
            f"{HIGHEST_RATE:g} Hz"
        )
    return _log_of(path, read_table(path, options), options, at_rest)


def _log_of(path: Path, table: Table, options: ReadOptions, at_rest: bool) -> Log:
    where = str(path)
    values = dict(table.values)
    spacing = _spacing(values, options, where)
    channels = []
    for name, (element, axis) in CHANNELS.items():
        if name in values:
            _refuse_beyond_use(values[name], element, name, where)
            channels.append(Channel(element, axis, spacing.apply(values[name])))
    unit = table.units.get(ACCELEROMETER, ("m/s²", 1.0))
    gravity = check_gravity(channels, *unit, where) if at_rest else None
    notes = [*spacing.timing.notes, *([gravity] if gravity else [])]
    return Log(path, tuple(channels), spacing.timing, tuple(notes), table.notes)


def _refuse_beyond_use(samples: Array, element: str, name: str, where: str) -> None:
    kind = KINDS[KIND[element]]
    largest = float(np.max(np.abs(samples)))
    if largest > kind.largest:
        raise InputError(
            f"{where}: {name} reaches {largest:.3g} {kind.si_unit}, beyond any sensor; is its unit "
            "right?"
        )


def _spacing(values: dict[str, Array], options: ReadOptions, where: str) -> Spacing:
    """How the columns are made equally spaced; what lies outside the cut is never looked at."""
    stamps = values.pop(TIME, None)
    columns = np.array(list(values.values()))
    if stamps is not None:
        same = np.concatenate([[False], np.all(np.diff(columns) == 0.0, axis=0)])
        clock = mend_clock(stamps, same)
        if options.rate is None or clock.interval > 0.0:
            return check_stamps(_cut(clock, options, where), options.rate, where)
        return _cut_rows(check_stamps(clock, options.rate, where), options, where)
    if options.rate is None:
        raise InputError(f"{where}: has no time stamps; give the sampling rate, --rate 100")
    return _cut_rows(unstamped(options.rate, columns.shape[1]), options, where)


def _cut(clock: Clock, options: ReadOptions, where: str) -> Clock:
    _check_cut(options, float(clock.stamps[-1]) + clock.interval, where)
    return clock.between(options.start, options.end)


def _cut_rows(spacing: Spacing, options: ReadOptions, where: str) -> Spacing:
    rate = spacing.timing.rate
    _check_cut(options, len(spacing.rows) / rate, where)
    end = None if options.end is None else round(options.end * rate)
    return replace(spacing, rows=spacing.rows[round((options.start or 0.0) * rate) : end])


def _check_cut(options: ReadOptions, duration: float, where: str) -> None:
    if options.start is None and options.end is None:
        return
    start, end = options.start or 0.0, options.end if options.end is not None else duration
    if not 0.0 <= start < min(end, duration):
        raise InputError(
            f"{where}: --start {start:g} s and --end {end:g} s leave nothing of the "
            f"{duration:.6g} s that the log lasts"
        )
