"""AC coupling: a first-order high-pass, behind which nothing constant is left.

It is what its low-pass leaves over, ``y = x - w`` with ``tau w' = x - w``: exact for a signal that
is linear between its dense samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.linear_filter import LinearFilter
from mcsim.sensor_terms.mechanisms.low_pass import LowPass

Array = NDArray[np.float64]


@dataclass(frozen=True)
class HighPass(LinearFilter):
    """-3 dB at ``corner`` (Hz); zero passes everything."""

    corner: float = 0.0
    alone: ClassVar[bool] = True

    @property
    def acts(self) -> bool:
        return self.corner > 0.0

    @property
    def fastest(self) -> float:
        return self.corner

    @property
    def _rest(self) -> LowPass:
        return LowPass(self.corner)

    def settled(self, value: float, rate: float) -> Array:
        return self._rest.settled(value, rate)

    def apply(self, signal: Array, state: Array, rate: float) -> tuple[Array, Array]:
        slow, after = self._rest.apply(signal, state, rate)
        return signal - slow, after

    def over_intervals(
        self, dense: Array, means: Array, rest: float, rate: float
    ) -> tuple[Array, Array]:
        slow, slow_means = self._rest.over_intervals(dense, means, rest, rate)
        return dense - slow, means - slow_means

    def passed(self, value: float) -> float:
        return 0.0 * value
