"""Length of a normal vector with any mean and covariance: its mean and quantiles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(160)
#: Offsets in deviations from which on two terms of the expansion are exact to 1e-5 of a deviation.
_FAR = 300.0
#: Deviations beyond which a density is nothing, the narrowest share of the widest one, and
#: the smallest radius (m).
_REACH, _NARROWEST, _TINY = 9.0, 1e-9, 1e-100


def mean_length(centre: Array, covariance: Array) -> float:
    """Mean length of a normal vector of any dimension, exact to quadrature.

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
    x = np.linspace(-38.0, 38.0, 761)
    t = np.exp(2.0 * x)[:, None]
    log_mgf = -np.sum(0.5 * np.log1p(2.0 * t * values) + t * squares / (1.0 + 2.0 * t * values), 1)
    integrand = -np.expm1(log_mgf) * np.exp(-x)
    return float(np.sqrt(scale / np.pi) * np.sum(integrand) * (x[1] - x[0]))


def length_quantile(centre: Array, covariance: Array, p: float) -> float:
    """The p-quantile of the length of a plane or spatial vector, from its distribution function."""
    from scipy.optimize import brentq

    values, vectors = np.linalg.eigh(covariance)
    deviations = np.sqrt(np.maximum(values, 0.0))
    mean = vectors.T @ centre
    offset = float(np.linalg.norm(centre))
    high = float(offset + 9.0 * np.linalg.norm(deviations))
    if deviations[-1] <= 1e-12 * high:
        return offset
    if offset > _FAR * deviations[-1]:
        return _far_quantile(centre / offset, offset, covariance, p)
    deviations = np.maximum(deviations, _NARROWEST * deviations[-1])

    def excess(r: float) -> float:
        return float(_length_below(np.array([r]), mean, deviations)[0]) - p

    return float(brentq(excess, 0.0, high, xtol=1e-13 * high, rtol=1e-13))


def _far_quantile(direction: Array, offset: float, covariance: Array, p: float) -> float:
    """Far from zero the length is a normal one along the offset, and a little of the rest."""
    from scipy.special import ndtri

    along = float(direction @ covariance @ direction)
    beside = float(np.trace(covariance)) - along
    return float(offset + 0.5 * beside / offset + ndtri(p) * np.sqrt(along))


def _length_below(r: Array, mean: Array, deviations: Array) -> Array:
    """P(length <= r) for radii (k,), with independent components, the widest one last.

    Over the narrowest component x = r sin(a), where its density is not nothing; the others
    are a vector of one dimension less within the radius r cos(a), the widest in closed form.
    """
    from scipy.special import ndtr

    centre, deviation = mean[0], deviations[0]
    if len(mean) == 1:
        inside: Array = ndtr((r - centre) / deviation) - ndtr((-r - centre) / deviation)
        return inside
    radius = np.maximum(r, _TINY)
    ends = centre + _REACH * deviation * np.array([-1.0, 1.0])
    low, high = np.arcsin(np.clip(ends[:, None] / radius, -1.0, 1.0))
    half = 0.5 * (high - low)
    a = 0.5 * (low + high)[:, None] + half[:, None] * _NODES
    x, rest = radius[:, None] * np.sin(a), radius[:, None] * np.cos(a)
    density = np.exp(-0.5 * ((x - centre) / deviation) ** 2) / (np.sqrt(2.0 * np.pi) * deviation)
    within = _length_below(rest.ravel(), mean[1:], deviations[1:]).reshape(rest.shape)
    below: Array = half * np.sum(_WEIGHTS * density * within * rest, axis=1)
    return below
