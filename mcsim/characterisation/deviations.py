"""Deviations of the Allan family beside the overlapping Allan deviation, and their intervals.

Riley, Handbook of Frequency Stability Analysis (NIST SP 1065), 5.2; the samples, a rate or an
acceleration, take the place of the fractional frequency, their integral that of the phase.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.density_integral import TabulatedDensity, allan_from_density
from mcsim.characterisation.freedom import degrees_of_freedom, freedom_of_total
from mcsim.characterisation.spectrum import spectrum_of
from mcsim.errors import InputError
from mcsim.kernels.allan import separate_variances, squares_of_stretches

Array = NDArray[np.float64]

#: Of Welch's segments the clusters may last this part.
_OF_SEGMENT = 0.2
_FEWEST_SAMPLES = 16
#: Weights of differences, and how many of them are taken at a time.
_SECOND, _THIRD = (1.0, -2.0, 1.0), (-1.0, 3.0, -3.0, 1.0)
_BLOCK = 1 << 15
#: Clusters below which the total deviation knows more than the overlapping Allan deviation.
_FEW_CLUSTERS = 20
#: Exponent of a density at and below which its Allan variance is infinite.
_STEEPEST = -3.0


@dataclass(frozen=True)
class DeviationKind:
    """A member of the family.

    ``variance`` takes the running sum of the samples (n + 1,), beginning with 0, and samples per
    cluster m, to the samples' unit squared; ``longest`` n to the largest m.  ``order`` is that of
    the difference of the phase, ``modified`` whether it is averaged over the cluster,
    ``overlapping`` whether clusters begin at every sample: what the degrees of freedom follow from.
    """

    name: str
    words: str
    variance: Callable[[Array, int], float]
    longest: Callable[[int], int]
    order: int = 2
    modified: bool = False
    overlapping: bool = True


def _separate(phase: Array, m: int) -> float:
    variance = np.empty(1)
    separate_variances(phase, np.array([m], np.int64), variance)
    return float(variance[0])


def _overlapping(phase: Array, m: int) -> float:
    squares, edges = np.empty((1, 1)), np.array([0, len(phase)], np.int64)
    squares_of_stretches(phase, np.array([m], np.int64), edges, squares)
    return float(squares[0, 0]) / (len(phase) - 2 * m)


def _modified(phase: Array, m: int) -> float:
    """Second differences of phases that are averaged over m samples."""
    total = np.concatenate([[0.0], np.cumsum(phase - phase.mean())])
    square = _mean_square(total, m, _THIRD, len(phase) - 3 * m + 1)
    return square / (2.0 * float(m) ** 4)


def _hadamard(phase: Array, m: int) -> float:
    """Third differences, which a ramp does not show in."""
    return _mean_square(phase, m, _THIRD, len(phase) - 3 * m) / (6.0 * float(m) ** 2)


def _total(phase: Array, m: int) -> float:
    """Second differences of the phase continued beyond both ends by its point reflection."""
    before = 2.0 * phase[0] - phase[m:0:-1]
    after = 2.0 * phase[-1] - phase[-2 : -2 - m : -1]
    long = np.concatenate([before[1:], phase, after])
    return _mean_square(long, m, _SECOND, len(phase) - 2) / (2.0 * float(m) ** 2)


def _mean_square(values: Array, m: int, weights: tuple[float, ...], count: int) -> float:
    """Of ``count`` differences whose members are m apart; block by block, in the cache."""
    total = 0.0
    for start in range(0, count, _BLOCK):
        stop = min(start + _BLOCK, count)
        difference = np.zeros(stop - start)
        for k, weight in enumerate(weights):
            difference += weight * values[start + k * m : stop + k * m]
        # A product by BLAS would start threads for each block.
        total += float(np.sum(np.square(difference, out=difference)))
    return total / count


DEVIATIONS: dict[str, DeviationKind] = {
    kind.name: kind
    for kind in (
        DeviationKind("adev", "Allan", _separate, lambda n: n // 3, overlapping=False),
        DeviationKind("oadev", "overlapping Allan", _overlapping, lambda n: n // 3),
        DeviationKind("mdev", "modified Allan", _modified, lambda n: n // 4, modified=True),
        DeviationKind("hdev", "overlapping Hadamard", _hadamard, lambda n: n // 4, order=3),
        DeviationKind("totdev", "total", _total, lambda n: n // 2),
    )
}
#: The Allan deviation that Welch's density gives by Eq. (3.12).
WELCH = "welch"


@dataclass(frozen=True)
class DeviationCurve:
    """``deviation`` (k,) in the samples' unit over ``factors`` (k,) samples per cluster."""

    kind: str
    factors: NDArray[np.int64]
    interval: float
    deviation: Array

    @property
    def tau(self) -> Array:
        """Cluster times in s."""
        return np.asarray(self.factors * self.interval, dtype=np.float64)


def phase_of(samples: Array) -> Array:
    """Running sum (n + 1,) of samples without their mean, beginning with 0."""
    phase = np.empty(len(samples) + 1)
    phase[0] = 0.0
    phase[1:] = np.cumsum(samples - samples.mean())
    return phase


def deviation_curve(
    samples: Array, rate: float, kind: str, factors: NDArray[np.int64]
) -> DeviationCurve:
    """A deviation of equally spaced samples (n,).

    Parameters
    ----------
    samples : float64 (n,)
        A rate or an acceleration, in any unit.
    rate : float
        Samples per second.
    kind : str
        One of ``DEVIATIONS``, or ``WELCH``.
    factors : int64 (k,)
        Samples per cluster; those that the deviation has too few clusters for are left out.

    Raises
    ------
    InputError
        Fewer than 16 samples.
    """
    n = len(samples)
    if n < _FEWEST_SAMPLES:
        raise InputError(f"{n} samples; a deviation needs at least {_FEWEST_SAMPLES}")
    if kind == WELCH:
        return _of_spectrum(samples, rate, factors)
    found = DEVIATIONS[kind]
    kept = factors[factors <= max(1, found.longest(n))]
    phase = phase_of(samples)
    variances = np.array([found.variance(phase, int(m)) for m in kept])
    return DeviationCurve(kind, kept, 1.0 / rate, np.sqrt(variances))


def _of_spectrum(samples: Array, rate: float, factors: NDArray[np.int64]) -> DeviationCurve:
    """Allan deviation by Eq. (3.12), with the weight of clusters of samples, of Welch's density."""
    spectrum = spectrum_of(samples, rate)
    kept = factors[factors / rate <= _OF_SEGMENT / spectrum.resolution]
    density = TabulatedDensity(spectrum.frequency, np.maximum(0.5 * spectrum.density, 1e-300))
    # The bin at 0 Hz holds the mean alone: below the first one the density goes on as it begins.
    below = density.continued() if density.slopes[0] > _STEEPEST else density
    band = 0.0, 0.5 * rate
    variance = allan_from_density(below, kept / rate, band, spectrum.frequency, 1.0 / rate)
    return DeviationCurve(WELCH, kept, 1.0 / rate, np.sqrt(variance))


def local_exponents(curve: DeviationCurve) -> NDArray[np.int64]:
    """Exponent α (k,) of the noise that rules at each cluster time, from the curve's slope there.

    Quantisation is 2, white noise 0, flicker −1, random walk −2; a third difference also tells −3
    and a ramp-like −4.
    """
    kind = DEVIATIONS[curve.kind]
    logarithm, tau = np.log(curve.deviation), np.log(curve.tau)
    slopes = np.array(
        [
            np.polyfit(tau[max(i - 3, 0) : i + 4], logarithm[max(i - 3, 0) : i + 4], 1)[0]
            for i in range(len(tau))
        ]
    )
    alpha = np.rint(-1.0 - 2.0 * slopes).astype(np.int64)
    if kind.modified:
        # Of white phase noise the modified deviation falls with −3/2: α = 2 by the same formula.
        alpha = np.where(alpha == 1, np.where(slopes < -0.9, 2, 0), alpha)
    else:
        alpha = np.where(alpha == 1, 2, alpha)
    return np.clip(alpha, -2 if kind.order == 2 else -4, 2)


def degrees(curve: DeviationCurve, samples: int) -> Array:
    """Equivalent degrees of freedom (k,) of each point, for the noise that rules there."""
    pairs = zip(local_exponents(curve).tolist(), curve.factors.tolist(), strict=True)
    return np.array([_degrees(curve.kind, alpha, m, samples) for alpha, m in pairs])


def _degrees(name: str, alpha: int, m: int, samples: int) -> float:
    kind = DEVIATIONS[name]
    if name == "totdev" and samples < _FEW_CLUSTERS * m:
        return freedom_of_total(alpha, samples / m)
    # Of many clusters the total variance is the overlapping one.
    return degrees_of_freedom(
        alpha,
        kind.order,
        m,
        samples + 1,
        modified=kind.modified,
        overlapping=kind.overlapping,
    )


def interval_of(curve: DeviationCurve, samples: int, confidence: float) -> tuple[Array, Array]:
    """Ends (k,) of the χ² intervals; nan where the deviation has none, as Welch's."""
    from scipy.stats import chi2

    if curve.kind == WELCH:
        none = np.full(len(curve.factors), np.nan)
        return none, none
    freedom, tail = degrees(curve, samples), 0.5 * (1.0 - confidence)
    low = np.sqrt(freedom / chi2.ppf(1.0 - tail, freedom))
    high = np.sqrt(freedom / chi2.ppf(tail, freedom))
    return curve.deviation * low, curve.deviation * high
