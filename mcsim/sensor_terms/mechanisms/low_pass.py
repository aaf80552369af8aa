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

from mcsim.sensor_terms.mechanisms.linear_filter import LinearFilter

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


@dataclass(frozen=True)
class Hold:
    """``y[k] = decay y[k-1] + old x[k-1] + new x[k]``: one step of ``tau y' = x - y``."""

    decay: float
    old: float
    new: float

    @classmethod
    def of(cls, ratio: float) -> Hold:
        """``ratio`` is 2π times the bandwidth times the interval between the samples."""
        decay = np.exp(-ratio)
        gone = -np.expm1(-ratio) / ratio
        return cls(float(decay), float(gone - decay), float(1.0 - gone))

    def apply(self, signal: Array, state: Array) -> tuple[Array, Array]:
        """Filtered (n,) and the state (1,) after it, from the ``state`` before."""
        from scipy.signal import lfilter

        filtered, after = lfilter([self.new, self.old], [1.0, -self.decay], signal, zi=state)
        return np.asarray(filtered, float), np.asarray(after, float)

    def settled(self, value: float) -> Array:
        """The state (1,) when ``value`` has been there for ever."""
        return np.array([(self.old + self.decay) * value])

    def over_intervals(self, dense: Array, rest: float) -> Array:
        """Filtered values (n, k + 1) of ``dense`` ones in n intervals, settled at ``rest``."""
        from scipy.signal import lfilter

        pushes = self.old * dense[:, :-1] + self.new * dense[:, 1:]
        states, _ = lfilter([1.0], [1.0, -self.decay], pushes.ravel(), zi=[self.decay * rest])
        return in_intervals(np.append(rest, states), len(dense))


def in_intervals(values: Array, count: int) -> Array:
    """Values (n k + 1,) of a signal that does not jump, as (n, k + 1) with both ends of each."""
    steps = (len(values) - 1) // count
    windows = np.lib.stride_tricks.sliding_window_view(values, steps + 1)
    return np.asarray(windows[::steps])
