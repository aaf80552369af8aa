"""A Gauss-Markov process read off the peak of an Allan deviation, beside a fit of the whole curve.

The thesis' rule, after Eq. (3.21): ``Tc = τ_peak / 1.89`` and ``qc = σ(τ_peak) / (0.437 √Tc)``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.noise_terms import PEAK_LEVEL, PEAK_TIME
from mcsim.characterisation.process import GaussMarkov

Array = NDArray[np.float64]

#: A peak stands out of the curve on both sides by this factor.
_STANDS_OUT = 1.1


@dataclass(frozen=True)
class Peak:
    """A maximum of an Allan deviation: where (s), and how high."""

    tau: float
    deviation: float

    @property
    def correlation_time(self) -> float:
        """Tc in s."""
        return self.tau / PEAK_TIME

    @property
    def drive(self) -> float:
        """qc, in the deviation's unit per root of a second."""
        return self.deviation / (PEAK_LEVEL * math.sqrt(self.correlation_time))

    @property
    def model(self) -> GaussMarkov:
        """The process: its deviation is ``qc √(Tc / 2)``."""
        time = self.correlation_time
        return GaussMarkov(time, self.drive * math.sqrt(time / 2.0))


def find_peak(tau: Array, variance: Array, white: float = 0.0) -> Peak | None:
    """The highest peak of an Allan variance (k,) over cluster times (k,), if one stands out.

    ``white`` is Allan's N, whose part is taken off first: beside white noise the peak of the sum
    lies elsewhere, or there is none.  Between the points it is that of a parabola on the
    logarithmic axes.
    """
    rest = variance - white**2 / tau
    # What is left where white noise is nearly all says nothing.
    clear = np.flatnonzero(rest > 0.1 * variance)
    if len(clear) < 3:
        return None
    time, level = np.log(tau[clear]), 0.5 * np.log(rest[clear])
    top = int(np.argmax(level))
    margin = math.log(_STANDS_OUT)
    if not 0 < top < len(level) - 1:
        return None
    if level[top] - min(level[:top]) < margin or level[top] - min(level[top + 1 :]) < margin:
        return None
    a, b, c = np.polyfit(time[top - 1 : top + 2] - time[top], level[top - 1 : top + 2], 2)
    at = -b / (2.0 * a) if a < 0.0 else 0.0
    return Peak(math.exp(time[top] + at), math.exp(c + 0.5 * b * at))
