"""Estimates of an error's distribution, each with a bootstrap confidence interval.

Mean, standard deviation (population) and RMS get BCa intervals (Efron 1987;
Efron & Tibshirani, *An Introduction to the Bootstrap*, ch. 14): the quantiles of
the resampled statistic, corrected for bias and acceleration.  A thousand
resamples do not resolve a quantile at 3 sigma, so their distribution is described
by its mean, deviation and skewness (Cornish-Fisher), which they do resolve.

The bootstrap distribution of a sample quantile is known in closed form; percentiles
need no resampling, and get the order statistics that bound them with the asked
confidence (Hahn & Meeker, *Statistical Intervals*, sect. 5.2).

Beyond ``MOST_ITEMS`` realizations, equal groups of realizations are resampled
instead of single ones: for means of independent errors that is the same to first
order, and the cost no longer grows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Statistics estimated from realizations, in the order of every table.
ESTIMATED = ("mean", "std", "rms", "p50", "p95")
_PERCENTILES = (("p50", 0.50), ("p95", 0.95))
MOST_ITEMS = 2048
_GROUPS = 1024


@dataclass(frozen=True)
class Estimates:
    """Values and interval ends, (e, len(ESTIMATED)) each, in the errors' SI units.

    ``degenerate`` (e,) marks errors that do not scatter at all.
    """

    value: Array
    low: Array
    high: Array
    degenerate: NDArray[np.bool_]


def estimate(errors: Array, sigmas: float, resamples: int, key: int) -> Estimates:
    """Estimate all statistics of all errors.

    Parameters
    ----------
    errors : ndarray (e, r)
        One row per error, one column per realization; a row of NaN is undefined.
    sigmas : float
        Confidence of the two-sided intervals as a number of standard deviations.
    resamples : int
        Number of bootstrap resamples.
    key : int
        64-bit key of the resampling's random numbers.

    Notes
    -----
    Errors that are all equal have intervals of zero width.  From one realization
    no interval follows: its ends are NaN.
    """
    n_errors, n = errors.shape
    value = np.full((n_errors, len(ESTIMATED)), np.nan)
    low, high = value.copy(), value.copy()
    defined = ~np.isnan(errors).any(axis=1)
    degenerate = defined & (errors.max(axis=1) == errors.min(axis=1))
    rows = np.flatnonzero(defined)
    if len(rows):
        value[rows, :3], low[rows, :3], high[rows, :3] = _moments(
            errors[rows], sigmas, resamples, key
        )
        for row in rows:
            value[row, 3:], low[row, 3:], high[row, 3:] = _quantiles(errors[row], sigmas)
    # Without scatter, rounding must not pretend an interval.
    still = np.flatnonzero(degenerate)
    value[still, 1] = 0.0
    for column in (0, 3, 4):
        value[still, column] = errors[still, 0]
    value[still, 2] = np.abs(errors[still, 0])
    low[still], high[still] = value[still], value[still]
    if n == 1:
        low[:], high[:] = np.nan, np.nan
    return Estimates(value, low, high, degenerate)


def _moments(errors: Array, sigmas: float, resamples: int, key: int) -> tuple[Array, Array, Array]:
    """Mean, std and RMS with BCa intervals; three arrays (e, 3)."""
    from mcsim.kernels.bootstrap import resampled_sums

    n_errors, n = errors.shape
    mean = errors.mean(axis=1)
    centred = errors - mean[:, None]
    square = centred**2
    variance = square.mean(axis=1)
    value = _statistics(mean, variance)

    starts = _group_starts(n)
    sizes = np.diff([*starts, n]).astype(float)
    items = np.concatenate(
        [
            np.add.reduceat(centred, starts, axis=1),
            np.add.reduceat(square, starts, axis=1),
            sizes[None],
        ]
    )
    sums = np.empty((len(items), resamples))
    resampled_sums(_counts(len(starts), resamples, key), items, sums)
    shift = sums[:n_errors] / sums[-1]
    resampled = _statistics(
        mean[:, None] + shift,
        np.maximum(sums[n_errors:-1] / sums[-1] - shift**2, 0.0),
    )
    acceleration = _acceleration(centred, square, mean, value)
    low, high = _bca(value, np.moveaxis(resampled, -1, 0), acceleration, sigmas)
    # A deviation, an RMS and the mean of a distance are never negative.
    low[:, 1:] = np.maximum(low[:, 1:], 0.0)
    low[:, 0] = np.where((errors >= 0.0).all(axis=1), np.maximum(low[:, 0], 0.0), low[:, 0])
    return value, low, high


def _statistics(mean: Array, variance: Array) -> Array:
    """Mean, standard deviation and RMS: RMS^2 = mean^2 + std^2; the new axis comes second."""
    return np.stack([mean, np.sqrt(variance), np.sqrt(mean**2 + variance)], axis=1)


def _group_starts(n: int) -> NDArray[np.intp]:
    items = n if n <= MOST_ITEMS else _GROUPS
    return (np.arange(items) * n) // items


@lru_cache(maxsize=4)
def _counts(items: int, resamples: int, key: int) -> NDArray[np.float32]:
    """Resampling counts; drawn once, they serve every error and every point."""
    from mcsim.kernels.bootstrap import resampling_counts

    counts = np.empty((items, resamples), np.float32)
    resampling_counts(np.uint64(key), counts)
    return counts


def _acceleration(centred: Array, square: Array, mean: Array, value: Array) -> Array:
    """BCa acceleration (e, 3) from the empirical influence of each realization."""
    std, rms = value[:, 1], value[:, 2]
    variance = std**2
    influence_mean = centred
    influence_variance = square - variance[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        influences = (
            influence_mean,
            influence_variance / (2.0 * std[:, None]),
            (2.0 * mean[:, None] * centred + influence_variance) / (2.0 * rms[:, None]),
        )
        ratios = [
            np.mean(u**3, axis=1) / np.mean(u**2, axis=1) ** 1.5 / np.sqrt(u.shape[1])
            for u in influences
        ]
    return np.nan_to_num(np.stack(ratios, axis=1), nan=0.0, posinf=0.0, neginf=0.0) / 6.0


def _bca(value: Array, resampled: Array, acceleration: Array, sigmas: float) -> tuple[Array, Array]:
    """BCa interval ends; ``resampled`` (b, e, 3), the others (e, 3)."""
    centre = resampled.mean(axis=0)
    spread = resampled.std(axis=0)
    safe = np.where(spread > 0.0, spread, 1.0)
    deviation = (resampled - centre) / safe
    skewness = np.mean(deviation**3, axis=0)
    distance = (value - centre) / safe
    bias = distance - skewness * (distance**2 - 1.0) / 6.0

    def end(z: float) -> Array:
        corrected = bias + (bias + z) / (1.0 - acceleration * (bias + z))
        quantile = (
            corrected
            + skewness * (corrected**2 - 1.0) / 6.0
            - skewness**2 * (2.0 * corrected**3 - 5.0 * corrected) / 36.0
        )
        return np.where(spread > 0.0, centre + spread * quantile, value)

    low, high = end(-sigmas), end(sigmas)
    return np.minimum(low, value), np.maximum(high, value)


def _quantiles(errors: Array, sigmas: float) -> tuple[Array, Array, Array]:
    """Percentiles of one error with distribution-free intervals.

    The number of errors below the true p-quantile is binomial(n, p), whatever the
    distribution: so the order statistics at its quantiles bound the p-quantile.
    """
    from scipy.special import bdtrik, ndtr

    ordered = np.sort(errors)
    n = len(ordered)
    values, lows, highs = [], [], []
    for _, p in _PERCENTILES:
        below_low, below_high = np.ceil(np.nan_to_num(bdtrik(ndtr([-sigmas, sigmas]), n, p)))
        value = float(np.quantile(ordered, p))
        values.append(value)
        lows.append(min(ordered[max(int(below_low), 1) - 1], value))
        highs.append(max(ordered[min(int(below_high) + 1, n) - 1], value))
    return np.array(values), np.array(lows), np.array(highs)
