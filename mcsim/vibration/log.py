"""Logs of a vibration: channels of one kind on an even grid of time, from files of any format."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError, UnitError
from mcsim.logs.clock import Clock, mend_clock
from mcsim.logs.column_file import ColumnFile, scaled, since_first
from mcsim.logs.columns import Column, said, time_column, written_column
from mcsim.logs.formats import open_log
from mcsim.logs.model import ReadOptions
from mcsim.logs.names import is_acceleration
from mcsim.logs.timing import check_rate, judge, no_times, unusable
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
#: Shorter steps (share of the usual one) come in bursts: their stamps are not the samples' times.
_BURST = 0.1
#: Rates beyond are those of a wrong unit of time (Hz).
_RATES = 0.05, 1e6


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
    cut: tuple[float | None, float | None] = (None, None),
    topic: str | None = None,
) -> Log:
    """The channels of ``kind`` in a log whose columns are titled ``time [s],az [m/s²]``.

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
    cut : (float or None, float or None)
        Start and end of what is read (s from the first row); None: from the first, to the last.
    topic : str, optional
        Topic of the IMU in a bag.

    Raises
    ------
    InputError
        No such file or column, no unit, no time, gaps, cells that are no numbers, a channel
        that is constant or beyond use, or stamps that contradict the rate.
    """
    file = open_log(path, ReadOptions(topic=topic))
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
        log = _evenly(file, names, seconds, values, rate, cut)
    elif rate is None:
        raise InputError(
            f"{path}: no time column (such as `time [s]`); name one with --time 'NAME in UNIT', or "
            "give --rate '100 Hz'"
        )
    else:
        start, end = (None if at is None else round(at * rate) for at in cut)
        log = Log(name_of_log(path), names, values[start:end], rate)
    return replace(log, name=name_of_log(path), remarks=(said(file, columns), *file.notes))


def name_of_log(path: Path) -> str:
    """The file's name without its endings (``log.csv.xz`` is ``log``)."""
    return path.name.removesuffix(path.suffix).removesuffix(".csv")


def _stamps(file: ColumnFile, given: str | None) -> Column | None:
    """The column of the time stamps; its unit is stated, never taken for granted."""
    stated = ""
    if given is not None:
        name, _, stated = (part.strip() for part in given.partition(" in "))
        place = file.place_of(name)
        if place is None:
            raise InputError(f'{file.path}: no column "{name}" for the time (it has {_held(file)})')
    elif file.titles is None or (place := time_column(file)) is None:
        return None
    unit, title = stated or file.unit(place), file.title(place)
    if stated and place in file.layout.dates:
        raise InputError(
            f"{file.path}: --time {given}: the column holds dates and times, in no unit; give "
            f"--time '{written_column(file, place)}'"
        )
    if not unit:
        raise InputError(
            f'{file.path}: the time column "{title}" has no unit; write "{title} [s]" into the '
            f"header, or give --time '{written_column(file, place)} in ms' (or s, µs, ns)"
        )
    return Column(place, title, "time", _factor(file, place, unit, "time"), unit)


def _choose(
    file: ColumnFile,
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


def _place(file: ColumnFile, channel: str) -> int:
    place = file.place_of(channel)
    if place is None:
        raise InputError(f'{file.path}: no column "{channel}" (it has {_held(file)})')
    return place


def _held(file: ColumnFile) -> str:
    return ", ".join(written_column(file, place) for place in range(file.count))


def _factor(file: ColumnFile, place: int, unit: str, kind: str) -> float:
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
    file: ColumnFile,
    names: tuple[str, ...],
    stamps: Array,
    values: Array,
    stated: float | None,
    cut: tuple[float | None, float | None] = (None, None),
) -> Log:
    """The log on an even grid of time.

    Stamps that go forward steadily are taken as the times of the samples, which are
    interpolated; those that repeat or come in bursts are not: the samples are counted.
    """
    path = file.path
    same = np.concatenate([[False], np.all(np.diff(values, axis=0) == 0.0, axis=1)])
    clock = mend_clock(stamps, same).between(*cut)
    if len(clock.rows) < _FEWEST_ROWS:
        raise InputError(f"{path}: --start and --end leave {len(clock.rows)} rows, too few")
    values = values[clock.rows]
    reason = unusable(clock)
    if stated is not None and not reason:
        reason = no_times(1.0 / clock.interval, stated, _RATES)
    if reason and stated is None:
        raise InputError(f"{path}: {reason}; give --rate '100 Hz', if no sample is lost")
    if reason and stated is not None:
        note = f"{reason}: the time stamps are set aside for the stated {stated:.6g} Hz"
        return Log(name_of_log(path), names, values, stated, (*clock.notes, note))
    check_rate(1.0 / clock.interval, stated, str(path), "--time 'NAME in UNIT'", _RATES)
    _refuse_holes(file, clock)
    steps = np.diff(clock.stamps)
    if steps.min() > _BURST * clock.interval:
        return _interpolated(path, names, clock, values)
    found = judge(clock)
    every = np.arange(found.index[-1] + 1)
    values = np.column_stack([np.interp(every, found.index, column) for column in values.T])
    missing = f"{found.missing} missing samples are bridged" if found.missing else "none is missing"
    note = (
        f"the time stamps repeat or come in bursts; by count of the {len(found.index)} samples "
        f"they are equally spaced at {found.rate:.6g} Hz, {missing}"
    )
    return Log(name_of_log(path), names, values, found.rate, (*clock.notes, note))


def _refuse_holes(file: ColumnFile, clock: Clock) -> None:
    holes = [(place, size) for place, size in clock.jumps if size >= _LONGEST_GAP]
    if not holes:
        return
    edges = np.array([0, *(place for place, _ in holes), len(clock.rows)])
    longest = int(np.argmax(np.diff(edges)))
    first, last = clock.stamps[edges[longest]], clock.stamps[edges[longest + 1] - 1]
    row = int(clock.rows[holes[0][0]])
    gap = clock.stamps[holes[0][0]] - clock.stamps[holes[0][0] - 1]
    step = clock.interval
    digits = max(0, int(np.ceil(-np.log10(step))) + 1)
    raise InputError(
        f"{file.path}:{file.line(row)}: a gap of {gap:.3g} s; cut the log: "
        f"--start {first:.{digits}f} --end {last + step:.{digits}f} is its longest stretch"
    )


def _interpolated(path: Path, names: tuple[str, ...], clock: Clock, values: Array) -> Log:
    """Samples at the times of their stamps, interpolated unless these are even."""
    stamps = clock.stamps
    step = float((stamps[-1] - stamps[0]) / (len(stamps) - 1))
    grid = stamps[0] + step * np.arange(len(stamps))
    stray = float(np.abs(stamps - grid).max()) / step
    if stray <= _JITTER:
        return Log(name_of_log(path), names, values, 1.0 / step, clock.notes)
    if stray > _WANDER:
        # The rate itself changes on the way: the usual step keeps what the faster parts hold.
        step = float(np.median(np.diff(stamps)))
        grid = np.arange(stamps[0], stamps[-1], step)
    values = np.column_stack([np.interp(grid, stamps, column) for column in values.T])
    note = f"time stamps stray by up to {stray * step:.3g} s; interpolated to {1.0 / step:.6g} Hz"
    return Log(name_of_log(path), names, values, 1.0 / step, (*clock.notes, note))
