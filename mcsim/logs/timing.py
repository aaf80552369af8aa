"""One judge of time stamps: rate, order, gaps, jitter; and how samples are made equally spaced.

What a sensor that samples evenly has lost is told by counting (``mcsim.logs.counting``), after
steps of the clock are mended (``mcsim.logs.clock``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.logs.clock import Clock
from mcsim.logs.counting import count
from mcsim.logs.model import Array, Timing

_FEWEST = 3
#: Gaps are bridged when they miss fewer samples than this part of the log.
_BRIDGED = 1e-3
#: The longest unbroken stretch must be this part of the log.
_UNBROKEN = 0.5
#: Fewer distinct time stamps know no rate; a short log has them all.
_FEWEST_STAMPS = 20
#: A clock that steps more often than once in so many rows is none.
_ROWS_PER_STEP = 20
#: A stated rate may differ from the stamps by this part.
_RATE_TOLERANCE = 0.02
#: Rates beyond are those of a wrong unit of time (Hz), those in between may be.
LOWEST_RATE, HIGHEST_RATE = 0.01, 90_000.0
_LOWEST_USUAL, _HIGHEST_USUAL = 1.5, 20_000.0
#: Jitter above this part of the interval is worth a note.
_JITTER = 0.1
#: A stretch worth cutting out has so many seconds and rows.
_WORTH_SECONDS, _WORTH_ROWS = 60.0, 1000


@dataclass(frozen=True)
class Judgement:
    """What the time stamps of an evenly sampling sensor say.

    ``index`` (n,) is the number of each kept row's sample, ``rate`` in Hz; ``gaps`` (k, 2) are
    rows before which samples are missing, and how many; ``jitter`` is the standard deviation of
    the intervals in intervals; ``repeated`` stamps repeat the one before with new values.
    """

    clock: Clock
    rate: float
    index: NDArray[np.int64]
    gaps: NDArray[np.int64]
    jitter: float
    repeated: int

    @property
    def missing(self) -> int:
        """Samples missing."""
        return int(self.gaps[:, 1].sum())

    @property
    def notes(self) -> tuple[str, ...]:
        """What was found and done, but for gaps."""
        notes = list(self.clock.notes)
        n = len(self.index)
        if self.repeated:
            notes.append(
                f"{self.repeated} of {n} time stamps repeat the one before (stale stamps, bursts "
                "or a coarse clock): their samples are kept"
            )
        if self.jitter > _JITTER:
            lost = f"{self.missing} missing" if self.missing else "none missing"
            notes.append(
                f"the time stamps scatter by {self.jitter:.0%} of the interval; by count ({n} "
                f"samples in {(self.index[-1] + 1) / self.rate:.6g} s, {lost}) the samples are "
                "equally spaced, as the sensor's own clock makes them"
            )
        return tuple(notes)


@dataclass(frozen=True)
class Spacing:
    """How to make samples equally spaced.

    ``rows`` are kept ones; when ``positions`` is not None, the kept rows stand at these
    multiples of the interval, and what lies between is interpolated.
    """

    timing: Timing
    rows: NDArray[np.int64]
    positions: NDArray[np.int64] | None = None

    def apply(self, samples: Array) -> Array:
        """Equally spaced samples of a channel (all rows of the file)."""
        kept = samples[self.rows]
        if self.positions is None:
            return kept
        every = np.arange(self.positions[-1] + 1)
        return np.interp(every, self.positions, kept)


def unusable(clock: Clock) -> str:
    """Why the stamps know no rate at all; empty where they do."""
    n = len(clock.stamps)
    if n < _FEWEST:
        return ""
    distinct = len(np.unique(clock.stamps))
    if distinct == 1:
        return f"all {n} time stamps are the same"
    if clock.interval <= 0.0:
        return "the time does not go forward"
    if distinct < min(_FEWEST_STAMPS, n // 2):
        return f"{n} rows have {distinct} different time stamps: the clock is too coarse"
    if clock.steps * _ROWS_PER_STEP > n:
        return f"the time steps back {clock.steps} times in {n} rows"
    return ""


def judge(clock: Clock) -> Judgement:
    """Count the samples of a clock that ``unusable`` says nothing against."""
    lost = np.zeros(len(clock.stamps), np.int64)
    for place, size in clock.jumps:
        lost[place:] += size
    counted = count(clock.stamps, clock.interval, lost)
    steps = np.diff(counted.index)
    gaps = np.flatnonzero(steps > 1)
    intervals = np.diff(clock.stamps) / counted.interval - steps
    return Judgement(
        clock,
        1.0 / counted.interval,
        counted.index,
        np.column_stack([gaps + 1, steps[gaps] - 1]),
        float(intervals.std()),
        int(np.count_nonzero(np.diff(clock.stamps) == 0.0)),
    )


def unstamped(rate: float, count: int, notes: tuple[str, ...] = ()) -> Spacing:
    """Spacing of samples without time stamps, or with stamps that are set aside."""
    return Spacing(Timing(rate, stamped=False, notes=notes), np.arange(count))


def check_stamps(clock: Clock, stated_rate: float | None, where: str) -> Spacing:
    """How samples with these time stamps are made equally spaced.

    Raises
    ------
    InputError
        Stamps know no rate, miss too much, or contradict the stated rate.
    """
    n = len(clock.rows)
    if n < _FEWEST:
        raise InputError(
            f"{where}: {n} row{'s' * (n != 1)}: too few for a rate; a static "
            "log of minutes, better hours, is needed"
        )
    reason = unusable(clock)
    if reason and stated_rate is not None:
        return _set_aside(clock, reason, stated_rate)
    if reason:
        raise InputError(f"{where}: {reason}; give the sampling rate, --rate 100, if none is lost")
    found = judge(clock)
    if stated_rate is not None and (reason := no_times(found.rate, stated_rate)):
        return _set_aside(clock, reason, stated_rate)
    check_rate(found.rate, stated_rate, where)
    timing = Timing(
        found.rate,
        True,
        clock.repeated,
        found.missing,
        found.jitter,
        found.notes,
        _doubt(found.rate, stated_rate),
    )
    return _mend(timing, found, stated_rate, where)


def _set_aside(clock: Clock, reason: str, rate: float) -> Spacing:
    note = (
        f"{reason}: the time stamps are set aside, and the {len(clock.rows)} samples taken as "
        f"equally spaced at the stated {rate:.6g} Hz, none missing"
    )
    return replace(unstamped(rate, 0, (note,)), rows=clock.rows)


def _mend(timing: Timing, found: Judgement, stated: float | None, where: str) -> Spacing:
    """Bridge a few missing samples; else keep the longest stretch without a gap."""
    positions, rows, notes = None, found.clock.rows, list(timing.notes)
    if timing.missing:
        share = timing.missing / len(rows)
        many = len(found.gaps)
        told = (
            f"{many} gap{'s' * (many > 1)} in the time stamps miss{'es' * (many == 1)} "
            f"{timing.missing} sample{'s' * (timing.missing > 1)}"
        )
        if share < _BRIDGED:
            positions = found.index - found.index[0]
            notes.append(f"{told} ({share:.2g} of all): bridged")
        else:
            edges = np.concatenate([[0], found.gaps[:, 0], [len(rows)]])
            longest = int(np.argmax(np.diff(edges)))
            first, last = int(edges[longest]), int(edges[longest + 1])
            length = (last - first) / timing.rate
            start = float(found.clock.stamps[first])
            if last - first < _UNBROKEN * len(rows):
                if stated is not None:
                    return _set_aside(found.clock, told, stated)
                raise InputError(
                    f"{where}: {told}; the longest stretch without a gap is {length:.6g} s, "
                    f"less than half of the log. {_way_out(found, first, last)}"
                )
            notes.append(
                f"{told}; only the longest stretch without one is used, "
                f"{length:.6g} s from {start:.6g} s on"
            )
            rows = rows[first:last]
    doubt = [timing.doubt] if timing.doubt else []
    return Spacing(replace(timing, notes=(*notes, *doubt)), rows, positions)


def _way_out(found: Judgement, first: int, last: int) -> str:
    stamps, step = found.clock.stamps, 1.0 / found.rate
    digits = max(0, int(np.ceil(-np.log10(step))) + 1)
    start, end = stamps[first], stamps[last - 1] + step
    rate = (
        "if the stamps are wrong (a clock set forward) and no sample is lost, give --rate "
        f"{found.rate:.6g}"
    )
    if end - start > _WORTH_SECONDS and last - first > _WORTH_ROWS:
        return f"Cut it out: --start {start:.{digits}f} --end {end:.{digits}f}; {rate}"
    return f"Log it anew; {rate}"


def no_times(
    rate: float, stated: float, limits: tuple[float, float] = (LOWEST_RATE, HIGHEST_RATE)
) -> str:
    """Why stamps beside a stated rate are no times, such as counters; empty where they may be."""
    if limits[0] <= rate <= limits[1] or _other_unit(rate / stated, ""):
        return ""
    return f"the time stamps say {rate:.4g} Hz, which no sensor has"


def check_rate(
    rate: float,
    stated: float | None,
    where: str,
    way: str = "--units time=…",
    limits: tuple[float, float] = (LOWEST_RATE, HIGHEST_RATE),
) -> None:
    """Refuse a rate that contradicts the stated one, or that only a wrong unit of time gives.

    Raises
    ------
    InputError
        Says by which option (``way``) the unit is stated.
    """
    if stated is not None and abs(rate / stated - 1.0) > _RATE_TOLERANCE:
        raise InputError(
            f"{where}: --rate says {stated:.6g} Hz, the time stamps say {rate:.6g} Hz"
            + (_other_unit(rate / stated, way) or "; leave --rate out, or correct it")
        )
    if not limits[0] <= rate <= limits[1]:
        raise InputError(
            f"{where}: the time stamps say {rate:.6g} Hz, which no sensor has; is their "
            f"unit right? ({way} with s, ms, µs or ns states another than the header; --rate sets "
            "stamps that are no times aside)"
        )


def _other_unit(ratio: float, way: str) -> str:
    """A hint where the stamps say a rate that is a power of a thousand times the true one."""
    for power in (1000.0, 1e6, 1e9):
        for times, size in ((ratio / power, "larger"), (ratio * power, "smaller")):
            if abs(times - 1.0) < _RATE_TOLERANCE:
                return (
                    f"; they agree if the unit of time is {power:.0f} times {size}: state it by "
                    f"{way}"
                )
    return ""


def _doubt(rate: float, stated: float | None) -> str:
    """A sentence about a rate that is possible, but hardly an inertial sensor's."""
    if stated is not None or _LOWEST_USUAL <= rate <= _HIGHEST_USUAL:
        return ""
    power = "1000 times smaller" if rate < _LOWEST_USUAL else "1000 times larger"
    return (
        f"the time stamps say {rate:.4g} Hz, an unusual rate: if their unit is {power} than the "
        "header says, state it by --units time=…; if not, confirm the rate by --rate"
    )
