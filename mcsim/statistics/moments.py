"""Mean, standard deviation and RMS with BCa intervals, by resampling cells.

From the cells' sums follow mean, standard deviation (population) and RMS, and by
resampling the cells their BCa intervals (Efron 1987; Efron & Tibshirani, *An
Introduction to the Bootstrap*, ch. 14).  For means of independent errors resampling
cells is the same to first order as resampling realizations.  A thousand resamples do not
resolve a quantile at 3 sigma, so their distribution is described by its mean, deviation and
skewness (Cornish-Fisher), which they do resolve.

With *control variates* (quantities whose expectation is known exactly, here the
linear model's errors) only the difference between an error and its control is
estimated: ``E[u] = E[c] + mean(u - c)``, and so for the squares.  The coefficient is
fitted, so that the interval is never wider than without, but for its own noise.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mcsim.statistics.collector import Collector

Array = NDArray[np.float64]

#: Relative scatter that is rounding.
_ROUNDING = 1e-13


def moments(
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


def student_sigmas(sigmas: float, items: int) -> float:
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
