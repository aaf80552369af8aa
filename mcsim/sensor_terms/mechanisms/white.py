"""White noise: what every sample has anew."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.mechanism import Mechanism, stream
from mcsim.units import sample_deviation

Array = NDArray[np.float64]

#: Its name in budgets.
NOISE = "noise"


@dataclass(frozen=True)
class White(Mechanism):
    """One-sided ``density``, that of the output.

    A channel has one; further white noise is a ``Process`` of no correlation time.
    """

    density: float
    alone: ClassVar[bool] = True

    def deviation(self, rate: float) -> float:
        """Standard deviation of one sample at ``rate`` (Hz)."""
        return sample_deviation(self.density, rate)


def noise(deviations: Array, seed: int) -> Callable[[int], Array]:
    """White noise of a simulated log: the next n samples (n, c) at each call."""
    random = stream(seed, NOISE)
    return lambda count: deviations * random.standard_normal((count, len(deviations)))


def variances(weights: Array, deviations: Array) -> Array:
    """Variance (e, c) by channel of errors with ``weights`` (e, n, c)."""
    return np.asarray(np.sum((weights * deviations) ** 2, axis=1))
