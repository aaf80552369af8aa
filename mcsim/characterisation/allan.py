"""Allan deviation with χ² intervals, and the covariance of its estimates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.kernels.allan import (
    NOISES,
    allan_covariances,
    process_covariance,
    separate_variances,
    squares_of_stretches,
)

Array = NDArray[np.float64]

#: Cluster times per decade.
_PER_DECADE = 10
#: The longest clusters are this part of the log: fewer than three tell nothing.
_LONGEST = 3
_FEWEST_SAMPLES = 16
#: Stretches of the log whose squared differences are kept apart.
_STRETCHES = 256


@dataclass(frozen=True)
class Stretches:
    """What each of s equal stretches of a log adds to its Allan variances.

    ``squares`` float64 (k, s): sums of half the squared differences whose middle lies in the
    stretch; ``counts`` float64 (k, s): how many they are.
    """

    squares: Array
    counts: Array

    @property
    def variance(self) -> Array:
        """Allan variance (k,) of the whole log."""
        return np.asarray(self.squares.sum(axis=1) / self.counts.sum(axis=1))

    def part(self, which: slice | NDArray[np.int64]) -> Stretches:
        """Of some of the cluster times."""
        return Stretches(self.squares[which], self.counts[which])


@dataclass(frozen=True)
class AllanCurve:
    """Allan deviation over cluster time.

    ``factors`` int64 (k,) samples per cluster; ``interval`` and ``length`` of the log
    in s; ``variance`` float64 (k,) in the samples' unit squared.  ``stretches`` of an
    overlapping estimate, for its bootstrap.
    """

    factors: NDArray[np.int64]
    interval: float
    length: float
    variance: Array
    stretches: Stretches | None = None

    @property
    def overlapping(self) -> bool:
        """Whether clusters begin at every sample."""
        return self.stretches is not None

    def part(self, which: NDArray[np.int64]) -> AllanCurve:
        """The curve at some of its cluster times."""
        stretches = self.stretches.part(which) if self.stretches else None
        return replace(
            self, factors=self.factors[which], variance=self.variance[which], stretches=stretches
        )

    @property
    def tau(self) -> Array:
        """Cluster times in s."""
        return self.factors.astype(np.float64) * self.interval

    @property
    def deviation(self) -> Array:
        """Allan deviation in the samples' unit."""
        return np.sqrt(self.variance)


def averaging_factors(samples: int, rate: float) -> NDArray[np.int64]:
    """Samples per cluster, ten to a decade and one for τ = 1 s, up to a third of the log."""
    largest = max(1, samples // _LONGEST)
    steps = int(np.floor(np.log10(largest) * _PER_DECADE)) + 1
    factors = np.round(10.0 ** (np.arange(steps) / _PER_DECADE)).astype(np.int64)
    one_second = np.int64(round(rate))
    if 1 <= one_second <= largest:
        factors = np.append(factors, one_second)
    return np.unique(factors)


def allan_curve(
    samples: Array,
    rate: float,
    factors: NDArray[np.int64] | None = None,
    overlapping: bool = True,
) -> AllanCurve:
    """Allan variance, Eq. (3.11), of equally spaced samples.

    Parameters
    ----------
    samples : float64 (n,)
        A rate or an acceleration, in any unit.
    rate : float
        Samples per second.
    factors : int64 (k,), optional
        Samples per cluster; ``averaging_factors`` if absent.
    overlapping : bool
        Clusters begin at every sample, or only where the last one ended.

    Raises
    ------
    InputError
        Fewer than 16 samples, or a cluster longer than half of them.
    """
    n = len(samples)
    if n < _FEWEST_SAMPLES:
        raise InputError(f"{n} samples; the Allan variance needs at least {_FEWEST_SAMPLES}")
    if factors is None:
        factors = averaging_factors(n, rate)
    if np.min(factors) < 1 or 2 * np.max(factors) > n:
        raise InputError(f"clusters must hold 1 to {n // 2} of the {n} samples")
    phase = np.empty(n + 1)
    phase[0] = 0.0
    # Without the mean the running sum stays small, and so do its rounding errors.
    np.cumsum(samples - samples.mean(), out=phase[1:])
    if overlapping:
        stretches = _stretches(phase, factors)
        return AllanCurve(factors, 1.0 / rate, n / rate, stretches.variance, stretches)
    variance = np.empty(len(factors))
    separate_variances(phase, factors, variance)
    return AllanCurve(factors, 1.0 / rate, n / rate, variance)


def _stretches(phase: Array, factors: NDArray[np.int64]) -> Stretches:
    stretches = min(_STRETCHES, len(phase) // 2)
    edges = np.arange(stretches + 1) * len(phase) // stretches
    squares = np.empty((len(factors), stretches))
    squares_of_stretches(phase, factors, edges, squares)
    clusters = factors[:, None]
    # A difference that begins at sample i has its middle at i + n.
    first = np.maximum(edges[:-1] - clusters, 0)
    last = np.minimum(edges[1:] - clusters, len(phase) - 2 * clusters)
    return Stretches(squares, np.maximum(last - first, 0).astype(float))


@dataclass(frozen=True)
class Covariances:
    """How Allan variances at ``tau`` scatter together, per noise; see ``allan_covariances``."""

    products: Array
    ramps: Array
    interval: float
    length: float

    def part(self, which: slice) -> Covariances:
        """Of some of the cluster times."""
        return replace(
            self,
            products=self.products[:, :, which, which],
            ramps=self.ramps[:, which, which],
        )

    def with_process(self, tau: Array, squares: Array, drive: float, time: float) -> Array:
        """Covariance matrix (k, k) for Q², N², B², K² and a Gauss-Markov process.

        ``drive`` is its qc², ``time`` its correlation time (s), ``tau`` (k,) the cluster times.
        """
        covariance = np.empty((len(tau), len(tau)))
        process_covariance(
            tau, self.interval, self.length, squares[:NOISES], drive, time, covariance
        )
        return covariance

    def of(self, squares: Array, ramp: float = 0.0) -> Array:
        """Covariance matrix (k, k) for Q², N², B², K² and the square of a rate ramp."""
        mixed = np.einsum("a,b,abij->ij", squares, squares, self.products)
        return mixed + ramp * np.einsum("a,aij->ij", squares, self.ramps)


@lru_cache(maxsize=8)
def _covariances(factors: tuple[int, ...], interval: float, length: float) -> Covariances:
    tau = np.array(factors) * interval
    products = np.empty((NOISES, NOISES, len(tau), len(tau)))
    ramps = np.empty((NOISES, len(tau), len(tau)))
    allan_covariances(tau, interval, length, products, ramps)
    return Covariances(products, ramps, interval, length)


def covariances(curve: AllanCurve) -> Covariances:
    """Covariances of the overlapping estimates of a curve, for any mix of noises."""
    return _covariances(tuple(map(int, curve.factors)), curve.interval, curve.length)


def degrees_of_freedom(curve: AllanCurve, squares: Array) -> Array:
    """Equivalent degrees of freedom 2 E² / Var of each estimate (k,), for a mix of noises.

    ``squares`` float64 (5,) are Q², N², B², K², R²; the ramp R itself does not scatter.  For a
    single noise they are those of Greenhall and Riley (2003, NIST SP 1065, 5.4).
    Estimates that do not overlap have fewer: as many as there are clusters allow.
    """
    if not np.any(squares[:NOISES]):
        squares = np.array([0.0, 1.0, 0.0, 0.0, 0.0])  # a log without noise: as if white
    expected = allan_terms(curve.tau) @ squares
    variance = np.diagonal(covariances(curve).of(squares[:NOISES], squares[NOISES]))
    degrees = 2.0 * expected**2 / variance
    if not curve.overlapping:
        # Of white noise, the worst of the usual ones, an estimate per cluster (Lesage 1973).
        clusters = curve.length / curve.tau
        degrees = np.minimum(degrees, 2.0 * (clusters - 1.0) ** 2 / (3.0 * clusters - 4.0))
    return np.maximum(degrees, 1.0)


def allan_terms(tau: Array) -> Array:
    """Allan variance (k, 5) of unit Q, N, B, K and R at cluster times (k,)."""
    flicker = np.full_like(tau, 2.0 * np.log(2.0) / np.pi)
    return np.stack([3.0 / tau**2, 1.0 / tau, flicker, tau / 3.0, tau**2 / 2.0], axis=1)


def gauss_markov_variance(tau: Array, correlation_time: float) -> Array:
    """Allan variance (k,) of a Gauss-Markov process of unit qc: the table's formula."""
    x = tau / correlation_time
    # The bracket cancels for short clusters; its series begins with 2 x² / 3.
    bracket = 1.0 - (3.0 - 4.0 * np.exp(-x) + np.exp(-2.0 * x)) / (2.0 * x)
    series = x**2 / 3.0 - x**3 / 4.0
    return correlation_time**2 / tau * np.where(x < 1e-3, series, bracket)


def intervals(curve: AllanCurve, degrees: Array, confidence: float) -> tuple[Array, Array]:
    """Ends (k,) of the χ² intervals of the Allan deviation; confidence as probability."""
    from scipy.stats import chi2

    tail = (1.0 - confidence) / 2.0
    low = curve.variance * degrees / chi2.ppf(1.0 - tail, degrees)
    high = curve.variance * degrees / chi2.ppf(tail, degrees)
    return np.sqrt(low), np.sqrt(high)
