"""BCa intervals from resamples (Efron 1987; Efron & Tibshirani, *Bootstrap*, ch. 14).

A thousand resamples do not resolve a quantile at 3 sigma, so their distribution is described by its
mean, deviation and skewness (Cornish-Fisher), which they do resolve.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Relative scatter that is rounding.
ROUNDING = 1e-13


def student_sigmas(sigmas: float, items: int) -> float:
    """Student's quantile in place of the normal one: the resampled spread is of few items."""
    return float(student(np.array(max(items - 1, 1)), sigmas))


def student(degrees: Array, sigmas: float) -> Array:
    """Student's quantile for a spread with these degrees of freedom."""
    from scipy.special import ndtr, stdtrit

    # The spread of resamples is that of a population, smaller than the sample's.
    return np.asarray(stdtrit(degrees, ndtr(sigmas)) * np.sqrt((degrees + 1.0) / degrees), float)


def acceleration(influence: Array) -> Array:
    """BCa acceleration (…) from the influence (…, items) of each item."""
    spread = np.mean(influence * influence, axis=-1)
    safe = np.where(spread > 0.0, spread, 1.0)
    skewness = np.mean(influence * influence * influence, axis=-1) / safe**1.5
    return np.asarray(skewness / np.sqrt(influence.shape[-1]) / 6.0, float)


def bca(value: Array, resampled: Array, acceleration: Array, sigmas: float) -> tuple[Array, Array]:
    """BCa interval ends (…); ``resampled`` (…, b), the others (…)."""
    centre = resampled.mean(axis=-1)
    deviation = resampled - centre[..., None]
    squares = deviation * deviation
    spread = np.sqrt(squares.mean(axis=-1))
    # What scatters by rounding alone does not scatter.
    scatters = spread > ROUNDING * np.abs(value)
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
