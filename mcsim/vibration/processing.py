"""From a raw channel to one that can be looked at: the source's chain, and its integrals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, detrend, sosfiltfilt, sosfreqz

from mcsim.errors import InputError
from mcsim.vibration.scenario import Chain

Array = NDArray[np.float64]

#: Butterworth, forward and backward: twice the order, no delay, -6 dB at the cut-off.
ORDER = 4
#: Periods of the lowest cut-off in which its transient is gone.
_SETTLING = 3.0
#: A low-pass above this share of the rate has nothing to do.
_HIGHEST_CUT_OFF = 0.45


@dataclass(frozen=True)
class Filters:
    """The chain at a given rate: moving average, high-pass, low-pass.

    None delays, but a moving average of an even number of samples: by half a sample.

    ``notes`` name the steps that this rate leaves nothing to do for.
    """

    chain: Chain
    rate: float
    notes: tuple[str, ...]
    high_pass: Array | None
    low_pass: Array | None

    def apply(self, signal: Array) -> Array:
        """Filtered channels, (n, channels); the mean is removed first."""
        filtered: Array = signal - signal.mean(axis=0)
        if self.chain.moving_average > 1:
            filtered = uniform_filter1d(filtered, self.chain.moving_average, axis=0)
        for sections in (self.high_pass, self.low_pass):
            if sections is not None:
                filtered = self._both_ways(sections, filtered)
        return filtered

    def integrate(self, signal: Array) -> Array:
        """Integral over time without its drift, (n, channels); the high-pass sees to that."""
        integral: Array = cumulative_trapezoid(signal, dx=1.0 / self.rate, axis=0, initial=0)
        if self.high_pass is None:
            return np.asarray(detrend(integral, axis=0))
        return self._both_ways(self.high_pass, integral - integral.mean(axis=0))

    def _both_ways(self, sections: Array, signal: Array) -> Array:
        """Forward and backward; the ends are mirrored far enough for the high-pass to settle.

        Mirrored evenly: an odd extension would put a step of twice the end's value before it.
        """
        slowest = self.chain.high_pass or self.chain.low_pass
        reach = min(len(signal) - 1, int(_SETTLING * self.rate / slowest))
        return np.asarray(sosfiltfilt(sections, signal, axis=0, padtype="even", padlen=reach))

    def gain(self, frequency: Array) -> Array:
        """What the chain leaves of an amplitude at ``frequency`` (Hz)."""
        cycles = np.asarray(frequency, float) / self.rate
        gain = np.ones_like(cycles)
        n = self.chain.moving_average
        if n > 1:
            # sin(pi n f) / (n sin(pi f)), the Dirichlet kernel.
            gain = np.abs(np.sinc(n * cycles) / np.sinc(cycles))
        for sections in (self.high_pass, self.low_pass):
            if sections is not None:
                response = sosfreqz(sections, worN=2.0 * np.pi * cycles)[1]
                gain = gain * np.abs(response) ** 2
        return gain


def refuse_long_average(chain: Chain, name: str, count: int) -> None:
    """Refuse a moving average that is longer than a log of ``count`` samples.

    Raises
    ------
    InputError
        It is.
    """
    if chain.moving_average > count:
        raise InputError(
            f"{name}: a moving average of {chain.moving_average} samples is longer than the "
            f"log ({count} samples); give a shorter one, or 0 for none "
            "(--moving-average, `analysis.moving_average`)"
        )


def filters(chain: Chain, rate: float) -> Filters:
    """The chain's filters for a log of ``rate`` (Hz)."""
    notes = []
    high_pass = low_pass = None
    highest = _HIGHEST_CUT_OFF * rate
    if chain.high_pass > 0.0:
        if chain.high_pass < highest:
            high_pass = butter(ORDER, chain.high_pass, "highpass", fs=rate, output="sos")
        else:
            notes.append(f"no high-pass: {chain.high_pass:g} Hz is too high for {rate:.4g} Hz")
    if chain.low_pass > 0.0:
        if chain.low_pass < highest:
            low_pass = butter(ORDER, chain.low_pass, "lowpass", fs=rate, output="sos")
        else:
            notes.append(f"no low-pass: a rate of {rate:.4g} Hz ends below {chain.low_pass:g} Hz")
    zero = rate / chain.moving_average if chain.moving_average > 1 else np.inf
    if zero < 2.0 * (chain.low_pass or rate / 2.0):
        notes.append(
            f"the moving average of {chain.moving_average} samples has its first zero at "
            f"{zero:.4g} Hz and weakens what lies below"
        )
    return Filters(chain, rate, tuple(notes), high_pass, low_pass)
