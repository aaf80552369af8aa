"""What the filters of a chain do to an amplitude, in words: two passes are not one.

A Butterworth filter of order n that runs forward and backward leaves 1/(1 + r^2n) of an amplitude,
r = tan(πf/f_s)/tan(πf_c/f_s) for a low-pass and its inverse for a high-pass: a half, −6 dB, at its
cut-off f_c, and 1/√2, −3 dB, where r = (√2 − 1)^(1/2n).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from mcsim.vibration.processing import ORDER, Filters
from mcsim.vibration.scenario import Chain

Array = NDArray[np.float64]

_HALF_POWER = math.sqrt(0.5)
#: Frequencies at which the band of a chain is looked for.
_GRID = 2000


def half_power_of_high_pass(cut_off: float, rate: float) -> float:
    """Frequency (Hz) at which two passes of the high-pass leave 1/√2 of an amplitude."""
    return _warped(cut_off, rate, (math.sqrt(2.0) - 1.0) ** (-0.5 / ORDER))


def half_power_of_low_pass(cut_off: float, rate: float) -> float:
    """Frequency (Hz) at which two passes of the low-pass leave 1/√2 of an amplitude."""
    return _warped(cut_off, rate, (math.sqrt(2.0) - 1.0) ** (0.5 / ORDER))


def _warped(cut_off: float, rate: float, ratio: float) -> float:
    """The frequency whose tan(πf/f_s) is ``ratio`` times that of the cut-off."""
    return rate / math.pi * math.atan(ratio * math.tan(math.pi * cut_off / rate))


def band(steps: Filters) -> tuple[float, float]:
    """Where the whole chain leaves 1/√2 of an amplitude (Hz), below and above its best.

    Zero and half the rate where it leaves more than that; (nan, nan) where it leaves that nowhere.
    """
    half = steps.rate / 2.0
    frequency = np.concatenate([np.geomspace(1e-5, 1.0, _GRID), np.linspace(0.0, 1.0, _GRID)[1:-1]])
    frequency = half * np.unique(frequency)
    left = steps.gain(frequency) >= _HALF_POWER
    if not left.any():
        return math.nan, math.nan
    first = int(np.argmax(steps.gain(frequency)))
    lower = np.flatnonzero(~left[:first])
    upper = first + np.flatnonzero(~left[first:])
    return (
        _crossing(steps, frequency[lower[-1] : lower[-1] + 2]) if len(lower) else 0.0,
        _crossing(steps, frequency[upper[0] - 1 : upper[0] + 1]) if len(upper) else half,
    )


def _crossing(steps: Filters, ends: Array) -> float:
    def above(frequency: float) -> float:
        return float(steps.gain(np.array([frequency]))[0]) - _HALF_POWER

    return float(brentq(above, ends[0], ends[1]))


def in_words(steps: Filters) -> tuple[str, ...]:
    """A sentence for each filter that acts, and one for all of them together."""
    chain, rate = steps.chain, steps.rate
    said = []
    if chain.moving_average > 1:
        said.append(_average(chain.moving_average, rate))
    if steps.high_pass is not None:
        at = half_power_of_high_pass(chain.high_pass, rate)
        said.append(_pass("high-pass", chain.high_pass, at))
    if steps.low_pass is not None:
        at = half_power_of_low_pass(chain.low_pass, rate)
        said.append(_pass("low-pass", chain.low_pass, at))
    if not said:
        return ("no filter acts; the mean is removed",)
    return (*said, f"together: {_together(*band(steps))}")


def _average(count: int, rate: float) -> str:
    late = "" if count % 2 else f", late by half a sample ({500.0 / rate:.3g} ms)"
    return (
        f"moving average of {count} samples at {rate:.4g} Hz: nothing left at {rate / count:.4g} Hz"
        f"{late}"
    )


def _pass(name: str, cut_off: float, half_power: float) -> str:
    return (
        f"{name} {cut_off:g} Hz (Butterworth of order {ORDER}, forward and backward): "
        f"−6 dB at {cut_off:g} Hz, −3 dB at {half_power:.4g} Hz"
    )


def _together(lower: float, upper: float) -> str:
    if math.isnan(lower):
        return "less than −3 dB left at every frequency"
    return f"−3 dB at {lower:.4g} Hz and {upper:.4g} Hz" if lower else f"−3 dB at {upper:.4g} Hz"


def in_short(steps: Filters) -> str:
    """The chain as the foot of a figure tells it."""
    return f"{design(steps.chain)}; all together {_together(*band(steps))}"


def design(chain: Chain) -> str:
    """The chain by its cut-offs, whatever the rate leaves of it."""
    passes = [
        f"{name} {cut_off:g} Hz"
        for name, cut_off in (("high-pass", chain.high_pass), ("low-pass", chain.low_pass))
        if cut_off > 0.0
    ]
    average = [f"moving average of {chain.moving_average} samples"]
    twice = [f"{' and '.join(passes)} forward and backward (−6 dB there)"]
    parts = [*(average if chain.moving_average > 1 else []), *(twice if passes else [])]
    return ", ".join(parts) or "the mean removed, no filter"
