"""Spectra of channels, and the signal-to-noise ratio that the source takes from them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import ShortTimeFFT, get_window, periodogram, welch
from scipy.signal.windows import hann

Array = NDArray[np.float64]

#: Window of the signal-to-noise ratio: the source's.
_KAISER_BETA = 38.0
#: Harmonics that are no noise, the fundamental included.
_HARMONICS = 6
#: Half width (bins) in which a harmonic's peak is looked for.
_REACH = 4
#: Segments of a Welch spectrum and columns of a spectrogram.
_SEGMENTS, _COLUMNS = 16, 200
#: Half width of the flat-top window's main lobe, in bins.
_FLAT_TOP_LOBE = 5


@dataclass(frozen=True)
class Spectrum:
    """``levels`` (frequencies, channels) over ``frequency`` (Hz)."""

    frequency: Array
    levels: Array


@dataclass(frozen=True)
class Spectrogram:
    """One-sided density in (unit)²/Hz, (frequencies, times), of one channel."""

    frequency: Array
    time: Array
    density: Array


def amplitude_spectrum(signal: Array, rate: float, window: str = "hann") -> Spectrum:
    """Amplitude of a tone at each frequency: windowed FFT over the window's mean gain."""
    weights = get_window(window, len(signal))
    transform = np.fft.rfft(weights[:, None] * (signal - signal.mean(axis=0)), axis=0)
    frequency = np.asarray(np.fft.rfftfreq(len(signal), 1.0 / rate), np.float64)
    levels: Array = 2.0 * np.abs(transform) / weights.sum()
    return Spectrum(frequency, levels)


def welch_spectrum(signal: Array, rate: float) -> Spectrum:
    """One-sided power spectral density in (unit)²/Hz: Welch, Hann, half overlap."""
    length = min(len(signal), max(256, 2 * len(signal) // (_SEGMENTS + 1)))
    frequency, density = welch(signal, rate, nperseg=length, axis=0)
    return Spectrum(frequency, density)


def spectrogram(signal: Array, rate: float) -> Spectrogram:
    """Density over time of one channel, (n,)."""
    length = int(min(len(signal), max(64, min(len(signal) // 16, 4 * rate))))
    hop = max(1, (len(signal) - length) // _COLUMNS)
    transform = ShortTimeFFT(
        hann(length, sym=False), hop, rate, scale_to="psd", fft_mode="onesided2X"
    )
    first, last = transform.lower_border_end[1], transform.upper_border_begin(len(signal))[1]
    density = transform.spectrogram(signal - signal.mean(), p0=first, p1=max(last, first + 1))
    time = transform.t(len(signal), p0=first, p1=max(last, first + 1))
    return Spectrogram(transform.f, time, density)


def tone_amplitude(
    signal: Array, rate: float, frequency: float, width: float
) -> tuple[float, float]:
    """Amplitude and frequency of the strongest tone within ``frequency ± width`` (Hz).

    A flat-top window reads the amplitude to 0.1 % wherever the tone lies between two bins;
    beyond the band's own width the window's main lobe is the limit.
    """
    spectrum = amplitude_spectrum(signal[:, None], rate, "flattop")
    width = max(width, 2.0 * rate / len(signal))
    band = np.flatnonzero(np.abs(spectrum.frequency - frequency) <= width)
    if not len(band):
        return math.nan, math.nan
    peak = band[int(np.argmax(spectrum.levels[band, 0]))]
    return float(spectrum.levels[peak, 0]), float(_centre(spectrum, int(peak)))


def _centre(spectrum: Spectrum, peak: int) -> float:
    """Centre of the main lobe around a peak: the tone's frequency between the bins."""
    around = slice(max(0, peak - _FLAT_TOP_LOBE + 1), peak + _FLAT_TOP_LOBE)
    weight = spectrum.levels[around, 0] ** 2
    return float((weight * spectrum.frequency[around]).sum() / weight.sum())


def signal_to_noise(signal: Array, rate: float) -> float:
    """Ratio (dB) of the strongest tone to all that is no harmonic of it, of one channel (n,).

    The source's: a Kaiser window of β 38 over the whole log; the power of the largest peak,
    down both slopes, over what is left when the mean and six harmonics are taken out and their
    bins filled with the median density.
    """
    _, density = periodogram(signal - signal.mean(), rate, ("kaiser", _KAISER_BETA))
    if not density.any():
        return math.nan
    noise = density.copy()
    noise[slice(*_slopes(density, 0))] = 0.0
    first = int(np.argmax(noise))
    power = 0.0
    for harmonic in range(1, _HARMONICS + 1):
        centre = harmonic * first
        if centre >= len(density):
            break
        near = np.arange(max(1, centre - _REACH), min(len(density), centre + _REACH + 1))
        peak = first if harmonic == 1 else int(near[np.argmax(density[near])])
        lobe = slice(*_slopes(density, peak))
        if harmonic == 1:
            power = float(noise[lobe].sum())
        noise[lobe] = 0.0
    left = noise[noise > 0.0]
    if not len(left):
        return math.inf
    floor = float(np.median(left))
    filled = np.minimum(np.where(noise > 0.0, noise, floor), density)
    return 10.0 * math.log10(power / float(filled.sum()))


def _slopes(density: Array, peak: int) -> tuple[int, int]:
    """Bins of a peak: as far as the density falls on both sides."""
    first = last = peak
    while first > 0 and density[first - 1] <= density[first]:
        first -= 1
    while last + 1 < len(density) and density[last + 1] <= density[last]:
        last += 1
    return first, last + 1
