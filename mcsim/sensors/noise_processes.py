"""Coloured noise and the low-pass of a sensor element, in pieces of any size.

A process gives the same values however they are taken: all at once or piece by piece.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Ratio of neighbouring correlation times of flicker noise; the spectrum of the sum ripples
#: by ±0.3 % about 1/f.
FLICKER_RATIO = 4.0
#: Shortest correlation time in sample intervals, longest in lengths of the log: what lies
#: beyond hardly changes the Allan deviation in between.
_SHORTEST, _LONGEST = 0.5, 10.0
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
    """Noise of two-sided density ``(B²/2π)/f``: Gauss-Markov processes of equal variance.

    Their correlation times ``T0 r^k`` reach from below the sample interval to beyond the log;
    each has the variance ``B² ln(r) / π``.
    """

    def __init__(
        self, instability: Array, step: float, duration: float, random: np.random.Generator
    ) -> None:
        times = flicker_times(step, duration)
        deviation = instability * math.sqrt(math.log(FLICKER_RATIO) / math.pi)
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


def flicker_times(step: float, duration: float) -> Array:
    """Correlation times (s) of the processes that make up flicker noise over ``duration``."""
    shortest, longest = _SHORTEST * step, _LONGEST * max(duration, step)
    count = math.ceil(math.log(longest / shortest) / math.log(FLICKER_RATIO)) + 1
    times: Array = shortest * FLICKER_RATIO ** np.arange(count, dtype=float)
    return times


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
