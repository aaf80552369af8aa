"""Degrees of freedom of Allan, modified, Hadamard and total variances of power-law noise.

Greenhall and Riley, Uncertainty of stability variances based on finite differences (PTTI 2003):
sums of the squared covariances of the differences that a variance is made of.  The exponent α is
that of the density of the samples: white noise 0, flicker −1, random walk −2; quantisation 2.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Terms of the sum; more than that many are taken together, since the covariance is smooth.
_TERMS = 400
#: Differences over more samples than this are those of a continuous signal.
_CONTINUOUS = 100
#: Total variance of white noise, flicker, random walk: edf = b T/τ − c (NIST SP 1065, Table 7).
_TOTAL = {0: (1.50, 0.0), -1: (1.17, 0.22), -2: (0.93, 0.36)}
_QUANTISATION = 2


def degrees_of_freedom(
    alpha: int, order: int, m: int, n: int, *, modified: bool, overlapping: bool
) -> float:
    """Equivalent degrees of freedom of a variance of differences.

    Parameters
    ----------
    alpha : int
        Exponent of the density: 2, 0, −1, −2, for differences of order 3 also −3 and −4.
    order : int
        Of the difference of the phase: 2 for Allan's, 3 for Hadamard's.
    m, n : int
        Samples per cluster, and phases: one more than samples.
    modified, overlapping : bool
        Whether the phase is averaged over the cluster; whether clusters begin at every sample.

    Returns
    -------
    float
        At least 1.
    """
    reach = m + m * order if modified else 1 + m * order
    stride = m if overlapping else 1
    count = 1.0 + math.floor(stride * (n - reach) / m)
    if alpha == _QUANTISATION and not modified:
        return max(_of_quantisation(order, count, count / stride), 1.0)
    terms = min(count, (order + 1.0) * stride)
    coarse = min(1.0, _TERMS / terms)
    few, step, last = count * coarse, stride * coarse, round(terms * coarse)
    width = 1.0 if modified else float(m)
    if not modified and m * (order + 1) > _CONTINUOUS:
        width = math.inf
    lags = np.arange(last + 1)
    squares = _covariance(lags / step, width, alpha, order) ** 2
    weights = 2.0 * np.maximum(1.0 - lags / few, 0.0)
    weights[0], weights[-1] = 1.0, 0.5 * weights[-1]
    return max(float(squares[0] * few / (weights @ squares)), 1.0)


def freedom_of_total(alpha: int, clusters: float) -> float:
    """Equivalent degrees of freedom of the total variance of ``clusters`` = T/τ."""
    slope, offset = _TOTAL[min(0, max(alpha, -2))]
    return max(slope * clusters - offset, 1.0)


def _of_quantisation(order: int, count: float, clusters: float) -> float:
    """White phase noise, whose differences know only those that share a phase with them."""
    first = math.comb(4 * order, 2 * order) / math.comb(2 * order, order) ** 2
    return count / max(first - 0.5 * order / clusters, 1.0)


def _covariance(lag: Array, width: float, alpha: int, order: int) -> Array:
    """Covariance of differences whose places are ``lag`` cluster times apart, up to a factor."""
    total = np.zeros_like(lag)
    for k in range(-order, order + 1):
        sign = -1.0 if k % 2 else 1.0
        total += sign * math.comb(2 * order, order + k) * _mean(lag + k, width, alpha)
    return total


def _mean(lag: Array, width: float, alpha: int) -> Array:
    if math.isinf(width):
        return _structure(lag, alpha + 2)
    step = 1.0 / width
    near = _structure(lag - step, alpha) + _structure(lag + step, alpha)
    return np.asarray(width**2 * (2.0 * _structure(lag, alpha) - near))


def _structure(lag: Array, alpha: int) -> Array:
    """Generalised autocovariance of what a noise of exponent α − 2 is, up to a factor."""
    t = np.abs(lag)
    power = 3 - alpha
    if alpha == 2:
        return -t
    if power % 2:
        return np.asarray(t**power)
    return np.asarray(t**power * np.log(np.where(t > 0.0, t, 1.0)))
