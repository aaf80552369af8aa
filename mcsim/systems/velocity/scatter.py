"""Sample standard deviation of correlated normal runs: its moments and quantiles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mcsim.simulation.lengths import mean_length

Array = NDArray[np.float64]

#: Nodes of Talbot's contour: ten digits in double precision up to some thirty degrees of freedom.
_NODES = 24
#: How far a characteristic function is followed, and the logarithm that counts as zero there.
_REACH, _NOTHING = 1000.0, -32.0


def deviations_from_mean(covariance: Array) -> Array:
    """Covariance (m, m) of the runs' deviations from their mean; what they share drops out."""
    centred = covariance - covariance.mean(axis=0)
    return np.asarray(centred - centred.mean(axis=1, keepdims=True), float)


def mean_square_scatter(covariance: Array) -> float:
    """Mean square of the sample standard deviation of normal runs with this covariance (m, m)."""
    runs = len(covariance)
    if runs < 2:
        return 0.0
    return max(float(np.trace(deviations_from_mean(covariance))), 0.0) / (runs - 1)


def mean_scatter(covariance: Array) -> float:
    """Mean of the sample standard deviation: that of a vector's length, exact to quadrature."""
    runs = len(covariance)
    if runs < 2:
        return 0.0
    deviations = deviations_from_mean(covariance)
    return mean_length(np.zeros(runs), deviations) / float(np.sqrt(runs - 1))


def scatter_quantile(covariance: Array, p: float) -> float:
    """The p-quantile of the sample standard deviation of at least two runs.

    Its square is a sum of chi-squares with weights w.  Of few, the distribution function has
    the Laplace transform ``1 / s prod (1 + 2 w s)^(-1/2)``, whose singularities all lie on the
    negative axis, where Talbot's contour inverts it (Abate & Valko, Int. J. Numer. Meth. Eng. 60,
    979, 2004); of many, the characteristic function is summed (Davies, Biometrika 60, 415, 1973).
    """
    from scipy.optimize import brentq

    weights = np.linalg.eigvalsh(deviations_from_mean(covariance)) / (len(covariance) - 1)
    scale = float(weights.sum())
    if scale <= 0.0:
        return 0.0
    weights = np.maximum(weights / scale, 0.0)
    decays = -0.25 * np.sum(np.log1p((2.0 * _REACH * weights) ** 2)) < _NOTHING
    below = _many(weights) if decays else _few(weights)
    high = 2.0
    while below(high) < p:
        high *= 2.0
    root = brentq(lambda q: below(q) - p, 1e-12, high, xtol=1e-13, rtol=1e-12)
    return float(np.sqrt(scale * root))


def _few(weights: Array) -> Callable[[float], float]:
    """Probability that the sum is below its argument, by Talbot's contour."""
    angle = np.arange(1, _NODES) * np.pi / _NODES
    cot = 1.0 / np.tan(angle)
    radius = 2.0 * _NODES / 5.0
    points = np.append(radius + 0j, radius * angle * (cot + 1j))
    slopes = np.append(0.5 + 0j, 1.0 + 1j * angle * (1.0 + cot**2) - 1j * cot)

    def below(q: float) -> float:
        s = points / q
        transform = np.exp(-0.5 * np.sum(np.log1p(2.0 * s[:, None] * weights), axis=1)) / s
        return float(0.4 / q * np.sum(np.real(np.exp(points) * slopes * transform)))

    return below


def _many(weights: Array) -> Callable[[float], float]:
    """The same by summing the characteristic function."""
    largest = 3.0 + 80.0 * float(weights.max())  # exceeded with a probability of 1e-17
    step = 2.0 * np.pi / largest
    u = step * (np.arange(int(_REACH / step)) + 0.5)
    logarithm = sum(-0.5 * np.log1p(-2j * u * w) for w in weights)

    def below(q: float) -> float:
        return 0.5 - float(np.sum(np.imag(np.exp(logarithm - 1j * u * q)) / u)) * step / np.pi

    return below
