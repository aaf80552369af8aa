"""Limited bandwidth: a first-order low-pass between the ideal signal and the samples.

The filter is exact for a signal that is linear between its dense samples, and so is its delay of
1/(2π f) for a ramp.  A bilinear one is exact at its cut-off only: its time constant is wrong by
5 % at eight samples per period of the cut-off.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.linear_filter import Hold, LinearFilter

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LowPass(LinearFilter):
    """-3 dB at ``bandwidth`` (Hz)."""

    bandwidth: float = math.inf
    alone: ClassVar[bool] = True

    @property
    def acts(self) -> bool:
        return math.isfinite(self.bandwidth)

    @property
    def fastest(self) -> float:
        return self.bandwidth

    def hold(self, rate: float) -> Hold:
        """Its steps at ``rate`` (Hz)."""
        return Hold.of(2.0 * np.pi * self.bandwidth / rate)

    def settled(self, value: float, rate: float) -> Array:
        return self.hold(rate).settled(value)

    def apply(self, signal: Array, state: Array, rate: float) -> tuple[Array, Array]:
        return self.hold(rate).apply(signal, state)

    def over_intervals(
        self, dense: Array, means: Array, rest: float, rate: float
    ) -> tuple[Array, Array]:
        values = self.hold(rate).over_intervals(dense, rest)
        # tau y' = x - y, integrated over an interval: the mean of y from that of x.
        lag = rate / (dense.shape[1] - 1) / (2.0 * np.pi * self.bandwidth)
        return values, means - lag * (values[:, -1] - values[:, 0])
