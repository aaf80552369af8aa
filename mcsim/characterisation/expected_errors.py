"""How well a log of a given length will give the coefficients: before it is recorded.

Two answers.  Eq. (3.24) of the thesis says how well one point of the Allan deviation is known.
The fit uses the whole curve, and tells the terms apart: its errors follow from the covariance of
all points under the sensor's own noise (Greenhall and Riley 2003), and are what to plan by.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import Covariances, allan_terms, gauss_markov_variance
from mcsim.characterisation.problem import LEAST_MODEL_ERROR, TERMS, B, K, N
from mcsim.characterisation.process import GaussMarkov
from mcsim.kernels.allan import NOISES, allan_covariances

Array = NDArray[np.float64]

#: Cluster times of the fit: this many per decade, up to a third of the log.
_PER_DECADE, _DECADES, _LONGEST = 5, 6, 3.0
#: Powers of time of the integrated noises Q, N, B, K: what their covariances scale with.
_POWERS = np.array([0.0, 1.0, 2.0, 3.0])
#: What the fit takes into account, whether the sensor has it or not.
_FITTED = (N, B, K)
#: Lengths between which one is sought (s), and how closely.
_SHORTEST, _MOST = 10.0, 1e9
_CLOSE = 0.01
#: Name of the correlation time among the terms.
TIME = "Tc"


def relative_error(clusters: float) -> float:
    """Eq. (3.24): ``1 / √(2 (N/K − 1))`` for a log of N/K ``clusters``; infinite for one."""
    return 1.0 / math.sqrt(2.0 * (clusters - 1.0)) if clusters > 1.0 else math.inf


def clusters_needed(error: float) -> float:
    """Eq. (3.25): N/K for a relative ``error`` of the deviation; 9 for 25 %."""
    return 1.0 + 1.0 / (2.0 * error**2)


@dataclass(frozen=True)
class Truth:
    """A sensor's noise: ``squares`` (5,) are Q², N², B², K², R², beside them perhaps a process."""

    squares: Array
    process: GaussMarkov | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The coefficients that it has."""
        found = tuple(TERMS[term] for term in _FITTED if self.squares[term])
        return (*found, TIME) if self.process is not None else found

    def variance(self, tau: Array) -> Array:
        """Allan variance (k,)."""
        own = allan_terms(tau) @ self.squares
        return own if self.process is None else own + self.process.allan_variance(tau)


def fit_errors(truth: Truth, length: float, shortest: float) -> dict[str, float]:
    """Relative standard errors of a fit's coefficients, of a log of ``length`` s.

    Parameters
    ----------
    truth : Truth
    length : float
        Of the log in s.
    shortest : float
        Shortest cluster time (s): the sampling interval.

    Returns
    -------
    dict
        By name, N, B, K and Tc; of what the sensor has.  To first order: errors beyond a third
        or so only say that the coefficient is not known.
    """
    which = _cluster_times() * length >= shortest * (1.0 - 1e-9)
    if np.count_nonzero(which) < len(_FITTED) + 2:
        return dict.fromkeys(truth.names, math.inf)
    tau = _cluster_times()[which] * length
    expected = truth.variance(tau)
    scatter = _scatter(truth, tau, length, which)
    scatter += np.diag((LEAST_MODEL_ERROR * expected) ** 2)
    columns = _columns(truth, tau)
    design = np.column_stack(list(columns.values())) / expected[:, None]
    scatter /= np.outer(expected, expected)
    weights = 1.0 / np.sqrt(np.diagonal(scatter))
    size = np.linalg.norm(design * weights[:, None], axis=0)
    rows = np.linalg.pinv(design * weights[:, None] / size) * weights / size[:, None]
    if truth.process is not None:
        # With a process the fit takes the covariance into account, not the deviations alone.
        inverse = np.linalg.pinv(scatter, rcond=1e-9, hermitian=True)
        rows = np.linalg.pinv((design / size).T @ inverse @ (design / size)) @ (
            (design / size).T @ inverse
        )
        rows /= size[:, None]
    deviation = np.sqrt(np.einsum("pi,ij,pj->p", rows, scatter, rows))
    errors = dict(zip(columns, deviation.tolist(), strict=True))
    return {name: _of_coefficient(truth, name, errors[name]) for name in truth.names}


def _of_coefficient(truth: Truth, name: str, error: float) -> float:
    """Relative error of a coefficient, of that of its square; Tc's own is one already."""
    if name == TIME:
        return error
    return 0.5 * error / float(truth.squares[TERMS.index(name)])


def _columns(truth: Truth, tau: Array) -> dict[str, Array]:
    """What one unit of each parameter adds to the Allan variance."""
    terms = allan_terms(tau)
    if truth.process is None:
        return {TERMS[term]: terms[:, term] for term in _FITTED}
    time, small = truth.process.correlation_time, 1e-3
    drive = 2.0 * truth.process.deviation**2 / time
    longer, shorter = (gauss_markov_variance(tau, time * math.exp(s)) for s in (small, -small))
    kept = [term for term in _FITTED if truth.squares[term]]
    return {
        **{TERMS[term]: terms[:, term] for term in kept},
        "qc": drive * gauss_markov_variance(tau, time),
        TIME: drive * (longer - shorter) / (2.0 * small),
    }


def _scatter(truth: Truth, tau: Array, length: float, which: NDArray[np.bool_]) -> Array:
    unit = _unit_scatter()
    powers = length ** (_POWERS[:, None] + _POWERS[None, :] - 4.0)
    scaled = replace(
        unit,
        products=(powers[:, :, None, None] * unit.products)[:, :, which][:, :, :, which],
        ramps=unit.ramps[:, which][:, :, which],
        interval=length * unit.interval,
        length=length,
    )
    if truth.process is None:
        return scaled.of(truth.squares[:NOISES])
    drive = 2.0 * truth.process.deviation**2 / truth.process.correlation_time
    return scaled.with_process(tau, truth.squares, drive, truth.process.correlation_time)


@lru_cache(1)
def _cluster_times() -> Array:
    """Cluster times (k,) of a log of length 1."""
    steps = np.arange(_PER_DECADE * _DECADES + 1) / _PER_DECADE
    return np.sort(10.0**-steps / _LONGEST)


@lru_cache(1)
def _unit_scatter() -> Covariances:
    """Covariances of the noises in a log of length 1: those of any length are powers of it."""
    tau = _cluster_times()
    interval = float(tau[0])
    products = np.empty((NOISES, NOISES, len(tau), len(tau)))
    ramps = np.empty((NOISES, len(tau), len(tau)))
    allan_covariances(tau, interval, 1.0, products, ramps)
    return Covariances(products, ramps, interval, 1.0)


def length_for(
    error: float, error_of: Callable[[float], float], start: float, most: float = _MOST
) -> float:
    """Length (s) of a log whose ``error_of(length)`` is ``error``; infinite beyond ``most``.

    Errors fall with the root of the length, or nearly so.
    """
    low, high = _SHORTEST, max(start, 2.0 * _SHORTEST)
    while error_of(high) > error:
        low, high = high, 4.0 * high
        if low > most:
            return math.inf
    if error_of(low) <= error:
        return low
    while high / low > 1.0 + _CLOSE:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if error_of(middle) <= error else (middle, high)
    return high
