"""What the samples of resting positions tell: noise of one sample, and of their mean.

Samples of a sensor that is low-passed, averaged or held are correlated; their mean then
scatters more than ``s / √n``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: The sum over the autocorrelation stops within this share of a position's samples.
_LONGEST_LAG = 0.25
#: Samples of a position from which on their own scatter is its weight.
FEWEST_OF_ITS_OWN = 10


@dataclass(frozen=True)
class SampleScatter:
    """Noise within positions, of each of m axes.

    ``deviation`` (m,) is that of one sample; ``inflation`` (m,), at least 1, how many times the
    variance of a mean exceeds that of as many independent samples; ``freedom`` (m,) are
    the degrees of freedom of the mean's variance.
    """

    deviation: Array
    inflation: Array
    freedom: Array

    def variance_of_mean(self, counts: NDArray[np.int64]) -> Array:
        """Variance (…, m) of means of ``counts`` (…) samples."""
        variance: Array = self.deviation**2 * self.inflation / np.asarray(counts, float)[..., None]
        return variance


def sample_scatter(positions: Sequence[Array]) -> SampleScatter | None:
    """Noise from the samples (n, m) of each position, in the order of time.

    The autocorrelation, pooled over the positions, is summed as long as sums of neighbouring
    lags are positive (Geyer 1992); what subtracting each position's own mean takes away
    from it is given back.  None if no position has two samples.
    """
    centred = [s - s.mean(axis=0) for s in positions if len(s) > 1]
    if not centred:
        return None
    total = sum(len(c) for c in centred)
    freedom = float(total - len(centred))
    squares = np.sum([np.sum(c**2, axis=0) for c in centred], axis=0)
    lags = [_inflation([c[:, k] for c in centred]) for k in range(squares.shape[0])]
    inflation = np.array([gain for gain, _ in lags])
    summed = np.array([2.0 * last + 1.0 for _, last in lags])
    # The mean that is subtracted takes `inflation` samples' worth of squares, not one.
    kept = np.maximum(total - inflation * len(centred), 0.5 * freedom)
    return SampleScatter(np.sqrt(squares / kept), inflation, np.maximum(freedom / summed, 1.0))


def _inflation(series: Sequence[Array]) -> tuple[float, int]:
    """Variance of a mean over that of independent samples, and the last lag it is summed to."""
    shortest = min(len(s) for s in series)
    longest = int(_LONGEST_LAG * shortest)
    power = sum(float(s @ s) for s in series)
    if longest < 1 or not power > 0.0:
        return 1.0, 0
    total = sum(len(s) for s in series)
    # Each mean subtracted lowers every lag by this share of the variance.
    lowered = len(series) / total
    correlation = np.array(
        [
            sum(float(s[: len(s) - lag] @ s[lag:]) for s in series)
            / power
            * (total / (total - lag * len(series)))
            for lag in range(longest + 1)
        ]
    )
    gain, last = 1.0, 0
    for lag in range(1, longest + 1, 2):
        pair = float(np.sum(correlation[lag : lag + 2])) + 2.0 * lowered * gain
        if pair <= 0.0:
            break
        last = min(lag + 1, longest)
        gain = (1.0 + 2.0 * float(np.sum(correlation[1 : last + 1]))) / max(
            1.0 - (2.0 * last + 1.0) * lowered, 0.25
        )
    return max(gain, 1.0), last


def own_variances(
    positions: Sequence[Array], scatter: SampleScatter | None, shape: tuple[int, ...]
) -> Array | None:
    """Variance of each position's mean by its own samples, in an array of ``shape``.

    Samples are as correlated as in all positions together.  None where one has fewer than ten.
    """
    if scatter is None or min(map(len, positions)) < FEWEST_OF_ITS_OWN:
        return None
    variances = [np.var(s, axis=0, ddof=1) * scatter.inflation / len(s) for s in positions]
    return np.array(variances).reshape(shape)
