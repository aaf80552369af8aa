"""Mean, standard deviation and RMS with BCa intervals, by resampling cells.

From the cells' sums follow mean, standard deviation (population) and RMS, and by
resampling the cells their BCa intervals.  For means of independent errors resampling
cells is the same to first order as resampling realizations.

With *control variates* (quantities whose expectation is known exactly, here the
linear model's errors) only the difference between an error and its control is
estimated: ``E[u] = E[c] + mean(u - c)``, and so for the squares.  The coefficient is
fitted; what each item would be off if it had not taken part in the fit (its residual over one
less its leverage, as in the jackknife) is what is resampled, so that the coefficient's own noise
is in the interval.  Where a control gains little, it is left out.

Two things widen an interval beyond the BCa one.  Where few items carry the scatter, their
spread is itself uncertain: Student's quantile, with the degrees of freedom that the kurtosis
leaves, takes the normal one's place.  And where the linear model knows of rare events, they
scatter as it says, seen or not (``Rare``).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mcsim.statistics.bca import ROUNDING, acceleration, bca, student
from mcsim.statistics.collector import Collector, Rare
from mcsim.statistics.statistic import Interval

Array = NDArray[np.float64]

#: Kurtosis of the influence on mean, deviation and RMS that normal errors have, for which
#: BCa intervals hold.
_NORMAL_KURTOSIS = np.array([3.0, 15.0, 15.0])
#: Degrees of freedom of a spread below which errors that no control takes part in have few
#: items; what a control leaves has heavier tails by nature and is always judged.  Coverage does
#: not depend on it: with 5, 15, 60 and no bound its mean over errors is the same within 0.5 %.
FEW_DEGREES = 15.0
#: A control that leaves more than this share of the variance is not worth its own noise.
_WORTHLESS = 0.9
_MOST_LEVERAGE = 0.9


@dataclass(frozen=True)
class Moments:
    """Mean, std and RMS: values and interval ends (rows, 3); ``few`` (rows,) items carry them."""

    value: Array
    low: Array
    high: Array
    few: NDArray[np.bool_]

    @property
    def mean(self) -> Interval:
        return self._column(0)

    @property
    def std(self) -> Interval:
        return self._column(1)

    @property
    def rms(self) -> Interval:
        return self._column(2)

    def _column(self, column: int) -> Interval:
        return Interval(*(ends[:, column] for ends in (self.value, self.low, self.high)))


@dataclass(frozen=True)
class _Sums:
    """Cell sums (rows, cells) of centred errors and of their squares, controls taken off.

    ``leverage`` (2 rows, cells or 1) of each cell in the fit of the coefficients, first those
    of the errors; ``controlled`` (rows,) tells where controls are used at all.
    """

    first: Array
    second: Array
    leverage: Array
    controlled: NDArray[np.bool_]


def moments(
    collector: Collector, rows: NDArray[np.intp], sigmas: float, resamples: int, key: int
) -> Moments:
    """Mean, std and RMS of the errors ``rows``, with intervals."""
    centre = collector.reference.centre[rows]
    sizes, n = collector.sizes, collector.count
    sums = _controlled_sums(collector, rows)
    mean, square = sums.first.sum(axis=1) / n, sums.second.sum(axis=1) / n
    value = _statistics(centre, mean, square)

    # Deviations of each item from its share, scaled to one so that float32 holds them.
    items = np.concatenate(
        [sums.first - mean[:, None] * sizes, sums.second - square[:, None] * sizes]
    )
    items /= 1.0 - sums.leverage
    scale = np.sqrt(np.mean(items**2, axis=1))
    scale[scale == 0.0] = 1.0
    items /= scale[:, None]
    drawn, weights = _resampled(items.astype(np.float32), sizes, resamples, key)
    shifts = drawn * scale[:, None] / weights
    half = len(rows)
    resampled = _statistics(
        centre[:, None], mean[:, None] + shifts[:half], square[:, None] + shifts[half:]
    )
    influence = _influence(centre, mean, value, (items * scale[:, None]).reshape(2, half, -1))
    low, high = bca(value, resampled, acceleration(influence).T, sigmas)
    degrees = _degrees_of_freedom(influence, sums.controlled)
    few = degrees < np.where(sums.controlled, np.inf, FEW_DEGREES)[:, None]
    stretch = student(degrees, sigmas) / sigmas
    low = np.where(few, value - stretch * (value - low), low)
    high = np.where(few, value + stretch * (high - value), high)
    rare = collector.reference.rare
    if rare is not None:
        low, high = _with_rare_events(value, low, high, rare, rows, n, sigmas)
    # A deviation, an RMS and the mean of a distance are never negative.
    low[:, 1:] = np.maximum(low[:, 1:], 0.0)
    never = collector.not_negative()[rows]
    low[never, 0] = np.maximum(low[never, 0], 0.0)
    return Moments(value, low, high, np.any(degrees < FEW_DEGREES, axis=1))


def _degrees_of_freedom(influence: Array, controlled: NDArray[np.bool_]) -> Array:
    """Degrees of freedom (rows, 3) of the items' spread, as far as it is not that of normal errors.

    The variance of n items with kurtosis k has the relative variance (k - 1) / n, as one
    with 2 n / (k - 1) degrees of freedom.  What a control leaves is products of normals, of
    whose kurtosis a sample shows about half (``benchmarks/coverage.txt``).
    """
    squares = influence**2
    spread = np.mean(squares, axis=-1)
    safe = np.where(spread > 0.0, spread, 1.0)
    kurtosis = np.mean(squares**2, axis=-1) / safe**2
    excess = np.where(controlled[:, None], 2.0 * (kurtosis.T - 1.0), kurtosis.T - _NORMAL_KURTOSIS)
    excess = np.maximum(excess, 1e-9)
    return np.asarray(np.maximum(2.0 * influence.shape[-1] / excess, 1.0), float)


def _with_rare_events(
    value: Array, low: Array, high: Array, rare: Rare, rows: NDArray[np.intp], n: int, sigmas: float
) -> tuple[Array, Array]:
    """Interval ends that hold what rare events would scatter by, whether any has been seen.

    Of N expected events with the variance R, the realized one scatters by R / sqrt(N).
    """
    variance, events = rare.variance[rows], n * rare.events[rows]
    known = (variance > 0.0) & (events > 0.0)
    reach = np.where(known, sigmas * variance / np.sqrt(np.where(known, events, 1.0)), 0.0)
    mean = np.where(known, sigmas * np.sqrt((value[:, 1] ** 2 + variance) / n), 0.0)
    low, high = low.copy(), high.copy()
    low[:, 0] = np.minimum(low[:, 0], value[:, 0] - mean)
    high[:, 0] = np.maximum(high[:, 0], value[:, 0] + mean)
    squares = value[:, 1:] ** 2
    low[:, 1:] = np.minimum(low[:, 1:], np.sqrt(np.maximum(squares - reach[:, None], 0.0)))
    high[:, 1:] = np.maximum(high[:, 1:], np.sqrt(squares + reach[:, None]))
    return low, high


def _controlled_sums(collector: Collector, rows: NDArray[np.intp]) -> _Sums:
    """Sums with controls where these are trusted and gain something."""
    u1, u2, c1, c2, m11, m22, c4 = collector.sums[:, rows]
    reference = collector.reference
    none = np.zeros((2 * len(rows), 1))
    if reference.mean is None or reference.second_moment is None:
        return _Sums(u1, u2, none, np.zeros(len(rows), bool))
    trusted = np.isfinite(reference.mean[rows])
    mean = np.where(trusted, reference.mean[rows], 0.0)
    square = np.where(trusted, reference.second_moment[rows], 0.0)
    first, of_first = _less_control(u1, c1, m11, c2, mean, collector)
    second, of_second = _less_control(u2, c2, m22, c4, square, collector)
    leverage = np.stack([of_first, of_second])
    left = _deviation_scatter(first, second, leverage, collector)
    whole = _deviation_scatter(u1, u2, 0.0 * leverage, collector)
    # Where errors lie far from the linear model (saturation), sums that each scatter less can
    # make a deviation that scatters more.
    used = trusted[:, None] & (left < _WORTHLESS * whole)
    leverage = np.where(used, leverage, 0.0).reshape(2 * len(rows), -1)
    return _Sums(np.where(used, first, u1), np.where(used, second, u2), leverage, used[:, 0])


def _less_control(
    u: Array, c: Array, product: Array, square: Array, expected: Array, collector: Collector
) -> tuple[Array, Array]:
    """Cell sums of u less its least-squares share of c, and each cell's leverage in that fit.

    ``product`` and ``square`` are cell sums of u c and c^2, ``expected`` (rows,) is the mean of c.
    A control that does not vary takes nothing off.
    """
    n, sizes = collector.count, collector.sizes
    u_mean, c_mean = u.sum(axis=1, keepdims=True) / n, c.sum(axis=1, keepdims=True) / n
    spread = square.sum(axis=1, keepdims=True) / n - c_mean**2
    covariance = product.sum(axis=1, keepdims=True) / n - u_mean * c_mean
    varies = spread > 1e-14 * np.maximum(c_mean**2, 1e-300)
    safe = np.where(varies, spread, 1.0)
    coefficient = np.where(varies, covariance / safe, 0.0)
    leverage = (square - 2.0 * c_mean * c + c_mean**2 * sizes) / (n * safe)
    return (
        u - coefficient * (c - expected[:, None] * sizes),
        np.where(varies, np.clip(leverage, 0.0, _MOST_LEVERAGE), 0.0),
    )


def _deviation_scatter(first: Array, second: Array, leverage: Array, collector: Collector) -> Array:
    """Scatter (rows, 1) of the items' influence on the variance."""
    n, sizes = collector.count, collector.sizes
    mean = first.sum(axis=1, keepdims=True) / n
    square = second.sum(axis=1, keepdims=True) / n
    influence = (second - square * sizes) / (1.0 - leverage[1])
    influence -= 2.0 * mean * (first - mean * sizes) / (1.0 - leverage[0])
    return np.asarray(np.sum(influence**2, axis=1, keepdims=True), float)


def _statistics(centre: Array, mean: Array, square: Array) -> Array:
    """Mean, std and RMS from the moments of the centred errors; the new axis comes second.

    RMS^2 = mean^2 + std^2 holds by construction.
    """
    variance = np.maximum(square - mean**2, 0.0)
    whole = centre + mean
    return np.stack([whole, np.sqrt(variance), np.sqrt(whole**2 + variance)], axis=1)


def _resampled(
    items: NDArray[np.float32], sizes: Array, resamples: int, key: int
) -> tuple[Array, Array]:
    """Sums (m, b) of resampled items (m, n), and the resamples' sizes (b,)."""
    from mcsim.kernels.bootstrap import resampled_sums

    counts = _counts(len(sizes), resamples, key)
    sums = np.empty((len(items), resamples), np.float32)
    resampled_sums(counts, items, sums)
    weights = np.full(resamples, sizes.sum())
    if sizes[-1] != sizes[0]:
        weights += (counts[-1] - 1.0) * sizes[-1] - (counts[-1] - 1.0) * sizes[0]
    return sums.astype(float), weights


@lru_cache(maxsize=4)
def _counts(items: int, resamples: int, key: int) -> NDArray[np.uint8]:
    """Resampling counts (items, resamples); drawn once, they serve every error and point."""
    from mcsim.kernels.bootstrap import resampling_counts

    counts = np.empty((items, resamples), np.uint8)
    resampling_counts(np.uint64(key), counts)
    return counts


def _influence(centre: Array, mean: Array, value: Array, items: Array) -> Array:
    """Influence (3, e, items) of each item on mean, std and RMS, from its own (2, e, items)."""
    first, second = items
    rms = np.maximum(value[:, 2:3], 1e-300)
    std = np.maximum(value[:, 1:2], ROUNDING * rms)
    return np.stack(
        [
            first,
            (second - 2.0 * mean[:, None] * first) / (2.0 * std),
            (second + 2.0 * centre[:, None] * first) / (2.0 * rms),
        ]
    )
