"""Limited bandwidth: a first-order low-pass between the ideal signal and the samples.

The filter is exact for a signal that is linear between its dense samples, and so is its delay of
1/(2π f) for a ramp.  A bilinear one is exact at its cut-off only: its time constant is wrong by
5 % at eight samples per period of the cut-off.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.mechanism import Mechanism

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LowPass(Mechanism):
    """-3 dB at ``bandwidth`` (Hz)."""

    bandwidth: float = math.inf
    alone: ClassVar[bool] = True


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


def filtered(signal: Array, bandwidth: float, step: float) -> Array:
    """A signal (n,) behind the low-pass, which has settled at its first value."""
    if not np.isfinite(bandwidth):
        return signal
    hold = Hold.of(2.0 * np.pi * bandwidth * step)
    return hold.apply(signal, hold.settled(signal[0]))[0]


def low_pass(bandwidths: tuple[float, ...], rate: float) -> Callable[[Array], Array]:
    """The low-pass of a simulated log: the next n samples (n, s) at ``rate`` (Hz) at each call.

    Columns of infinite bandwidth, and those beyond ``bandwidths``, pass unchanged.
    """
    holds = {k: Hold.of(2.0 * np.pi * f / rate) for k, f in enumerate(bandwidths) if np.isfinite(f)}
    states: dict[int, Array] = {}

    def take(signals: Array) -> Array:
        if not holds or not len(signals):
            return signals
        passed = signals.copy()
        for k, hold in holds.items():
            state = states.get(k, hold.settled(signals[0, k]))
            passed[:, k], states[k] = hold.apply(signals[:, k], state)
        return passed

    return take
