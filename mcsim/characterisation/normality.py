"""Is a sensor's noise normal?  Skewness and kurtosis of a log, tested for what a log is.

A log's samples are many, rounded, and depend on each other; tests that suppose otherwise (χ² of a
histogram, Kolmogorov-Smirnov, Shapiro-Wilk, Jarque-Bera) reject a healthy sensor.  So the slow
part is taken off first, the correlation that is left widens what chance makes of both moments
(Lobato and Velasco 2004: n γ₀³ / Σ γ³ and n γ₀⁴ / Σ γ⁴ take the place of n), and rounding lowers
the fourth cumulant by what is known of it (Sheppard: Δ⁴ / 120).  The moments become normal by the
transformations of D'Agostino (1970) and of Anscombe and Glynn (1983); the sum of their squares
is D'Agostino and Pearson's K², χ² with two degrees of freedom.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Length of the moving average that is the level (s); samples in it, and averages in a log.
LEVEL, _FEWEST_IN_LEVEL, _LEVELS = 10.0, 100, 10
#: More samples than these are thinned: it changes no distribution, and no test wants more.
_ENOUGH = 1 << 22
#: Deviation in steps below which rounding distorts the moments by more than Sheppard's terms.
_FINEST = 0.7
#: A normal sensor is called otherwise this often.
LEVEL_OF_TEST = 0.01
#: Moments beyond these would show in a histogram.
_SKEWED, _PEAKED = 0.1, 0.2
#: Bins of a histogram at most.
_BINS = 120


@dataclass(frozen=True)
class Normality:
    """Moments of n samples and what they say.

    ``skewness`` and ``excess`` (kurtosis less 3, of the noise before it was rounded) with the
    deviations that chance alone would make of them; ``p`` of K².
    """

    samples: int
    skewness: float
    u_skewness: float
    excess: float
    u_excess: float
    statistic: float
    p: float

    @property
    def is_normal(self) -> bool:
        """Whether nothing speaks against it."""
        return self.p >= LEVEL_OF_TEST

    @property
    def is_slight(self) -> bool:
        """Whether a histogram would hardly show what the test has found."""
        return abs(self.skewness) < _SKEWED and abs(self.excess) < _PEAKED


@dataclass(frozen=True)
class Histogram:
    """``counts`` (m,) of samples in bins between ``edges`` (m + 1,), and of a normal one."""

    edges: Array
    counts: NDArray[np.int64]
    expected: Array
    deviation: float


def fast_part(samples: Array, rate: float) -> Array:
    """Samples (n,) less their moving average over ``LEVEL`` s: what is normal stays normal."""
    from scipy.ndimage import uniform_filter1d

    n = len(samples)
    size = max(1, min(max(round(LEVEL * rate), _FEWEST_IN_LEVEL), n // _LEVELS))
    centred = samples - samples.mean()
    rest = centred - uniform_filter1d(centred, size, mode="reflect")
    return np.asarray(rest[:: -(-n // _ENOUGH)])


def is_coarse(noise: Array, step: float | None) -> bool:
    """Whether rounding to multiples of ``step`` leaves too little of a distribution to test."""
    return step is not None and float(np.std(noise)) < _FINEST * step


def normality(noise: Array, step: float | None = None) -> Normality:
    """Test noise (n,) without a slow part, rounded to multiples of ``step``.

    Its deviation must be 0.7 steps at least (``is_coarse``), n at least 20.
    """
    from scipy.special import chdtrc

    n = len(noise)
    centred = noise - noise.mean()
    second, third, fourth = (float(np.mean(centred**k)) for k in (2, 3, 4))
    rounding = (step or 0.0) ** 4 / 120.0
    own = second - (step or 0.0) ** 2 / 12.0
    of_three, of_four = (n / total for total in _sums(centred))
    skewness = third / second**1.5
    excess = (fourth + rounding) / second**2 - 3.0
    z = _skewness_score(skewness, of_three), _kurtosis_score(excess + 3.0, of_four)
    statistic = z[0] ** 2 + z[1] ** 2
    # Moments in units of the noise before it was rounded.
    by = math.sqrt(second / own)
    return Normality(
        samples=n,
        skewness=skewness * by**3,
        u_skewness=math.sqrt(6.0 / of_three) * by**3,
        excess=excess * by**4,
        u_excess=math.sqrt(24.0 / of_four) * by**4,
        statistic=statistic,
        p=float(chdtrc(2.0, statistic)),
    )


def _sums(centred: Array) -> tuple[float, float]:
    """Sums of the third and fourth powers of the autocorrelation over all lags."""
    from mcsim.characterisation.autocorrelation import autocovariance

    covariance = autocovariance(centred)
    tail = covariance[1:] / covariance[0]
    third = 1.0 + 2.0 * float(np.sum(tail**3))
    return max(third, 1e-3), 1.0 + 2.0 * float(np.sum(tail**4))


def _skewness_score(skewness: float, n: float) -> float:
    """Skewness of n normal samples as a normal deviate (D'Agostino 1970)."""
    y = skewness * math.sqrt((n + 1.0) * (n + 3.0) / (6.0 * (n - 2.0)))
    kurtosis = 3.0 * (n**2 + 27.0 * n - 70.0) * (n + 1.0) * (n + 3.0)
    kurtosis /= (n - 2.0) * (n + 5.0) * (n + 7.0) * (n + 9.0)
    square = math.sqrt(2.0 * (kurtosis - 1.0)) - 1.0
    alpha = math.sqrt(2.0 / (square - 1.0))
    return math.asinh(y / alpha) / math.sqrt(0.5 * math.log(square))


def _kurtosis_score(kurtosis: float, n: float) -> float:
    """Kurtosis of n normal samples as a normal deviate (Anscombe and Glynn 1983)."""
    mean = 3.0 * (n - 1.0) / (n + 1.0)
    variance = 24.0 * n * (n - 2.0) * (n - 3.0) / ((n + 1.0) ** 2 * (n + 3.0) * (n + 5.0))
    x = (kurtosis - mean) / math.sqrt(variance)
    third = 6.0 * (n**2 - 5.0 * n + 2.0) / ((n + 7.0) * (n + 9.0))
    third *= math.sqrt(6.0 * (n + 3.0) * (n + 5.0) / (n * (n - 2.0) * (n - 3.0)))
    a = 6.0 + 8.0 / third * (2.0 / third + math.sqrt(1.0 + 4.0 / third**2))
    root = np.cbrt((1.0 - 2.0 / a) / (1.0 + x * math.sqrt(2.0 / (a - 4.0))))
    return float((1.0 - 2.0 / (9.0 * a) - root) / math.sqrt(2.0 / (9.0 * a)))


def histogram(noise: Array, step: float | None = None) -> Histogram:
    """Bins of whole steps, so that rounding makes no comb; and what a normal noise would fill."""
    from scipy.special import ndtr

    deviation = float(np.std(noise))
    low, high = float(noise.min()), float(noise.max())
    quartiles = float(np.subtract(*np.percentile(noise, [75.0, 25.0])))
    width = max(2.0 * quartiles / len(noise) ** (1.0 / 3.0), (high - low) / _BINS)
    if step is not None:
        width = step * math.ceil(width / step)
    first, last = math.floor(low / width - 0.5), math.ceil(high / width + 0.5)
    edges = (np.arange(first, last + 1) + 0.5) * width
    edges = np.concatenate([[edges[0] - width], edges])
    counts, _ = np.histogram(noise, edges)
    expected = len(noise) * np.diff(ndtr(edges / deviation))
    return Histogram(edges, counts, expected, deviation)
