"""AC coupling: a first-order high-pass, behind which nothing constant is left.

It is what its low-pass leaves over, ``y = x - w`` with ``tau w' = x - w``: exact for a signal that
is linear between its dense samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.linear_filter import Hold, LinearFilter

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

    def _slow(self, rate: float) -> Hold:
        return Hold.of(2.0 * np.pi * self.corner / rate)

    def settled(self, value: float, rate: float) -> Array:
        return self._slow(rate).settled(value)

    def apply(self, signal: Array, state: Array, rate: float) -> tuple[Array, Array]:
        slow, after = self._slow(rate).apply(signal, state)
        return signal - slow, after

    def over_intervals(
        self,
        dense: Array,
        means: Array,  # noqa: ARG002
        rest: float,
        rate: float,
    ) -> tuple[Array, Array]:
        slow = self._slow(rate).over_intervals(dense, rest)
        # tau w' = x - w = y, integrated over an interval.
        lag = rate / (dense.shape[1] - 1) / (2.0 * np.pi * self.corner)
        return dense - slow, lag * (slow[:, -1] - slow[:, 0])

    def passed(self, value: float) -> float:
        return 0.0 * value
