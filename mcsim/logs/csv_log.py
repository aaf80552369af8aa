"""Logs as CSV files: a time column (or a rate), and channels with their units in the header."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError, UnitError
from mcsim.units import KINDS, factor

Array = NDArray[np.float64]
#: Name and unit behind each header.
Headers = dict[str, tuple[str, str | None]]

_FEWEST_ROWS = 64
_TIME_NAMES = ("time", "t", "timestamp")
#: Time stamps that stray further from an even grid (share of the step) are evened out.
_JITTER = 0.02
#: Stamps that stray by more steps have no one rate.
_WANDER = 2.0
#: A gap of more steps is a hole in the log, not jitter.
_LONGEST_GAP = 20.0
_HEADER = re.compile(r"\s*(?P<name>.*?)\s*(?:\[(?P<square>[^\]]*)\]|\((?P<round>.*)\))?\s*")


@dataclass(frozen=True)
class Log:
    """Evenly sampled channels of one kind.

    ``samples`` (n, channels) are in SI units, ``rate`` in Hz; ``notes`` say what was done to them.
    """

    name: str
    channels: tuple[str, ...]
    samples: Array
    rate: float
    notes: tuple[str, ...] = ()

    @property
    def time(self) -> Array:
        """Seconds since the first sample, (n,)."""
        seconds: Array = np.arange(len(self.samples), dtype=float) / self.rate
        return seconds


def read_csv_log(
    path: Path,
    kind: str = "acceleration",
    *,
    unit: str | None = None,
    rate: float | None = None,
    channels: tuple[str, ...] = (),
    time: str | None = None,
) -> Log:
    """The channels of ``kind`` in a CSV file whose header reads ``time [s],az [m/s²]``.

    Parameters
    ----------
    path : Path
        The file; compressed ones (.gz, .xz) too.
    kind : str
        Kind of quantity, a key of ``mcsim.units.KINDS``; other columns are left aside.
    unit : str, optional
        Unit of columns whose header has none.
    rate : float, optional
        Sampling rate (Hz), for a file without a time column.
    channels : tuple of str
        Names of the columns to take; all that fit if empty.
    time : str, optional
        Column of the time stamps as ``NAME in UNIT``; ``time``, ``t`` or ``timestamp`` if absent.

    Raises
    ------
    InputError
        No such file or column, no unit, no time, gaps, or cells that are no numbers.
    """
    import pandas as pd

    try:
        table = pd.read_csv(path, comment="#", skipinitialspace=True)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, ValueError, EOFError) as error:
        raise InputError(f"{path}: not a CSV file ({str(error).splitlines()[0]})") from None
    headers = {str(column): _split_header(str(column)) for column in table.columns}
    stamped = _time_column(path, headers, time)
    others = {column: h for column, h in headers.items() if stamped is None or column != stamped[0]}
    chosen = _choose(path, others, kind, unit, channels)
    if len(table) < _FEWEST_ROWS:
        raise InputError(f"{path}: {len(table)} rows are too few; at least {_FEWEST_ROWS}")
    cells = {column: _numbers(path, table[column].to_numpy(), column) for column in chosen}
    values = np.column_stack([cells[column] * si for column, si in chosen.items()])
    names = tuple(headers[column][0] for column in chosen)
    if stamped is None:
        if rate is None:
            raise InputError(f"{path}: no time column (such as `time [s]`); give --rate '100 Hz'")
        return Log(_name(path), names, values, rate)
    column, unit_of_time = stamped
    stamps = _numbers(path, table[column].to_numpy(), column)
    stamps = stamps * _factor(path, column, unit_of_time, "time")
    return _evenly(path, names, stamps, values)


def _name(path: Path) -> str:
    """The file's name without its endings (``log.csv.xz`` is ``log``)."""
    return path.name.removesuffix(path.suffix).removesuffix(".csv")


def _split_header(header: str) -> tuple[str, str | None]:
    match = _HEADER.fullmatch(header)
    assert match is not None
    return match["name"], match["square"] if match["square"] is not None else match["round"]


def _time_column(path: Path, headers: Headers, given: str | None) -> tuple[str, str] | None:
    """The column of the time stamps and its unit."""
    if given is not None:
        name, _, unit = given.partition(" in ")
        for column, (known, _) in headers.items():
            if known == name.strip():
                return column, unit.strip() or "s"
        raise InputError(f'{path}: no column "{name.strip()}" for the time')
    for column, (name, own) in headers.items():
        if name.casefold() in _TIME_NAMES:
            return column, own or "s"
    return None


def _choose(
    path: Path,
    headers: Headers,
    kind: str,
    unit: str | None,
    channels: tuple[str, ...],
) -> dict[str, float]:
    """Columns to take, with the SI value of their unit."""
    names = {name: column for column, (name, _) in headers.items()}
    for channel in channels:
        if channel not in names:
            raise InputError(f'{path}: no column "{channel}" (it has {", ".join(names)})')
    found = {}
    for column in [names[c] for c in channels] or headers:
        own = headers[column][1] or unit
        if own is None and channels:
            raise InputError(f"{path}: {column}: has no unit; give --unit '{KINDS[kind].si_unit}'")
        try:
            found[column] = factor(own or "", KINDS[kind])
        except UnitError as error:
            if channels:
                raise InputError(f"{path}: {column}: {error}") from None
    if not found:
        raise InputError(
            f"{path}: no column with a unit of {KINDS[kind]}; write headers such as "
            f"`az [{KINDS[kind].si_unit}]`, or name the columns with --channel and --unit"
        )
    return found


def _factor(path: Path, column: str, unit: str, kind: str) -> float:
    try:
        return factor(unit, KINDS[kind])
    except UnitError as error:
        raise InputError(f"{path}: {column}: {error}") from None


def _numbers(path: Path, cells: NDArray[np.generic], column: str) -> Array:
    try:
        numbers = cells.astype(float)
    except (ValueError, TypeError):
        numbers = np.array([_number(cell) for cell in cells])
    bad = np.flatnonzero(~np.isfinite(numbers))
    if len(bad):
        raise InputError(f'{path}:{bad[0] + 2}: {column}: "{cells[bad[0]]}" is not a finite number')
    return numbers


def _number(cell: object) -> float:
    try:
        return float(str(cell))
    except ValueError:
        return float("nan")


def _evenly(path: Path, names: tuple[str, ...], stamps: Array, values: Array) -> Log:
    """The log on an even grid of time; jittery stamps are interpolated."""
    steps = np.diff(stamps)
    backwards = np.flatnonzero(steps <= 0.0)
    if len(backwards):
        raise InputError(f"{path}:{backwards[0] + 3}: the time does not go forward here")
    median, widest = float(np.median(steps)), int(np.argmax(steps))
    if steps[widest] > _LONGEST_GAP * median:
        raise InputError(f"{path}:{widest + 3}: a gap of {steps[widest]:.3g} s; cut the log there")
    step = float((stamps[-1] - stamps[0]) / len(steps))
    grid = stamps[0] + step * np.arange(len(stamps))
    stray = float(np.abs(stamps - grid).max()) / step
    if stray <= _JITTER:
        return Log(_name(path), names, values, 1.0 / step)
    if stray > _WANDER:
        # The rate itself changes on the way: the usual step keeps what the faster parts hold.
        step = median
        grid = np.arange(stamps[0], stamps[-1], step)
    values = np.column_stack([np.interp(grid, stamps, column) for column in values.T])
    notes = (
        f"time stamps stray by up to {stray * step:.3g} s; interpolated to {1.0 / step:.6g} Hz",
    )
    return Log(_name(path), names, values, 1.0 / step, notes)
