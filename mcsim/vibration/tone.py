"""One tone in a channel: frequency and amplitude with their uncertainties from the noise beside it.

The maximum of the Hann-windowed Fourier transform over all frequencies, not only its bins.  Of
a tone in white noise that is the weighted least-squares fit; the window keeps other tones and
slow changes out.  Against the Cramér–Rao bounds of the unwindowed signal it costs a factor of 1.22
in amplitude and 1.53 in frequency; ``u_amplitude`` and ``u_frequency`` hold it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.signal import get_window

Array = NDArray[np.float64]

#: Half width of the Hann window's main lobe (bins), and a bin more.
_LOBE = 3
#: The noise is taken within so many half widths of the search, and at least so many bins.
_FLOOR_WIDTH, _FLOOR_BINS = 5.0, 40
#: Fewer samples hold no tone.
_FEWEST = 32
#: Sums of samples that the search around a peak works on; its phase errs by 1e-6 rad.
_BLOCKS = 4096
#: Independent values of the transform per bin: between bins the maximum is larger than on them.
_PER_BIN = 2.0
#: Shape of the distribution of the noise's mean, per bin of which the median was taken: (ln 2)² for
#: independent ones, of which the window leaves 1 in 1.94.
_SHAPE = math.log(2.0) ** 2 / 1.94
#: Noise alone passes for a tone this often.
FALSE_ALARM = 1e-3


@dataclass(frozen=True)
class FoundTone:
    """``frequency`` and ``u_frequency`` (Hz), ``amplitude`` and ``u_amplitude`` (m/s²).

    The uncertainties are standard ones (k = 1), from the density of the noise beside the tone.
    ``chance`` is the probability that noise alone shows as much within the band of the search.
    """

    frequency: float
    amplitude: float
    u_frequency: float
    u_amplitude: float
    chance: float

    @property
    def above_noise(self) -> bool:
        """Whether noise alone would show it less often than ``FALSE_ALARM``."""
        return self.chance < FALSE_ALARM

    @property
    def height(self) -> float:
        """Amplitude over that which noise has there in quadratic mean (dB)."""
        if not self.amplitude > 0.0:
            return math.nan
        if self.u_amplitude == 0.0:
            return math.inf
        return 20.0 * math.log10(self.amplitude / (math.sqrt(2.0) * self.u_amplitude))


NOT_FOUND = FoundTone(math.nan, math.nan, math.nan, math.nan, math.nan)


def find_tone(signal: Array, rate: float, frequency: float, width: float) -> FoundTone:
    """The strongest tone within ``frequency ± width`` (Hz) of a channel (n,).

    The band is widened to two bins, 2/T, on either side; its parts beyond two bins from zero or
    from half the rate are left out.  All is nan if nothing is left, or the signal is too short.
    """
    n = len(signal)
    if n < _FEWEST:
        return NOT_FOUND
    step = rate / n
    weights = np.asarray(get_window("hann", n, fftbins=False), float)
    weighted = weights * (signal - signal.mean())
    power = np.abs(np.fft.rfft(weighted)) ** 2
    offset = np.abs(np.arange(len(power)) * step - frequency)
    half = max(width, 2.0 * step)
    inner = np.zeros(len(power), bool)
    inner[2:-2] = True
    band = np.flatnonzero((offset <= half) & inner)
    if not len(band):
        return NOT_FOUND
    peak = int(band[np.argmax(power[band])])
    found, level = _maximum(weighted, rate, peak * step)
    beside = _beside(power, peak, max(_FLOOR_WIDTH * half / step, _FLOOR_BINS), inner)
    # Of noise the median is ln 2 times the mean; other tones count little in it.
    noise = float(np.median(beside)) / math.log(2.0) if len(beside) else math.nan
    amplitude = 2.0 * level / float(weights.sum())
    u_frequency, u_amplitude = _uncertainties(weights, rate, amplitude, noise)
    chance = _chance(_ratio(level**2, noise), len(band), len(beside))
    return FoundTone(found, amplitude, u_frequency, u_amplitude, chance)


def _maximum(weighted: Array, rate: float, centre: float) -> tuple[float, float]:
    """Frequency (Hz) and level of the transform's maximum within a bin of ``centre``."""
    n = len(weighted)
    time = (np.arange(n) - (n - 1) / 2.0) / rate
    turned = weighted * np.exp(-2j * np.pi * centre * time)
    edges = np.linspace(0, n, min(n, _BLOCKS) + 1).astype(int)[:-1]
    sizes = np.diff(np.append(edges, n))
    sums = np.add.reduceat(turned, edges)
    times = np.add.reduceat(time, edges) / sizes
    step = rate / n

    def loss(shift: float) -> float:
        return -abs(complex(np.exp(-2j * np.pi * shift * step * times) @ sums))

    best = minimize_scalar(loss, bounds=(-1.0, 1.0), method="bounded", options={"xatol": 1e-7})
    return centre + float(best.x) * step, -float(best.fun)


def _beside(power: Array, peak: int, reach: float, inner: NDArray[np.bool_]) -> Array:
    """Powers of the bins beside a peak."""
    away = np.abs(np.arange(len(power)) - peak)
    return power[(away > _LOBE) & (away <= reach) & inner]


def _uncertainties(
    weights: Array, rate: float, amplitude: float, noise: float
) -> tuple[float, float]:
    """Of frequency (Hz) and amplitude (m/s²), for a noise of this power per bin.

    With weights w and white noise σ: u(A)² = 2σ² Σw² / (Σw)² and
    u(ω)² = 2σ² Σw²t² / (A Σwt²)², the bounds 2σ²/N and 24σ²/(A²N³) of no window.
    """
    n = len(weights)
    time = (np.arange(n) - (n - 1) / 2.0) / rate
    # The mean power of a bin is σ² Σw².
    doubled = 2.0 * noise / float(weights @ weights)
    u_amplitude = math.sqrt(doubled * float(weights @ weights)) / float(weights.sum())
    if not amplitude > 0.0:
        return math.nan, u_amplitude
    spread = math.sqrt(doubled * float((weights * time) @ (weights * time)))
    u_turn = spread / (amplitude * float(weights @ time**2))
    return u_turn / (2.0 * math.pi), u_amplitude


def _ratio(power: float, noise: float) -> float:
    if noise != 0.0:
        return power / noise
    return math.inf if power > 0.0 else 0.0


def _chance(ratio: float, bins: int, beside: int) -> float:
    """Probability that the largest of ``bins`` powers of noise exceeds ``ratio`` times its mean.

    Each is exponentially distributed, over a mean that ``beside`` bins have shown: as if from
    a gamma distribution whose shape is that of their median.
    """
    if math.isnan(ratio):
        return math.nan
    shape = _SHAPE * beside
    single = math.exp(-shape * math.log1p(ratio / shape)) if math.isfinite(ratio) else 0.0
    return -math.expm1(_PER_BIN * bins * math.log1p(-single)) if single < 1.0 else 1.0
