"""A digital output: it saturates, then takes the nearest step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.mechanism import Mechanism

Array = NDArray[np.float64]

#: Its name in budgets.
QUANTISATION = "quantisation"
#: Terms of the Fourier series of a rounding error, and the noise in steps below which none is.
_HARMONICS, _STILL = 400, 2e-3


@dataclass(frozen=True)
class Saturation(Mechanism):
    """Values end at plus and minus ``largest``."""

    largest: float = math.inf
    alone: ClassVar[bool] = True


@dataclass(frozen=True)
class Quantisation(Mechanism):
    """Values are multiples of ``step``, zero for none."""

    step: float = 0.0
    alone: ClassVar[bool] = True


def digitised(values: Array, ranges: Array, resolutions: Array) -> Array:
    """What a digital output makes of ``values`` (n, c); ``ranges``, ``resolutions`` (c,).

    Half a step is rounded up, as the kernels do: a step then holds the same values wherever it
    lies, which it does not where halves go to the even step.
    """
    cut = np.clip(values, -ranges, ranges)
    coarse = resolutions > 0.0
    step = np.where(coarse, resolutions, 1.0)
    return np.where(coarse, step * np.floor(cut * (1.0 / step) + 0.5), cut)


def rounding_variances(resolution: float, spread: float) -> tuple[float, float]:
    """Variances of what rounding adds to a mean: the part that no averaging takes away, and
    that of one sample, for averaging.

    Values in steps of ``resolution`` under normal noise of deviation ``spread`` (Widrow & Kollar,
    *Quantization Noise*, ch. 9), over all places between two steps.  Without noise the mean is
    rounded as each sample is, q²/12; noise of a step or more leaves q²/12 per sample.
    """
    whole = resolution**2 / 12.0
    if spread <= _STILL * resolution:
        return whole, 0.0
    if resolution == 0.0:
        return 0.0, 0.0
    k = np.arange(1.0, _HARMONICS)
    damped = np.exp(-((2.0 * np.pi * k * spread / resolution) ** 2))
    lasting = resolution**2 / (2.0 * math.pi**2) * float(np.sum(damped / k**2))
    single = whole - lasting - 2.0 * spread**2 * float(np.sum(damped))
    return lasting, max(0.0, single)
