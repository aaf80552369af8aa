"""Power spectral density, its floor, and the lines that stand out of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Segments that a log is cut into at least, and their longest length in samples.
_FEWEST_SEGMENTS, _LONGEST_SEGMENT = 8, 1 << 17
#: A floor is the median over frequencies within this factor; lines are looked for from the
#: bin on that has enough neighbours.
_NEIGHBOURHOOD, FIRST_BIN = 1.6, 8
#: False alarms of lines, per log.
_FALSE_ALARMS = 1e-4
#: A line must have at least this multiple of the floor's density at its peak.
_LEAST_RATIO = 1.5
#: Gaps of so many bins do not part a line.
_JOINED_BINS = 4


@dataclass(frozen=True)
class Spectrum:
    """Welch's estimate of a channel's one-sided power spectral density.

    ``frequency`` (k,) in Hz, ``density`` (k,) in the channel's unit squared per Hz,
    ``floor`` (k,) its running median, ``averages`` independent periodograms behind it.
    """

    frequency: Array
    density: Array
    floor: Array
    averages: float

    @property
    def resolution(self) -> float:
        """Distance of the frequencies in Hz."""
        return float(self.frequency[1] - self.frequency[0])


@dataclass(frozen=True)
class Line:
    """A spectral line: its band and peak in Hz, and the deviation of its signal."""

    low: float
    high: float
    peak: float
    deviation: float
    #: Factor by which it raises the Allan deviation where it does so most.
    raises: float
    #: Cluster time (s) of that factor.
    tau: float


def spectrum_of(
    samples: Array, rate: float, length: int | None = None, neighbourhood: float = _NEIGHBOURHOOD
) -> Spectrum:
    """Welch's density of ``samples`` (n,) with Hann windows that overlap by half.

    They are ``length`` samples long, or an eighth of the log; the floor is taken of frequencies
    within the factor ``neighbourhood``.
    """
    from scipy.signal import welch

    n = len(samples)
    if length is None:
        length = _segment(n)
    frequency, density = welch(samples, rate, nperseg=length)
    frequency, density = frequency[1:], density[1:]
    # Segments that overlap by half are worth 11/9 fewer than their number (Hann window).
    averages = max(1.0, (2.0 * n / length - 1.0) * 9.0 / 11.0)
    return Spectrum(
        frequency, density, _floor(frequency, density, averages, neighbourhood), averages
    )


def _segment(n: int) -> int:
    length = 1 << int(np.log2(max(n // _FEWEST_SEGMENTS, 16)))
    return min(length, _LONGEST_SEGMENT, n)


def resolution_of(n: int, rate: float) -> float:
    """Distance of the frequencies (Hz) of the spectrum of n samples."""
    return rate / _segment(n)


def _floor(frequency: Array, density: Array, averages: float, neighbourhood: float) -> Array:
    """Running median over a neighbourhood on the logarithmic axis, as a mean."""
    from scipy.stats import chi2

    step = frequency[0]
    count = max(8, int(24 * np.log10(frequency[-1] / step)))
    centres = np.geomspace(step, frequency[-1], count)
    medians = np.empty(count)
    for i, centre in enumerate(centres):
        low = int(centre / neighbourhood / step)
        high = int(np.ceil(centre * neighbourhood / step))
        medians[i] = np.median(density[max(low - 1, 0) : high])
    # A periodogram's median lies below its mean.
    ratio = chi2.median(2.0 * averages) / (2.0 * averages)
    logarithm = np.interp(np.log(frequency), np.log(centres), np.log(np.maximum(medians, 1e-300)))
    return np.exp(logarithm) / ratio


def white_floor(spectrum: Spectrum) -> float:
    """Allan's N from the flat part of the spectrum: between 1/50 and 2/5 of the rate.

    The one-sided noise density is √2 times as large.
    """
    rate = 2.0 * spectrum.frequency[-1]
    flat = (spectrum.frequency > 0.02 * rate) & (spectrum.frequency < 0.4 * rate)
    return float(np.sqrt(np.median(spectrum.floor[flat]) / 2.0))


def density_from_deviation(deviation: float, bandwidth: float) -> float:
    """Eq. (5.1): ND = σ / √f_3dB, from a log's deviation and the sensor's bandwidth (Hz)."""
    return deviation / float(np.sqrt(bandwidth))


def find_lines(spectrum: Spectrum, first: int = FIRST_BIN, floor_known: float = 1.0) -> list[Line]:
    """Bands whose density stands out of the floor by more than chance, strongest first.

    They are looked for from the bin ``first`` on; the floor may be wrong by the factor
    ``floor_known``.
    """
    from scipy.stats import chi2

    count = len(spectrum.frequency)
    chance = chi2.isf(_FALSE_ALARMS / count, 2.0 * spectrum.averages) / (2.0 * spectrum.averages)
    ratio = spectrum.density / (floor_known * spectrum.floor)
    edge = 1.0 + 3.0 / np.sqrt(spectrum.averages)
    lines = []
    high = np.flatnonzero(ratio[first:] > max(chance, _LEAST_RATIO)) + first
    while len(high):
        run = high[: int(np.argmax(np.append(np.diff(high) > _JOINED_BINS, True))) + 1]
        low, top = int(run[0]), int(run[-1])
        while low > first and ratio[low - 1] > edge:
            low -= 1
        while top < count - 1 and ratio[top + 1] > edge:
            top += 1
        lines.append(_line(spectrum, low, top))
        high = high[high > top]
    return sorted(lines, key=lambda line: -line.raises)


def _line(spectrum: Spectrum, low: int, top: int) -> Line:
    band = slice(low, top + 1)
    frequency, step = spectrum.frequency[band], spectrum.resolution
    excess = np.maximum(spectrum.density[band] - spectrum.floor[band], 0.0) * step
    peak = float(frequency[np.argmax(spectrum.density[band])])
    # Most of a line's Allan variance is at half of its period; Eq. (3.12) on both parts.
    tau = max(0.4 / peak, 0.5 / spectrum.frequency[-1])
    whole = spectrum.frequency > 0.02 / tau
    background = float(
        np.sum(_transfer(spectrum.frequency[whole], tau) * spectrum.floor[whole]) * step
    )
    added = float(np.sum(_transfer(frequency, tau) * excess))
    return Line(
        low=float(frequency[0] - 0.5 * step),
        high=float(frequency[-1] + 0.5 * step),
        peak=peak,
        deviation=float(np.sqrt(excess.sum())),
        raises=float(np.sqrt(1.0 + added / background)),
        tau=tau,
    )


def _transfer(frequency: Array, tau: float) -> Array:
    """Weight of a one-sided density in the Allan variance: 2 sin⁴(πfτ) / (πfτ)²."""
    x = np.pi * frequency * tau
    return 2.0 * np.sin(x) ** 4 / x**2


def without_lines(samples: Array, rate: float, spectrum: Spectrum, lines: list[Line]) -> Array:
    """The samples with the bands of the lines lowered to the floor around them."""
    from scipy.fft import irfft, rfft

    n = len(samples)
    transform = rfft(samples)
    frequency = np.arange(len(transform)) * (rate / n)
    for line in lines:
        band = slice(*np.searchsorted(frequency, [line.low, line.high]))
        near = frequency[band]
        density = np.interp(near, spectrum.frequency, spectrum.density)
        floor = np.interp(near, spectrum.frequency, spectrum.floor)
        transform[band] *= np.sqrt(np.minimum(floor / density, 1.0))
    return irfft(transform, n)


def binned(spectrum: Spectrum, per_decade: int = 200) -> tuple[Array, Array, Array]:
    """Frequency, density and floor, averaged over bins of the logarithmic axis; (m,) each."""
    position = np.log10(spectrum.frequency / spectrum.frequency[0]) * per_decade
    starts = np.flatnonzero(np.diff(np.floor(position), prepend=-1.0) > 0.0)
    counts = np.diff(np.append(starts, len(position)))

    def mean(values: Array) -> Array:
        return np.add.reduceat(values, starts) / counts

    return mean(spectrum.frequency), mean(spectrum.density), mean(spectrum.floor)
