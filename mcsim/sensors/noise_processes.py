"""Coloured noise and the low-pass of a sensor element, in pieces of any size.

A process gives the same values however they are taken: all at once or piece by piece.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Largest ratio of neighbouring correlation times of flicker noise; the spectrum of the sum
#: ripples by ±0.3 % about 1/f.
_FLICKER_RATIO = 4.0
#: Shortest correlation time in sample intervals, longest in lengths of the log.  The Allan
#: deviation is then within 1 % of 0.664 B from five samples to a tenth of the log.
_SHORTEST, _LONGEST = 0.3, 10.0
#: The low-pass does nothing that samples could show when its cut-off is above this share of
#: the rate.
_HIGHEST_CUT_OFF = 0.45


class GaussMarkov:
    """A first-order Gauss-Markov process per axis, Eq. (3.27)-(3.29), from its stationary state.

    ``x[k] = a x[k-1] + w[k]``, ``a = exp(-dt/Tc)``, ``var w = sigma^2 (1 - a^2)``; an infinite
    time is a constant of deviation sigma.
    """

    def __init__(
        self, deviation: Array, correlation_time: Array, step: float, random: np.random.Generator
    ) -> None:
        with np.errstate(divide="ignore"):
            exponent = np.where(correlation_time > 0.0, -step / correlation_time, -np.inf)
        self._decay = np.exp(exponent)
        # expm1 keeps the small steps of long correlation times.
        self._step_deviation = deviation * np.sqrt(-np.expm1(2.0 * exponent))
        self._random = random
        self._next = deviation * random.standard_normal(len(deviation))

    def take(self, count: int) -> Array:
        """The next ``count`` values, (count, axes)."""
        from scipy.signal import lfilter

        noise = self._random.standard_normal((count, len(self._decay))) * self._step_deviation
        values = np.empty_like(noise)
        for axis, decay in enumerate(self._decay):
            # Value k is the state before noise k moves it on.
            driven = np.concatenate(([self._next[axis]], noise[:, axis]))
            states = lfilter([1.0], [1.0, -decay], driven)
            values[:, axis], self._next[axis] = states[:-1], states[-1]
        return values


class Flicker:
    """Noise of two-sided density ``(B²/2π)/f``: see ``flicker_processes``."""

    def __init__(
        self, instability: Array, step: float, duration: float, random: np.random.Generator
    ) -> None:
        times, variance = flicker_processes(step, duration)
        deviation = instability * math.sqrt(variance)
        self._processes = [
            GaussMarkov(deviation, np.full(len(instability), time), step, stream)
            for time, stream in zip(times, random.spawn(len(times)), strict=True)
        ]

    def take(self, count: int) -> Array:
        """The next ``count`` values, (count, axes)."""
        total = self._processes[0].take(count)
        for process in self._processes[1:]:
            total += process.take(count)
        return total


def flicker_processes(step: float, duration: float) -> tuple[Array, float]:
    """Gauss-Markov processes that make up flicker noise of B = 1 over ``duration``.

    A continuum of correlation times of variance ``d(ln T) / π`` has the density of flicker
    noise between its ends.  It is cut into equal pieces of ``ln T``, so that its variance, and
    with it every error, goes smoothly with the rate and the length of the run.

    Returns
    -------
    ndarray (m,), float
        Correlation times (s), and the variance of each process.
    """
    shortest, longest = _SHORTEST * step, _LONGEST * max(duration, step)
    width = math.log(longest / shortest)
    count = math.ceil(width / math.log(_FLICKER_RATIO))
    piece = width / count
    times: Array = shortest * np.exp((np.arange(count) + 0.5) * piece)
    return times, piece / math.pi


class RandomWalk:
    """Brownian motion of intensity K from zero: steps of ``K √dt``."""

    def __init__(self, intensity: Array, step: float, random: np.random.Generator) -> None:
        self._step_deviation = intensity * math.sqrt(step)
        self._random = random
        self._last = np.zeros(len(intensity))

    def take(self, count: int) -> Array:
        """The next ``count`` values, (count, axes)."""
        steps = self._random.standard_normal((count, len(self._last))) * self._step_deviation
        # Added up from the last value on, so that it matters not where the pieces end.
        values = np.cumsum(np.vstack([self._last, steps]), axis=0)
        self._last = values[-1]
        return values[:-1]


class LowPass:
    """First-order low-pass per axis: bilinear, -3 dB exactly at the cut-off, from rest at x[0]."""

    def __init__(self, cut_off: Array, rate: float) -> None:
        self._coefficients = [_low_pass(f, rate) for f in cut_off]
        self._state: list[Array] | None = None

    def pass_on(self, signal: Array) -> Array:
        """The filtered signal, (n, axes); axes without a low-pass are unchanged."""
        from scipy.signal import lfilter

        if not len(signal):
            return signal
        if self._state is None:
            self._state = [
                _settled(pair) * signal[0, axis] for axis, pair in enumerate(self._coefficients)
            ]
        filtered = signal.copy()
        for axis, pair in enumerate(self._coefficients):
            if pair is not None:
                filtered[:, axis], self._state[axis] = lfilter(
                    pair[0], pair[1], signal[:, axis], zi=self._state[axis]
                )
        return filtered


def _settled(pair: tuple[Array, Array] | None) -> Array:
    """The filter's state when a value of 1 has been there for ever (its gain is 1)."""
    return np.zeros(1) if pair is None else pair[0][1:] - pair[1][1:]


def _low_pass(cut_off: float, rate: float) -> tuple[Array, Array] | None:
    if not cut_off < _HIGHEST_CUT_OFF * rate:
        return None
    warped = math.tan(math.pi * cut_off / rate)
    gain = warped / (1.0 + warped)
    return np.array([gain, gain]), np.array([1.0, (warped - 1.0) / (warped + 1.0)])
