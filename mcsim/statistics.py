"""Estimates of an error's distribution, each with a confidence interval.

Realizations are summed in *cells* of equal size (single ones, up to ``MOST_ITEMS``);
from the cells' sums follow mean, standard deviation (population) and RMS, and by
resampling the cells their BCa intervals (Efron 1987; Efron & Tibshirani, *An
Introduction to the Bootstrap*, ch. 14).  For means of independent errors resampling
cells is the same to first order as resampling realizations, and neither the cost nor
the memory grows with their number.  A thousand resamples do not resolve a quantile at
3 sigma, so their distribution is described by its mean, deviation and skewness
(Cornish-Fisher), which they do resolve.

Percentiles need no resampling: the order statistics that bound them with the asked
confidence are known (Hahn & Meeker, *Statistical Intervals*, sect. 5.2).

With *control variates* (quantities whose expectation is known exactly, here the
linear model's errors) only the difference between an error and its control is
estimated: ``E[u] = E[c] + mean(u - c)``, and so for the squares.  The coefficient is
fitted, so that the interval is never wider than without, but for its own noise.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Statistics estimated from realizations, in the order of every table; percentiles follow.
MOMENTS = ("mean", "std", "rms")
#: Percentiles that are estimated where a case does not ask for others.
PERCENTILES = (0.50, 0.95)
#: Most items that are resampled; cells grow by powers of two beyond.
MOST_ITEMS = 2048
#: Cells that realizations make where each is a Sobol net: few, since nets gain by size.
MOST_NETS = 64
#: Realizations that are kept as they are; beyond, only those near a percentile.
KEPT = 1 << 17
#: Half-width of what "near" means, in standard errors of the kept ones' percentile.
_NEAR = 9.0
#: Relative scatter that is rounding.
_ROUNDING = 1e-13


@dataclass(frozen=True)
class Reference:
    """What is known beforehand: per error (e,), SI units.

    ``centre`` is taken off the errors (the method errors); ``mean`` and
    ``second_moment`` are the controls' expectations, absent without controls;
    ``percentiles`` are those to be estimated.
    """

    centre: Array
    mean: Array | None = None
    second_moment: Array | None = None
    percentiles: tuple[float, ...] = PERCENTILES


def statistic_names(percentiles: tuple[float, ...]) -> tuple[str, ...]:
    """Names of the estimated statistics, in the order of every table: ``mean`` … ``p95``."""
    return (*MOMENTS, *(f"p{100.0 * p:g}" for p in percentiles))


@dataclass(frozen=True)
class Estimates:
    """Values and interval ends, (e, statistics) each, in the errors' SI units.

    The statistics are those of ``statistic_names``.

    ``degenerate`` (e,) marks errors that do not scatter at all.
    """

    value: Array
    low: Array
    high: Array
    degenerate: NDArray[np.bool_]


class Collector:
    """Takes in the realizations of one point, in any order and from any thread.

    ``count`` realizations are expected, in pieces that begin at multiples of
    ``cell``; those below ``KEPT`` must be added before any beyond.  With ``nets`` every
    cell is a Sobol net: cells are independent of each other, realizations are not.
    """

    def __init__(self, count: int, reference: Reference, nets: bool = False) -> None:
        from mcsim.kernels.moments import SUMS

        self.count = count
        self.reference = reference
        self.nets = nets
        self.cell = 1
        while count > (MOST_NETS if nets else MOST_ITEMS) * self.cell:
            self.cell *= 2
        cells = -(-count // self.cell)
        n_errors = len(reference.centre)
        self.sums = np.zeros((SUMS, n_errors, cells))
        self.sizes = np.full(cells, float(self.cell))
        self.sizes[-1] = count - (cells - 1) * self.cell
        self._kept = np.empty((n_errors, min(count, KEPT)))
        self._extremes = [np.full(n_errors, np.inf), np.full(n_errors, -np.inf)]
        self._ordered: dict[int, Array] = {}
        self._lock = threading.Lock()
        self._brackets: list[list[_Bracket]] | None = None

    def add(self, first: int, errors: Array, controls: Array) -> None:
        """Take in realizations ``first`` and following: (e, r) errors and controls."""
        from mcsim.kernels.moments import add_cells

        add_cells(errors, self.reference.centre, controls, self.cell, first // self.cell, self.sums)
        low, high = errors.min(axis=1), errors.max(axis=1)
        with self._lock:
            self._extremes = [
                np.minimum(self._extremes[0], low),
                np.maximum(self._extremes[1], high),
            ]
        if first < KEPT:
            kept = min(errors.shape[1], self._kept.shape[1] - first)
            self._kept[:, first : first + kept] = errors[:, :kept]
            if kept == errors.shape[1]:
                return
            errors = errors[:, kept:]
        with self._lock:
            if self._brackets is None:
                percentiles = self.reference.percentiles
                self._brackets = [[_Bracket(row, p) for p in percentiles] for row in self._kept]
        for row, brackets in zip(errors, self._brackets, strict=True):
            for bracket in brackets:
                bracket.add(row)

    @property
    def smallest(self) -> Array:
        """The smallest realization of each error (e,)."""
        return self._extremes[0]

    @property
    def degenerate(self) -> NDArray[np.bool_]:
        """Errors (e,) whose realizations are all equal."""
        return self._extremes[0] == self._extremes[1]

    def not_negative(self) -> NDArray[np.bool_]:
        """Errors (e,) of which no realization is negative."""
        return self._extremes[0] >= 0.0

    def order_statistics(self, error: int, percentile: int, ranks: list[int]) -> list[float]:
        """The realizations of the given ranks (1 ... count) around a percentile."""
        if self._brackets is None:
            ordered = self._sorted(error)
            return [float(ordered[rank - 1]) for rank in ranks]
        return self._brackets[error][percentile].order_statistics(ranks)

    def _sorted(self, error: int) -> Array:
        if error not in self._ordered:
            self._ordered[error] = np.sort(self._kept[error])
        return self._ordered[error]


class _Bracket:
    """Counts the realizations below a percentile's neighbourhood, and keeps those inside."""

    def __init__(self, kept: Array, p: float) -> None:
        ordered = np.sort(kept)
        reach = _NEAR * np.sqrt(p * (1.0 - p) / len(kept))
        last = len(kept) - 1
        self.low = ordered[max(int((p - reach) * last), 0)]
        self.high = ordered[min(int((p + reach) * last) + 1, last)]
        inside = (ordered >= self.low) & (ordered <= self.high)
        self.below = int(np.count_nonzero(ordered < self.low))
        self._inside = [ordered[inside]]
        self._lock = threading.Lock()

    def add(self, values: Array) -> None:
        below = int(np.count_nonzero(values < self.low))
        inside = values[(values >= self.low) & (values <= self.high)]
        with self._lock:
            self.below += below
            self._inside.append(inside)

    def order_statistics(self, ranks: list[int]) -> list[float]:
        # Sorting makes the result independent of the order in which threads came.
        inside = np.sort(np.concatenate(self._inside))
        return [float(inside[min(max(r - 1 - self.below, 0), len(inside) - 1)]) for r in ranks]


def estimate(collector: Collector, sigmas: float, resamples: int, key: int) -> Estimates:
    """Estimate all statistics of all errors.

    Parameters
    ----------
    collector : Collector
        With all its realizations added.
    sigmas : float
        Confidence of the two-sided intervals as a number of standard deviations.
    resamples : int
        Number of bootstrap resamples.
    key : int
        64-bit key of the resampling's random numbers.

    Notes
    -----
    Errors that are all equal have intervals of zero width.  From one realization
    no interval follows: its ends are NaN.  Undefined errors (NaN) stay undefined.
    """
    n_errors = len(collector.reference.centre)
    percentiles = collector.reference.percentiles
    value = np.full((n_errors, len(MOMENTS) + len(percentiles)), np.nan)
    low, high = value.copy(), value.copy()
    defined = np.isfinite(collector.sums[0]).all(axis=1)
    degenerate = defined & collector.degenerate
    rows = np.flatnonzero(defined & ~degenerate)
    if len(rows):
        reach = _of_few(sigmas, len(collector.sizes)) if collector.nets else sigmas
        value[rows, :3], low[rows, :3], high[rows, :3] = _moments(
            collector, rows, reach, resamples, key
        )
        for row in map(int, rows):
            value[row, 3:], low[row, 3:], high[row, 3:] = _quantiles(collector, row, sigmas)
    for row in map(int, np.flatnonzero(degenerate)):
        same = float(collector.smallest[row])
        value[row] = low[row] = high[row] = [same, 0.0, abs(same), *(same for _ in percentiles)]
    if collector.count == 1:
        low[:], high[:] = np.nan, np.nan
    return Estimates(value, low, high, degenerate)


def estimate_errors(errors: Array, sigmas: float, resamples: int, key: int) -> Estimates:
    """Estimate from errors (e, r) that are at hand, without controls."""
    collector = Collector(errors.shape[1], Reference(np.zeros(len(errors))))
    step = max(4096, collector.cell)
    for first in range(0, errors.shape[1], step):
        piece = np.ascontiguousarray(errors[:, first : first + step])
        collector.add(first, piece, np.empty((len(errors), 0)))
    return estimate(collector, sigmas, resamples, key)


def _moments(
    collector: Collector, rows: NDArray[np.intp], sigmas: float, resamples: int, key: int
) -> tuple[Array, Array, Array]:
    """Mean, std and RMS with BCa intervals; three arrays (rows, 3)."""
    centre = collector.reference.centre[rows]
    sizes, n = collector.sizes, collector.count
    first, second = _controlled_sums(collector, rows)
    mean, square = first.sum(axis=1) / n, second.sum(axis=1) / n
    value = _statistics(centre, mean, square)

    # Deviations of each item from its share, scaled to one so that float32 holds them.
    items = np.concatenate([first - mean[:, None] * sizes, second - square[:, None] * sizes])
    scale = np.sqrt(np.mean(items**2, axis=1))
    scale[scale == 0.0] = 1.0
    items /= scale[:, None]
    sums, weights = _resampled(items.astype(np.float32), sizes, resamples, key)
    shifts = sums * scale[:, None] / weights
    half = len(rows)
    resampled = _statistics(
        centre[:, None], mean[:, None] + shifts[:half], square[:, None] + shifts[half:]
    )
    influence = (items * scale[:, None]).reshape(2, half, -1)
    acceleration = _acceleration(centre, mean, value, influence)
    low, high = _bca(value, resampled, acceleration, sigmas)
    # A deviation, an RMS and the mean of a distance are never negative.
    low[:, 1:] = np.maximum(low[:, 1:], 0.0)
    never = collector.not_negative()[rows]
    low[never, 0] = np.maximum(low[never, 0], 0.0)
    return value, low, high


def _of_few(sigmas: float, items: int) -> float:
    """Student's quantile in place of the normal one: the resampled spread is of few items."""
    from scipy.special import ndtr, stdtrit

    few = max(items - 1, 1)
    # The spread of resamples is that of a population, smaller than the sample's.
    return float(stdtrit(few, ndtr(sigmas)) * np.sqrt((few + 1) / few))


def _controlled_sums(collector: Collector, rows: NDArray[np.intp]) -> tuple[Array, Array]:
    """Cell sums of centred errors and of their squares, controls taken off; (rows, cells)."""
    u1, u2, c1, c2, m11, m22, c4 = collector.sums[:, rows]
    reference = collector.reference
    if reference.mean is None or reference.second_moment is None:
        return u1, u2
    n, sizes = collector.count, collector.sizes

    def coefficient(product: Array, u: Array, c: Array, square: Array) -> Array:
        """Least-squares slope of u over c; zero for a control that does not vary."""
        u_mean, c_mean = u.sum(axis=1) / n, c.sum(axis=1) / n
        spread = square.sum(axis=1) / n - c_mean**2
        covariance = product.sum(axis=1) / n - u_mean * c_mean
        varies = spread > 1e-14 * np.maximum(c_mean**2, 1e-300)
        return np.where(varies, covariance / np.where(varies, spread, 1.0), 0.0)[:, None]

    first = u1 - coefficient(m11, u1, c1, c2) * (c1 - reference.mean[rows, None] * sizes)
    second = u2 - coefficient(m22, u2, c2, c4) * (c2 - reference.second_moment[rows, None] * sizes)
    # Where errors lie far from the linear model (saturation), sums that each scatter less can
    # make a deviation that scatters more: the plain ones serve there.
    wider = _deviation_scatter(first, second, sizes, n) > _deviation_scatter(u1, u2, sizes, n)
    return np.where(wider, u1, first), np.where(wider, u2, second)


def _deviation_scatter(first: Array, second: Array, sizes: Array, n: int) -> Array:
    """Scatter (rows, 1) of the items' influence on the variance."""
    mean, square = first.sum(axis=1) / n, second.sum(axis=1) / n
    influence = second - square[:, None] * sizes
    influence -= 2.0 * mean[:, None] * (first - mean[:, None] * sizes)
    return np.sum(influence**2, axis=1, keepdims=True)


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


def _acceleration(centre: Array, mean: Array, value: Array, influence: Array) -> Array:
    """BCa acceleration (e, 3) from the influence (2, e, items) of each item."""
    first, second = influence
    rms = np.maximum(value[:, 2:3], 1e-300)
    std = np.maximum(value[:, 1:2], _ROUNDING * rms)
    ratios = []
    for u in (
        first,
        (second - 2.0 * mean[:, None] * first) / (2.0 * std),
        (second + 2.0 * centre[:, None] * first) / (2.0 * rms),
    ):
        spread = np.mean(u * u, axis=1)
        safe = np.where(spread > 0.0, spread, 1.0)
        ratios.append(np.mean(u * u * u, axis=1) / safe**1.5 / np.sqrt(u.shape[1]))
    return np.stack(ratios, axis=1) / 6.0


def _bca(value: Array, resampled: Array, acceleration: Array, sigmas: float) -> tuple[Array, Array]:
    """BCa interval ends; ``resampled`` (e, 3, b), the others (e, 3)."""
    centre = resampled.mean(axis=-1)
    deviation = resampled - centre[..., None]
    squares = deviation * deviation
    spread = np.sqrt(squares.mean(axis=-1))
    # What scatters by rounding alone does not scatter.
    scatters = spread > _ROUNDING * np.abs(value)
    safe = np.where(scatters, spread, 1.0)
    skewness = np.mean(squares * deviation, axis=-1) / safe**3
    distance = (value - centre) / safe
    bias = distance - skewness * (distance**2 - 1.0) / 6.0

    def end(z: float) -> Array:
        corrected = bias + (bias + z) / (1.0 - acceleration * (bias + z))
        quantile = (
            corrected
            + skewness * (corrected**2 - 1.0) / 6.0
            - skewness**2 * (2.0 * corrected**3 - 5.0 * corrected) / 36.0
        )
        return np.where(scatters, centre + spread * quantile, value)

    low, high = end(-sigmas), end(sigmas)
    return np.minimum(low, value), np.maximum(high, value)


def _quantiles(collector: Collector, error: int, sigmas: float) -> tuple[Array, Array, Array]:
    """Percentiles of one error with distribution-free intervals.

    The number of errors below the true p-quantile is binomial(n, p), whatever the
    distribution: so the order statistics at its quantiles bound the p-quantile.
    """
    n = collector.count
    values, lows, highs = [], [], []
    for i, p in enumerate(collector.reference.percentiles):
        position = p * (n - 1)
        rank = int(position)
        first, last = _bounding_ranks(n, p, sigmas)
        low, a, b, high = collector.order_statistics(
            error, i, [first, rank + 1, min(rank + 2, n), last]
        )
        value = a + (b - a) * (position - rank)
        values.append(value)
        lows.append(min(low, value))
        highs.append(max(high, value))
    return np.array(values), np.array(lows), np.array(highs)


@lru_cache(maxsize=256)
def _bounding_ranks(n: int, p: float, sigmas: float) -> tuple[int, int]:
    """Ranks of the order statistics that bound the p-quantile with the asked confidence."""
    from scipy.special import bdtrik, ndtr

    below_low, below_high = np.ceil(np.nan_to_num(bdtrik(ndtr([-sigmas, sigmas]), n, p)))
    return max(int(below_low), 1), min(int(below_high) + 1, n)
