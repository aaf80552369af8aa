"""The clock behind the time stamps: rows out of order, set back, wrapped around, or set forward.

Nothing is refused here; what was found is mended and told.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.logs.counting import usual_interval
from mcsim.logs.model import Array

Whole = NDArray[np.int64]

#: Rows that a running median looks at: a few late or stale stamps are no step of the clock.
_NEAR = 5
#: Rows before and after a jump whose level is compared.
_LEVEL = 25
#: Jumps (intervals) that are looked at, back and forward, the part of them that must last, and how
#: far they stand out of the scatter of the others: of single intervals, of the level.
_BACK, _FORWARD, _LASTS, _OF_STEPS, _OF_LEVEL = 0.5, 4.0, 0.5, 4.0, 8.0
#: The longest burst (rows) after which stamps have caught up.
_BURST = 20_000
#: Periods after which clocks begin anew (s), and what they are.
_PERIODS = {
    60.0: "a minute",
    3600.0: "an hour",
    43_200.0: "twelve hours",
    86_400.0: "a day",
    604_800.0: "a week",
    2.0**16 * 1e-6: "2^16 µs",
    2.0**24 * 1e-6: "2^24 µs",
    2.0**31 * 1e-6: "2^31 µs",
    2.0**32 * 1e-6: "2^32 µs",
    2.0**16 * 1e-3: "2^16 ms",
    2.0**24 * 1e-3: "2^24 ms",
    2.0**31 * 1e-3: "2^31 ms",
    2.0**32 * 1e-3: "2^32 ms",
    2.0**31 * 1e-9: "2^31 ns",
    2.0**32 * 1e-9: "2^32 ns",
    1.0: "a second",
    1e3: "1000 s",
}
#: A period fits when it leaves no more samples lost than this part of it, or this many.
_LOST_IN_WRAP, _EARLY = 0.002, 0.5
#: Shorter periods (intervals) fit any step; below the second, stamps may jitter across the end.
_SHORTEST, _SHORT = 20.0, 1000.0


@dataclass(frozen=True)
class Clock:
    """Time stamps of a clock that never steps.

    ``rows`` are rows of the file in the order of their samples, those left out that say the same
    twice; ``stamps`` (as many) in s from the first; ``jumps`` are places (row before which) and
    sizes (samples) of long gaps; ``interval`` is the usual one (s), 0 where there is none;
    ``steps`` how often the clock was mended; ``notes`` say what was found.
    """

    rows: Whole
    stamps: Array
    interval: float
    jumps: tuple[tuple[int, int], ...]
    steps: int
    repeated: int
    notes: tuple[str, ...]

    def between(self, start: float | None, end: float | None) -> Clock:
        """What lies between two times (s from the first row); empty if nothing does."""
        if start is None and end is None:
            return self
        early = 0.5 * self.interval
        # Counted, not looked up: a late or stale stamp moves no edge.
        first = int(np.count_nonzero(self.stamps < (start or 0.0) - early))
        last = len(self.stamps)
        if end is not None:
            last = int(np.count_nonzero(self.stamps < end - early))
        last = max(first, last)
        stamps = self.stamps[first:last]
        jumps = tuple((place - first, size) for place, size in self.jumps if first < place < last)
        return replace(
            self,
            rows=self.rows[first:last],
            stamps=stamps - stamps[:1],
            interval=usual_interval(stamps) if len(stamps) > 1 else 0.0,
            jumps=jumps,
        )


def mend_clock(stamps: Array, same: NDArray[np.bool_] | None = None) -> Clock:
    """Look at the clock behind time stamps (n,) in s.

    ``same`` (n,) tells rows whose values are all those of the row before.
    """
    n = len(stamps)
    rows = np.arange(n)
    notes: list[str] = []
    repeated = _repeated(stamps, same)
    if len(repeated):
        rows = np.delete(rows, repeated)
        notes.append(
            f"{len(repeated)} rows that repeat the time stamp and the values of the one before "
            "were left out"
        )
    times = stamps[rows] - stamps[rows[0]]
    order = _order(times)
    if order is not None:
        moved = int(np.count_nonzero(order != np.arange(len(order))))
        notes.append(f"{moved} rows were out of order: sorted by their time stamps")
        rows, times = rows[order], times[order] - times[order[0]]
    interval = usual_interval(times)
    jumps: tuple[tuple[int, int], ...] = ()
    steps = 0
    if interval > 0.0:
        times, steps, told = _without_steps(times, interval)
        notes += told
        interval = usual_interval(times) or interval
        jumps = _long_gaps(times, interval)
    return Clock(rows, times, interval, jumps, steps, len(repeated), tuple(notes))


def _repeated(stamps: Array, same: NDArray[np.bool_] | None) -> Whole:
    """Rows that repeat stamp and values of the one before, where values do not repeat by chance."""
    if same is None:
        return np.array([], np.int64)
    again = np.concatenate([[False], np.diff(stamps) == 0.0])
    both = again & same
    by_chance = np.mean(same[1:][~again[1:]]) if not np.all(again[1:]) else 1.0
    stale = np.count_nonzero(again & ~same)
    usual = np.count_nonzero(both) > 9 * stale or by_chance < 0.01
    return np.flatnonzero(both) if usual and by_chance < 0.5 else np.array([], np.int64)


def _order(times: Array) -> Whole | None:
    """The order of the stamps, if the rows are out of order and their stamps sound."""
    steps = np.diff(times)
    if not np.any(steps < 0.0):
        return None
    order = np.argsort(times, kind="stable")
    found = np.diff(times[order])
    middle = float(np.median(found))
    if middle <= 0.0:
        return None
    # As many rows as ran backwards must find a regular place, and no new gap may open.
    if known_period(-float(steps.min()), middle) is not None:
        return None
    moved = np.flatnonzero(order[1:] != order[:-1] + 1)
    beside = np.unique(np.clip(moved[:, None] + np.arange(-1, 2), 0, len(found) - 1))
    regular = np.abs(found[beside] / middle - 1.0) < 0.25
    longest = max(float(steps.max(initial=0.0)), 1.75 * middle)
    if np.mean(regular) < 0.9 or found.max() > longest or found.min() < 0.25 * middle:
        return None
    return order


def _level(excess: Array) -> Array:
    """Running median over a few rows."""
    if len(excess) < _NEAR:
        return excess
    half = _NEAR // 2
    padded = np.concatenate([excess[:1].repeat(half), excess, excess[-1:].repeat(half)])
    windows = np.lib.stride_tricks.sliding_window_view(padded, _NEAR)
    level: Array = np.median(windows, axis=1)
    # At the ends the first and the last rows speak for themselves.
    level[:half], level[-half:] = np.median(excess[:_NEAR]), np.median(excess[-_NEAR:])
    return level


def _limit(jumps: Array, least: float, times: float) -> float:
    spread = 1.4826 * float(np.median(np.abs(jumps - np.median(jumps))))
    return max(least, times * spread)


def _without_steps(times: Array, interval: float) -> tuple[Array, int, list[str]]:
    """Stamps whose steps back are mended; how many there were, and the words."""
    excess = times / interval - np.arange(len(times))
    jumps = np.diff(excess)
    limit = _limit(jumps, _BACK, _OF_STEPS)
    # Late or stale stamps alone never run backwards.
    places = np.flatnonzero((jumps < -limit) & (np.diff(times) < 0.0)) + 1
    found: list[tuple[int, float]] = []
    for n, place in enumerate(places):
        start = int(places[n - 1]) if n else 0
        end = int(places[n + 1]) if n + 1 < len(places) else len(excess)
        end = int(place) + _LEVEL if end - place < _NEAR else end
        start = 0 if place - start < _NEAR else start
        before = np.median(excess[max(start, place - _LEVEL) : place])
        after = np.median(excess[place : min(end, place + _LEVEL)])
        shift = float(after - before)
        if shift < -max(limit, -_LASTS * float(jumps[place - 1])):
            found.append((int(place), shift))
    if not found:
        return times, 0, []
    return _mended(times, interval, found)


def _mended(
    times: Array, interval: float, found: list[tuple[int, float]]
) -> tuple[Array, int, list[str]]:
    corrected = times.copy()
    short = _short_period(found, interval)
    if short is not None:
        deviations = np.diff(times) - interval
        steps = np.mod(deviations + 0.5 * short, short) - 0.5 * short + interval
        corrected = times[0] + np.concatenate([[0.0], np.cumsum(steps)])
        note = f"the clock begins anew every {short:.9g} s ({_PERIODS[short]}): continued"
        return corrected, len(found), [note]
    wraps: dict[float, list[int]] = {}
    back: list[tuple[int, float]] = []
    for place, shift in found:
        period = known_period(-shift * interval, interval)
        if period is not None:
            corrected[place:] += period
            wraps.setdefault(period, []).append(place)
            continue
        corrected[place:] -= shift * interval
        back.append((place, -shift * interval))
    notes = []
    for period, places in wraps.items():
        after = ", ".join(f"{times[place - 1] - times[0]:.6g}" for place in places[:3])
        more = " …" if len(places) > 3 else ""
        notes.append(
            f"the clock begins anew {len(places)} time{'s' * (len(places) > 1)}, every "
            f"{period:.9g} s ({_PERIODS[period]}), first at {after}{more} s: continued"
        )
    if back:
        told = ", ".join(f"by {size:.4g} s after row {place}" for place, size in back[:3])
        more = f" and {len(back) - 3} times more" if len(back) > 3 else ""
        notes.append(
            f"the clock was set back {told}{more}: the stamps after it are moved on, as if no "
            "sample were lost there"
        )
    return corrected, len(found), notes


def known_period(back: float, interval: float) -> float | None:
    """The period (s) of a clock that begins anew, if going back by so much is one."""
    for period in _PERIODS:
        samples = period / interval
        lost = samples - back / interval
        if samples > _SHORTEST and -_EARLY <= lost <= max(_EARLY, _LOST_IN_WRAP * samples):
            return period
    return None


def _short_period(found: list[tuple[int, float]], interval: float) -> float | None:
    """The one period of many, if it is so short that stamps jitter across its end."""
    periods = [known_period(-shift * interval, interval) for _, shift in found]
    period = max(set(periods), key=periods.count)
    if period is None or period > _SHORT * interval or periods.count(period) < 2:
        return None
    return period


def _long_gaps(times: Array, interval: float) -> tuple[tuple[int, int], ...]:
    """Places and sizes of long gaps; late stamps that catch up again are none."""
    excess = times / interval - np.arange(len(times))
    jumps = np.diff(excess)
    level = _level(excess)
    limit = _limit(np.diff(level), _FORWARD, _OF_LEVEL)
    gaps = []
    ends = np.flatnonzero(jumps > limit) + 1
    for n, place in enumerate(ends):
        size = float(jumps[place - 1])
        last = int(min(len(excess), place + min(size, _BURST) + _LEVEL))
        before = float(np.median(excess[max(0, place - _LEVEL) : place]))
        start = int(ends[n - 1]) if n else 0
        if place - start >= _NEAR:
            before = float(np.median(excess[max(start, place - _LEVEL) : place]))
        stays = float(level[place:last].min(initial=np.inf)) - before
        if stays > _LASTS * size:
            gaps.append((int(place), max(int(np.floor(min(stays, size) + 0.25)), 1)))
    return tuple(gaps)
