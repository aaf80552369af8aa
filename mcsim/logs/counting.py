"""Lost samples, told from jitter by counting: samples against the time that has gone by.

A single interval between stamps says little: a late stamp makes one long and the next one short.
A lost sample is lost for good, so that all later stamps stand one interval further on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.logs.model import Array

Whole = NDArray[np.int64]

#: Lags (rows) over which the interval is looked at: longer than bursts, shorter than drift.
_LAGS = (16, 64, 256, 1024, 4096)
#: Cost of a place of loss (nats) where losses are rare: false ones are as rare as exp(-12).
_PENALTY = 12.0
#: Rows ahead within which late stamps have caught up, rows that show it, and samples that late
#: stamps must be behind.
_CAUGHT_UP, _SHOWS, _LATE = 2048, 25, 3.0
#: Fewer intervals than this part that are no pause: samples are delivered in bursts.
_PAUSES, _PAUSE = 0.6, 0.3
#: The phase follows a clock's drift by this part of each deviation, less where stamps scatter.
_GAIN = 1.0 / 48.0
#: Scatter (intervals) below which stamps need no closer look, and floor of any estimate.
_CALM, _LEAST_SCATTER = 0.1, 0.05
#: Steps, limit and most trials of the part by which frequent losses may have raised the interval.
_RAISED, _MOST_RAISED, _TRIALS = 0.004, 0.2, 64
#: Rows and number of the windows in which that is tried.
_WINDOW, _WINDOWS = 2048, 2
#: Places of loss whose spacings (rows) agree so well, so often, and are so short, are the clock's
#: own ticks.
_REGULAR, _ALIKE, _FREQUENT = 1.0, 0.35, 50.0


@dataclass(frozen=True)
class Count:
    """The samples of a sensor, counted.

    ``interval`` in s; ``index`` (n,) is the number of each row's sample from 0, lost ones
    counted too; ``scatter`` the standard deviation of the stamps about it, in intervals.
    """

    interval: float
    index: Whole
    scatter: float

    @property
    def missing(self) -> int:
        """Samples lost between the first row and the last."""
        return int(self.index[-1]) + 1 - len(self.index)


def usual_interval(stamps: Array) -> float:
    """The interval (s) between samples: the median of slopes, over the lag that scatters least.

    Gaps, bursts, late stamps and steps of the clock do not move it as long as they are rare.
    """
    best, interval = np.inf, 0.0
    n = len(stamps)
    if n < 2:
        return interval
    for lag in _LAGS:
        if lag > max(n // 4, 1) and interval > 0.0:
            break
        lag = min(lag, n - 1)
        slopes = (stamps[lag:] - stamps[:-lag])[:: max(1, lag // 8)] / lag
        least, low, middle, high, most = np.quantile(slopes, (0.02, 0.25, 0.5, 0.75, 0.98))
        # Lags within a burst see little time go by, but for the few that leave it.
        spread = high - low + 0.1 * (most - least)
        if middle > 0.0 and spread / middle < best:
            best, interval = spread / middle, float(middle)
    return interval


def count(stamps: Array, interval: float, lost: Whole | None = None) -> Count:
    """Count the samples of a sensor that samples evenly.

    Parameters
    ----------
    stamps : float64 (n,)
        Time stamps in s of a clock that does not step back.
    interval : float
        About the interval between samples (s).
    lost : int64 (n,), optional
        Samples known to be lost before each row.
    """
    rows = np.arange(len(stamps))
    known = np.zeros(len(stamps), np.int64) if lost is None else lost
    steps = np.diff(stamps) / interval - np.diff(known)
    calm = np.all(np.abs(steps - 1.0) < 0.5) and float(steps.std()) < _CALM
    index = rows + known
    told = rows
    if not calm:
        told = _telling(stamps, interval, index)
        index = _settle(stamps, index, told)
    interval, residuals = _line(index[told], stamps[told])
    return Count(interval, index, _scatter(residuals / interval))


def _settle(stamps: Array, index: Whole, told: Whole) -> Whole:
    """Numbers of the samples that agree with their interval, by the rows that tell the time."""
    numbers, times = index[told], stamps[told]
    interval, raised = _true_interval(times, numbers, len(told) / len(stamps))
    lost = np.zeros(len(told), np.int64)
    for _ in range(3):
        excess = _caught_up(times / interval - numbers)
        _, found, _ = _path(excess, _penalty(raised))
        if np.array_equal(found - found[0], lost):
            break
        lost = found - found[0]
        interval, _ = _line(numbers + lost, times)
    # Rows between two telling ones belong to the one before.
    before = np.searchsorted(told, np.arange(len(stamps)), side="right") - 1
    settled: Whole = index + lost[np.maximum(before, 0)]
    return settled


def _caught_up(excess: Array) -> Array:
    """Stamps whose delay (a stalled host) is made up for later, as if they had not been late.

    Lost samples never come back: what stands further out than rows ahead is late.
    """
    from scipy.ndimage import median_filter, minimum_filter1d

    if len(excess) < 2 * _SHOWS:
        return excess
    level = median_filter(excess, _SHOWS, mode="nearest")
    ahead = minimum_filter1d(level, _CAUGHT_UP, mode="nearest", origin=-(_CAUGHT_UP // 2))
    late = _LATE + 4.0 * _scatter(excess - level)
    kept: Array = np.where(excess > ahead + late, ahead, excess)
    return kept


def _telling(stamps: Array, interval: float, index: Whole) -> Whole:
    """Rows whose stamps tell the time: of each burst the first or the last, else all.

    Samples wait for a burst, or for a tick of a coarse clock; one at an end waits least.
    """
    n = len(stamps)
    pauses = np.flatnonzero(np.diff(stamps) > _PAUSE * interval)
    if len(pauses) >= _PAUSES * n or len(pauses) < 2:
        return np.arange(n)
    ends = pauses, pauses + 1
    first, last = (
        _scatter(excess - _trend(excess))
        for excess in (stamps[rows] / interval - index[rows] for rows in ends)
    )
    return ends[0] if first <= last else ends[1]


def _penalty(raised: float) -> float:
    """Cost of a place of loss (nats), where losses raise the interval by this part."""
    return _PENALTY if raised == 0.0 else 1.0 - float(np.log(raised))


def _path(excess: Array, penalty: float) -> tuple[float, Whole, Array]:
    """Score (nats), losses and deviations of the best path, its scatter fitted to it."""
    from mcsim.kernels.lost_samples import follow

    lost = np.zeros(len(excess), np.int64)
    residuals = np.zeros(len(excess))
    scatter = max(_scatter(excess - _trend(excess)), _LEAST_SCATTER)
    score = 0.0
    for _ in range(3):
        gain = min(_GAIN, 1.0 / (12.0 * _PENALTY * scatter**2))
        cost = follow(excess, scatter, gain, penalty, lost, residuals)
        score = cost + len(excess) * float(np.log(scatter))
        found = max(_scatter(residuals), _LEAST_SCATTER)
        if abs(found / scatter - 1.0) < 0.05:
            break
        scatter = found
    return score, lost, residuals


def _true_interval(stamps: Array, numbers: Whole, part: float) -> tuple[float, float]:
    """The interval (s), and the part by which frequent losses had raised it (0: there are none).

    ``part`` of all rows is given.
    """
    tried = _RAISED * part * np.arange(min(_TRIALS, int(_MOST_RAISED / (_RAISED * part))))
    scores = np.full(len(tried), _PENALTY)
    scores[0] = 0.0
    n = len(stamps)
    starts = np.unique(np.linspace(0, max(n - _WINDOW, 0), _WINDOWS).astype(int))
    regular = np.zeros(len(tried))
    parts = []
    for start in starts:
        index, times = numbers[start : start + _WINDOW], stamps[start : start + _WINDOW]
        slope = _middle_slope(index, times)
        # In intervals of this window, the late stamps caught up.
        parts.append((slope, index, _caught_up(times / slope - index) + index))
    for _, index, times in parts:
        for k, raised in enumerate(tried):
            score, lost, _ = _path(times / (1.0 - raised) - index, _penalty(raised))
            scores[k] += score
            regular[k] += _is_regular(lost)
    scores[regular > 0.5 * len(parts)] = np.inf
    best = float(tried[int(np.argmin(scores))])
    intervals = []
    for slope, index, times in parts:
        _, lost, _ = _path(times / (1.0 - best) - index, _penalty(best))
        intervals.append(slope * _line(index + lost, times)[0])
    return float(np.median(intervals)), best


def _middle_slope(index: Whole, times: Array) -> float:
    """Median slope (s per sample) over half of the rows."""
    half = max(len(index) // 2, 1)
    return float(np.median((times[half:] - times[:-half]) / (index[half:] - index[:-half])))


def _is_regular(lost: Whole) -> bool:
    """Whether single losses come at regular rows, as a clock's own steps do."""
    jumps = np.diff(lost)
    places = np.flatnonzero(jumps)
    if len(places) < 5:
        return False
    spacings = np.diff(places)
    usual = np.median(spacings)
    return bool(np.mean(np.abs(spacings - usual) <= _REGULAR) > _ALIKE and usual < _FREQUENT)


def _trend(excess: Array) -> Array:
    """A straight line through medians of the first and the last half."""
    rows = np.arange(len(excess), dtype=float)
    half = max(len(excess) // 2, 1)
    first, last = np.median(excess[:half]), np.median(excess[-half:])
    slope = (last - first) / max(len(excess) - half, 1)
    line: Array = first + slope * (rows - 0.5 * (half - 1))
    return line


def _line(index: Whole, stamps: Array) -> tuple[float, Array]:
    """Interval (s) by least squares of the stamps on their index, and the deviations (s)."""
    x = index - index.mean()
    y = stamps - stamps.mean()
    weight = np.ones(len(x))
    slope = 0.0
    for _ in range(3):
        total = weight.sum()
        cx, cy = (weight * x).sum() / total, (weight * y).sum() / total
        slope = (weight * (x - cx) * (y - cy)).sum() / (weight * (x - cx) ** 2).sum()
        residuals = y - cy - slope * (x - cx)
        limit = max(4.0 * _scatter(residuals), 1e-9 * abs(slope))
        new = (np.abs(residuals) <= limit).astype(float)
        if np.array_equal(new, weight) or new.sum() < 0.5 * len(x):
            break
        weight = new
    return float(slope), residuals


def _scatter(residuals: Array) -> float:
    """Standard deviation, robust against the farthest one in a hundred."""
    if not len(residuals):
        return 0.0
    middle = np.median(residuals)
    spread = 1.4826 * float(np.median(np.abs(residuals - middle)))
    bounded = np.clip(residuals - middle, -4.0 * spread, 4.0 * spread)
    return max(spread, float(np.sqrt(np.mean(bounded**2))))
