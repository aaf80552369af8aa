"""Length of a plane normal vector with any mean and covariance: its mean and quantiles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(400)


def mean_length(centre: Array, covariance: Array) -> float:
    """Mean length of a plane normal vector, exact to quadrature.

    ``E sqrt(Q) = 1 / (2 sqrt(pi)) integral (1 - E exp(-t Q)) t^(-3/2) dt`` with the
    moment generating function of a quadratic form; substituting t = exp(2 x) makes the
    integrand smooth and doubly decaying, where the trapezoidal rule converges fast.
    """
    values, vectors = np.linalg.eigh(covariance)
    values = np.maximum(values, 0.0)
    squares = (vectors.T @ centre) ** 2
    scale = float(np.sum(values) + np.sum(squares))
    if scale <= 0.0:
        return 0.0
    values, squares = values / scale, squares / scale
    x = np.linspace(-38.0, 38.0, 3041)
    t = np.exp(2.0 * x)[:, None]
    log_mgf = -np.sum(0.5 * np.log1p(2.0 * t * values) + t * squares / (1.0 + 2.0 * t * values), 1)
    integrand = -np.expm1(log_mgf) * np.exp(-x)
    return float(np.sqrt(scale / np.pi) * np.sum(integrand) * (x[1] - x[0]))


def length_quantile(centre: Array, covariance: Array, p: float) -> float:
    """The p-quantile of the length, by bisection of its distribution function."""
    values, vectors = np.linalg.eigh(covariance)
    deviations = np.sqrt(np.maximum(values, 0.0))
    mean = vectors.T @ centre
    high = float(np.hypot(*centre) + 9.0 * np.hypot(*deviations))
    if deviations[1] <= 1e-12 * high:
        return float(np.hypot(*centre))
    low = 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _length_below(middle, mean, deviations) < p:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _length_below(r: float, mean: Array, deviations: Array) -> float:
    """P(length <= r): over angles x = r sin(a) of the wider axis, the other one in closed form."""
    from scipy.special import ndtr

    a = 0.5 * np.pi * _NODES
    x = r * np.sin(a)
    half = r * np.cos(a)
    density = np.exp(-0.5 * ((x - mean[1]) / deviations[1]) ** 2) / (
        np.sqrt(2.0 * np.pi) * deviations[1]
    )
    narrow = max(deviations[0], 1e-9 * deviations[1])
    inside = ndtr((half - mean[0]) / narrow) - ndtr((-half - mean[0]) / narrow)
    return float(0.5 * np.pi * np.sum(_WEIGHTS * density * inside * half))
