"""Logs of a vibration: channels of one kind on an even grid of time, from CSV files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError, UnitError
from mcsim.logs.clock import Clock, mend_clock
from mcsim.logs.csv_file import CsvFile, Title, open_csv
from mcsim.logs.timing import check_rate, judge, unusable
from mcsim.units import KINDS, Kind, factor

Array = NDArray[np.float64]

_FEWEST_ROWS = 64
_TIME_NAMES = ("time", "t", "timestamp")
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


@dataclass(frozen=True)
class _Stamps:
    """The column of the time stamps, and the SI value of its unit."""

    place: int
    factor: float


def read_vibration_log(
    path: Path,
    kind: str = "acceleration",
    *,
    unit: str | None = None,
    rate: float | None = None,
    channels: tuple[str, ...] = (),
    time: str | None = None,
    cut: tuple[float | None, float | None] = (None, None),
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
    cut : (float or None, float or None)
        Start and end of what is read (s from the first row); None: from the first, to the last.

    Raises
    ------
    InputError
        No such file or column, no unit, no time, gaps, cells that are no numbers, a channel
        that is constant or beyond use, or stamps that contradict the rate.
    """
    file = open_csv(path)
    if file.titles is None:
        raise InputError(
            f"{path}: has no header; write one such as `time [s],az [{KINDS[kind].si_unit}]`"
        )
    stamps = _stamps(path, file.titles, time)
    others = {
        place: title
        for place, title in enumerate(file.titles)
        if stamps is None or place != stamps.place
    }
    chosen = _choose(path, others, kind, unit, channels)
    cells = file.numbers([*chosen, *([stamps.place] if stamps else [])])
    count = len(next(iter(cells.values())))
    if count < _FEWEST_ROWS:
        told = "1 row is" if count == 1 else f"{count} rows are"
        raise InputError(f"{path}: {told} too few; at least {_FEWEST_ROWS}")
    values = np.column_stack([cells[place] * si for place, si in chosen.items()])
    names = tuple(others[place].name for place in chosen)
    _refuse_dead(path, names, values, KINDS[kind])
    if stamps is not None:
        column = cells[stamps.place]
        # Whole nanoseconds do not fit into floats: the first one goes before.
        seconds = (column - column[0]).astype(float) * stamps.factor
        return _evenly(file, names, seconds, values, rate, cut)
    if rate is None:
        raise InputError(f"{path}: no time column (such as `time [s]`); give --rate '100 Hz'")
    start, end = (None if at is None else round(at * rate) for at in cut)
    return Log(_name(path), names, values[start:end], rate)


def _name(path: Path) -> str:
    """The file's name without its endings (``log.csv.xz`` is ``log``)."""
    return path.name.removesuffix(path.suffix).removesuffix(".csv")


def _stamps(path: Path, titles: tuple[Title, ...], given: str | None) -> _Stamps | None:
    if given is not None:
        name, _, unit = (part.strip() for part in given.partition(" in "))
        places = [place for place, title in enumerate(titles) if title.name == name]
        if not places:
            raise InputError(f'{path}: no column "{name}" for the time')
        return _Stamps(places[0], _factor(path, titles[places[0]], unit or "s", "time"))
    for place, title in enumerate(titles):
        if title.name.casefold() in _TIME_NAMES:
            return _Stamps(place, _factor(path, title, title.unit or "s", "time"))
    return None


def _choose(
    path: Path,
    titles: dict[int, Title],
    kind: str,
    unit: str | None,
    channels: tuple[str, ...],
) -> dict[int, float]:
    """Places of the columns to take, with the SI value of their unit."""
    places = {title.name: place for place, title in titles.items()}
    for channel in channels:
        if channel not in places:
            raise InputError(f'{path}: no column "{channel}" (it has {", ".join(places)})')
    found = {}
    for place in [places[channel] for channel in channels] or titles:
        title = titles[place]
        own = title.unit or unit
        if not own and channels:
            si_unit = KINDS[kind].si_unit
            raise InputError(f"{path}: {title.text}: has no unit; give --unit '{si_unit}'")
        try:
            found[place] = factor(own or "", KINDS[kind])
        except UnitError as error:
            if channels:
                raise InputError(f"{path}: {title.text}: {error}") from None
    if not found:
        raise InputError(
            f"{path}: no column with a unit of {KINDS[kind]}; write headers such as "
            f"`az [{KINDS[kind].si_unit}]`, or name the columns with --channel and --unit"
        )
    return found


def _factor(path: Path, title: Title, unit: str, kind: str) -> float:
    try:
        return factor(unit, KINDS[kind])
    except UnitError as error:
        raise InputError(f"{path}: {title.text}: {error}") from None


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
    file: CsvFile,
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
    if reason and stated is None:
        raise InputError(f"{path}: {reason}; give --rate '100 Hz', if no sample is lost")
    if reason and stated is not None:
        note = f"{reason}: the time stamps are set aside for the stated {stated:.6g} Hz"
        return Log(_name(path), names, values, stated, (*clock.notes, note))
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
    return Log(_name(path), names, values, found.rate, (*clock.notes, note))


def _refuse_holes(file: CsvFile, clock: Clock) -> None:
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
        return Log(_name(path), names, values, 1.0 / step, clock.notes)
    if stray > _WANDER:
        # The rate itself changes on the way: the usual step keeps what the faster parts hold.
        step = float(np.median(np.diff(stamps)))
        grid = np.arange(stamps[0], stamps[-1], step)
    values = np.column_stack([np.interp(grid, stamps, column) for column in values.T])
    note = f"time stamps stray by up to {stray * step:.3g} s; interpolated to {1.0 / step:.6g} Hz"
    return Log(_name(path), names, values, 1.0 / step, (*clock.notes, note))
