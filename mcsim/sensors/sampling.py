"""From dense truth to the samples that an ideal sensor delivers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Signals = Callable[[Array, "float | Array"], Array]

#: Rate of the dense truth that decimation starts from (Hz).
DENSE_RATE = 1000.0
#: Half-length of the FIR filter, in sensor samples.
FIR_HALF_LENGTH = 10
#: How far the IIR filter's response is followed, in sensor samples.
IIR_HALF_LENGTH = 100
_IIR_ORDER, _IIR_RIPPLE_DB, _IIR_CUTOFF = 8, 0.05, 0.8
#: Least number of dense steps in an averaged interval.
_FEWEST_AVERAGED = 8
#: Sensor samples before the first and after the last that an interpolation looks at.
_AROUND = 4
#: How much denser signals are looked at for power that samples do not hold, and how many samples.
_FINER, _MOST_LOOKED_AT = 4, 1 << 20


def oversampling(rate: float) -> int:
    """Dense steps per sensor sample: the dense step nearest 1 ms that the rate divides."""
    fewer = max(1, int(DENSE_RATE / rate))
    return min((fewer, fewer + 1), key=lambda steps: abs(1.0 / (rate * steps) - 1.0 / DENSE_RATE))


def sample(signals: Signals, start: float, rate: float, count: int, method: str) -> Array:
    """Sample ideal signals at ``start + i / rate``, i = 0 ... count.

    Parameters
    ----------
    signals : callable
        Times (k,) in s and a width (s), of all or of each, to channels (c, k): momentary
        values, but the mean over the width where it holds a jump.  Defined beyond the track as
        well, where it goes straight on: the filters look further than the leads reach.
    start : float
        Time of sample 0 (s).
    rate : float
        Sensor rate (Hz).
    count : int
        Number of the last sample.
    method : {"fir", "iir", "none", "average"}
        ``fir``: zero-phase low-pass of ten sensor samples half-length (Hamming window,
        cut-off at half the sensor rate); ``iir``: Chebyshev I of 8th order, forward
        and backward; ``none``: the momentary value; ``average``: the mean over the
        interval that ends at the sample.  At rates where the dense truth is no
        denser than the samples, the filters have nothing to decimate.

    Returns
    -------
    ndarray (c, count + 1)
    """
    factor = oversampling(rate)
    if method == "average":
        return _average(signals, start, rate, count, max(factor, _FEWEST_AVERAGED))
    if method == "none" or factor == 1:
        # What is filtered elsewhere keeps its integral across jumps here, too.
        width = 0.0 if method == "none" else 1.0 / rate
        return signals(start + np.arange(count + 1) / rate, width)
    if method == "fir":
        return _fir(signals, start, rate, count, factor)
    return _iir(signals, start, rate, count, factor)


def sample_at(signals: Signals, start: float, instants: Array, rate: float, method: str) -> Array:
    """Sample ideal signals at any instants: parameters as for ``sample``.

    ``instants`` (n + 1,) are in s from the first, which is at ``start``.  The filters are those of
    the nominal ``rate``, and what they let pass is interpolated; means are those over the intervals
    that end at the samples, the first one over a nominal interval.

    Returns
    -------
    ndarray (c, n + 1)
    """
    if method == "none":
        return signals(start + instants, 0.0)
    if method == "average":
        return _average_between(signals, start, instants, rate)
    from scipy.interpolate import CubicSpline

    count = int(np.ceil(instants[-1] * rate)) + 1
    factor = oversampling(rate)
    every: Array = np.arange(-_AROUND * factor, (count + _AROUND) * factor + 1, dtype=float)
    times = every / (rate * factor)
    if factor == 1:
        dense = signals(start + times, 1.0 / rate)
    else:
        filtered = _fir if method == "fir" else _iir
        dense = filtered(signals, start + float(times[0]), rate, count + 2 * _AROUND, factor, 1)
    return np.ascontiguousarray(CubicSpline(times, dense, axis=1)(instants))


def _average_between(signals: Signals, start: float, instants: Array, rate: float) -> Array:
    """Means over the intervals between instants, each cut into cells of its own."""
    factor = max(oversampling(rate), _FEWEST_AVERAGED)
    edges = np.append(instants[0] - 1.0 / rate, instants)
    widths = np.repeat(np.diff(edges) / factor, factor)
    middles = np.repeat(edges[:-1], factor) + (np.tile(np.arange(factor), len(instants)) + 0.5) * (
        widths
    )
    cells = signals(start + middles, widths)
    return np.ascontiguousarray(cells.reshape(len(cells), len(instants), factor).mean(axis=-1))


def power_beyond(signals: Signals, start: float, rate: float, count: int) -> Array:
    """Share (c,) of each channel's power above half the sampling rate.

    Parameters as for ``sample``.  Looked for up to twice the rate, on at most a million samples;
    a Hann window keeps the ends apart.
    """
    steps = min(_FINER * count, _MOST_LOOKED_AT)
    fine = signals(start + np.arange(steps + 1) / (_FINER * rate), 1.0 / (_FINER * rate))
    fine = (fine - fine.mean(axis=1, keepdims=True)) * np.hanning(steps + 1)
    power = np.abs(np.fft.rfft(fine, axis=1)) ** 2
    beyond = np.fft.rfftfreq(steps + 1) * _FINER > 0.5
    total = power.sum(axis=1)
    # What is rounding against the other channels has no power.
    there = np.max(np.abs(fine), axis=1) > 1e-9
    return np.divide(
        power[:, beyond].sum(axis=1), total, out=np.zeros(len(fine)), where=there & (total > 0.0)
    )


def _dense(
    signals: Signals,
    start: float,
    rate: float,
    count: int,
    factor: int,
    margin: int,
) -> Array:
    """Dense signals from ``margin`` sensor samples before the first to as many after the last."""
    steps: Array = np.arange(-margin * factor, (count + margin) * factor + 1, dtype=float)
    step = 1.0 / (rate * factor)
    times: Array = start + steps * step
    return signals(times, step)


def _fir(
    signals: Signals, start: float, rate: float, count: int, factor: int, every: int = 0
) -> Array:
    """Samples 0 ... ``count``; every dense value of them where ``every`` is 1."""
    dense = _dense(signals, start, rate, count, factor, FIR_HALF_LENGTH)
    taps = low_pass(FIR_HALF_LENGTH * factor, factor)
    windows = np.lib.stride_tricks.sliding_window_view(dense, len(taps), axis=-1)
    return np.ascontiguousarray(windows[:, :: every or factor] @ taps)


def low_pass(half_length: int, factor: int) -> Array:
    """Windowed-sinc low-pass of unit gain, cut off at 1 / ``factor`` of the band.

    The same taps as ``scipy.signal.firwin(2 half_length + 1, 1 / factor)``, whose import
    alone would take longer than a whole run.
    """
    k = np.arange(-half_length, half_length + 1)
    taps: Array = np.sinc(k / factor) * np.hamming(len(k))
    return taps / taps.sum()


def _iir(
    signals: Signals, start: float, rate: float, count: int, factor: int, every: int = 0
) -> Array:
    """As ``_fir``."""
    from scipy.signal import cheby1, sosfiltfilt

    sections = cheby1(_IIR_ORDER, _IIR_RIPPLE_DB, _IIR_CUTOFF / factor, output="sos")
    dense = _dense(signals, start, rate, count, factor, IIR_HALF_LENGTH)
    filtered = sosfiltfilt(sections, dense, axis=-1, padtype=None)
    # An even order ripples below 1: a constant must stay one.
    filtered = filtered * 10.0 ** (2.0 * _IIR_RIPPLE_DB / 20.0)
    first = IIR_HALF_LENGTH * factor
    last = first + count * factor + 1
    return np.ascontiguousarray(filtered[:, first : last : every or factor])


def _average(signals: Signals, start: float, rate: float, count: int, factor: int) -> Array:
    """Means over the intervals, each cut into cells of its own.

    No cell reaches across a sample, so that a jump that falls on one belongs to one interval.
    """
    width = 1.0 / (rate * factor)
    middles: Array = start + (np.arange(-factor, count * factor, dtype=float) + 0.5) * width
    cells = signals(middles, width)
    return np.ascontiguousarray(cells.reshape(len(cells), count + 1, factor).mean(axis=-1))
