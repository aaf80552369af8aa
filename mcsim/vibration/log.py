"""Logs of a vibration: channels of one kind on an even grid of time, from CSV files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError, UnitError
from mcsim.logs.columns import Column, said, time_column, written_column
from mcsim.logs.csv_file import CsvFile, open_csv, scaled, since_first
from mcsim.logs.names import is_acceleration
from mcsim.logs.titles import Title, factor_of, kind_of
from mcsim.units import KINDS, Kind

Array = NDArray[np.float64]

_FEWEST_ROWS = 64
#: Time stamps that stray further from an even grid (share of the step) are evened out.
_JITTER = 0.02
#: Stamps that stray by more steps have no one rate.
_WANDER = 2.0
#: A gap of more steps is a hole in the log, not jitter.
_LONGEST_GAP = 20.0
#: A stated rate may differ from that of the stamps by this part.
_RATE_TOLERANCE = 0.02
#: Rates beyond are those of a wrong unit of time (Hz).
_LOWEST_RATE, _HIGHEST_RATE = 0.05, 1e6


@dataclass(frozen=True)
class Log:
    """Evenly sampled channels of one kind.

    ``samples`` (n, channels) are in SI units, ``rate`` in Hz; ``notes`` say what was done to them,
    ``remarks`` how the file was read.
    """

    name: str
    channels: tuple[str, ...]
    samples: Array
    rate: float
    notes: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def time(self) -> Array:
        """Seconds since the first sample, (n,)."""
        seconds: Array = np.arange(len(self.samples), dtype=float) / self.rate
        return seconds


def read_vibration_log(
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
        Unit of columns whose header has none: of ``channels``, else of those that are
        accelerations by their name.
    rate : float, optional
        Sampling rate (Hz), for a file without a time column.
    channels : tuple of str
        Titles or names of the columns to take, or ``column 3``; all that fit if empty.
    time : str, optional
        Column of the time stamps as ``NAME in UNIT``; the one whose name says so if absent.

    Raises
    ------
    InputError
        No such file or column, no unit, no time, gaps, cells that are no numbers, a channel
        that is constant or beyond use, or stamps that contradict the rate.
    """
    file = open_csv(path)
    stamps = _stamps(file, time)
    chosen = _choose(file, kind, unit, channels, stamps)
    cells = file.numbers([*chosen, *([stamps.place] if stamps else [])])
    count = len(next(iter(cells.values())))
    if count < _FEWEST_ROWS:
        told = "1 row is" if count == 1 else f"{count} rows are"
        raise InputError(f"{path}: {told} too few; at least {_FEWEST_ROWS}")
    values = np.column_stack(
        [scaled(cells[c.place], c.factor, path, c.title) for c in chosen.values()]
    )
    names = tuple(column.name for column in chosen.values())
    _refuse_dead(path, names, values, KINDS[kind])
    columns = [*([stamps] if stamps else []), *chosen.values()]
    if stamps is not None:
        seconds = scaled(since_first(cells[stamps.place]), stamps.factor, path, stamps.title)
        log = _evenly(file, names, seconds, values, rate)
    elif rate is None:
        raise InputError(
            f"{path}: no time column (such as `time [s]`); name one with --time 'NAME in UNIT', or "
            "give --rate '100 Hz'"
        )
    else:
        log = Log(_name(path), names, values, rate)
    return replace(log, remarks=(said(file, columns), *file.notes))


def _name(path: Path) -> str:
    """The file's name without its endings (``log.csv.xz`` is ``log``)."""
    return path.name.removesuffix(path.suffix).removesuffix(".csv")


def _stamps(file: CsvFile, given: str | None) -> Column | None:
    """The column of the time stamps; its unit is stated, never taken for granted."""
    stated = ""
    if given is not None:
        name, _, stated = (part.strip() for part in given.partition(" in "))
        place = file.place_of(name)
        if place is None:
            raise InputError(f'{file.path}: no column "{name}" for the time (it has {_held(file)})')
    elif file.titles is None or (place := time_column(file)) is None:
        return None
    unit = stated or (file.titles[place].unit if file.titles else "")
    title = file.title(place)
    if not unit:
        raise InputError(
            f'{file.path}: the time column "{title}" has no unit; write "{title} [s]" into the '
            f"header, or give --time '{written_column(file, place)} in ms' (or s, µs, ns)"
        )
    return Column(place, title, "time", _factor(file, place, unit, "time"), unit)


def _choose(
    file: CsvFile,
    kind: str,
    unit: str | None,
    channels: tuple[str, ...],
    stamps: Column | None,
) -> dict[int, Column]:
    """The columns to take, by place: those named, else those whose unit or name fits.

    ``unit`` is that of columns whose header has none: of those that are named, else of those
    whose name is an acceleration's.
    """
    named = [_place(file, channel) for channel in channels]
    others = [i for i in range(file.count) if stamps is None or i != stamps.place]
    found: dict[int, Column] = {}
    used = False
    for place in named or [i for i in others if i not in file.layout.empty]:
        title = file.titles[place] if file.titles else Title("", "", "")
        fits = bool(channels) or (kind == "acceleration" and is_acceleration(title.name))
        own = title.unit or (unit if fits else None) or ""
        if not own and channels:
            si_unit = KINDS[kind].si_unit
            raise InputError(
                f"{file.path}: {file.title(place)}: has no unit; give --unit '{si_unit}'"
            )
        if not channels and not _fits(own, kind, bool(title.unit)):
            continue
        used = used or not title.unit
        name = title.name or file.title(place)
        found[place] = Column(place, file.title(place), name, _factor(file, place, own, kind), own)
    if not found:
        raise InputError(
            f"{file.path}: no column with a unit of {KINDS[kind]} (it has {_held(file)}); write "
            f"headers such as `az [{KINDS[kind].si_unit}]`, or name the columns with --channel and "
            f"give --unit '{KINDS[kind].si_unit}'"
        )
    if unit is not None and not used:
        raise InputError(
            f"{file.path}: --unit {unit}: every column that is used has its unit in the header; "
            "leave --unit out, or name columns without a unit with --channel"
        )
    if len({column.name for column in found.values()}) < len(found):
        found = {place: replace(c, name=f"column {place + 1}") for place, c in found.items()}
    return found


def _fits(unit: str, kind: str, stated: bool) -> bool:
    """Whether a column's unit is of the kind; a unit from the command line is to be right."""
    found = kind_of(unit) if unit else None
    return unit != "" and (not stated or (found is not None and found.name == kind))


def _place(file: CsvFile, channel: str) -> int:
    place = file.place_of(channel)
    if place is None:
        raise InputError(f'{file.path}: no column "{channel}" (it has {_held(file)})')
    return place


def _held(file: CsvFile) -> str:
    return ", ".join(written_column(file, place) for place in range(file.count))


def _factor(file: CsvFile, place: int, unit: str, kind: str) -> float:
    try:
        return factor_of(unit, KINDS[kind])
    except UnitError as error:
        raise InputError(f"{file.path}: {file.title(place)}: {error}") from None


def _refuse_dead(path: Path, names: tuple[str, ...], values: Array, kind: Kind) -> None:
    for name, column in zip(names, values.T, strict=True):
        largest = float(np.abs(column).max())
        if largest > kind.largest:
            raise InputError(
                f"{path}: {name} reaches {largest:.3g} {kind.si_unit}, beyond any sensor; is its "
                "unit right?"
            )
        if np.ptp(column) == 0.0:
            others = ", ".join(n for n in names if n != name)
            hint = f"; leave it out by naming the others ({others}) with --channel"
            raise InputError(
                f"{path}: {name} is constant ({column[0]:.6g} in SI units): nothing vibrates"
                + (hint if others else "")
            )


def _evenly(
    file: CsvFile, names: tuple[str, ...], stamps: Array, values: Array, stated: float | None
) -> Log:
    """The log on an even grid of time; jittery stamps are interpolated."""
    path = file.path
    steps = np.diff(stamps)
    backwards = np.flatnonzero(steps <= 0.0)
    if len(backwards):
        line = file.line(int(backwards[0]) + 1)
        raise InputError(f"{path}:{line}: the time does not go forward here")
    median, widest = float(np.median(steps)), int(np.argmax(steps))
    _check_rate(path, 1.0 / median, stated)
    if steps[widest] > _LONGEST_GAP * median:
        line = file.line(widest + 1)
        raise InputError(f"{path}:{line}: a gap of {steps[widest]:.3g} s; cut the log there")
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


def _check_rate(path: Path, rate: float, stated: float | None) -> None:
    if not _LOWEST_RATE <= rate <= _HIGHEST_RATE:
        raise InputError(
            f"{path}: the time stamps say {rate:.4g} Hz; is their unit right? "
            "(--time 'NAME in ms' states another)"
        )
    if stated is not None and abs(rate / stated - 1.0) > _RATE_TOLERANCE:
        raise InputError(
            f"{path}: --rate says {stated:.6g} Hz, the time stamps say {rate:.6g} Hz; leave "
            "--rate out, or correct the unit of the stamps with --time 'NAME in UNIT'"
        )
