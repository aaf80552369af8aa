"""The base of what a sensor's mechanics and electronics filter out of the true signal.

A filter acts on the true signal, in the same way in every realization.  It is exact for a
signal that is linear between its dense samples; several act one after the other, each on
what the one before gives at the dense samples.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.mechanism import Acts, Mechanism

Array = NDArray[np.float64]


class LinearFilter(Mechanism):
    """A linear filter between the ideal signal and the samples."""

    @property
    def acts(self) -> bool:
        """Whether it changes anything."""
        return True

    @property
    def fastest(self) -> float:
        """The highest frequency (Hz) of its own, which dense samples must hold."""
        raise NotImplementedError

    def settled(self, value: float, rate: float) -> Array:
        """The state at ``rate`` (Hz) when ``value`` has been there for ever."""
        raise NotImplementedError

    def apply(self, signal: Array, state: Array, rate: float) -> tuple[Array, Array]:
        """Filtered (n,) and the state after it, from the ``state`` before."""
        raise NotImplementedError

    def over_intervals(
        self, dense: Array, means: Array, rest: float, rate: float
    ) -> tuple[Array, Array]:
        """Filtered dense values (n, k + 1) and means (n,) over n intervals, from a settled start.

        ``dense`` are k + 1 values in each interval, its ends included, at ``rate`` (Hz): from one
        interval to the next the signal may jump.  ``rest`` was there for ever before.
        """
        raise NotImplementedError

    def passed(self, value: float) -> float:
        """What is left of a value that has been there for ever."""
        return value


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

    def over_intervals(self, dense: Array, rest: float) -> Array:
        """Filtered values (n, k + 1) of ``dense`` ones in n intervals, settled at ``rest``."""
        from scipy.signal import lfilter

        pushes = self.old * dense[:, :-1] + self.new * dense[:, 1:]
        states, _ = lfilter([1.0], [1.0, -self.decay], pushes.ravel(), zi=[self.decay * rest])
        return in_intervals(np.append(rest, states), len(dense))


def in_intervals(values: Array, count: int) -> Array:
    """Values (n k + 1,) of a signal that does not jump, as (n, k + 1) with both ends of each."""
    steps = (len(values) - 1) // count
    windows = np.lib.stride_tricks.sliding_window_view(values, steps + 1)
    return np.asarray(windows[::steps])


Filters = tuple[LinearFilter, ...]


def filters_of(acts: Acts) -> Filters:
    """The filters of one channel, in the order of their terms."""
    return tuple(act for act in acts.values() if isinstance(act, LinearFilter) and act.acts)


def filtered(signal: Array, filters: Sequence[LinearFilter], rate: float) -> Array:
    """A signal (n,) behind filters that have settled at its first value."""
    for one in filters:
        signal = one.apply(signal, one.settled(signal[0], rate), rate)[0]
    return signal


def passed(value: float, filters: Sequence[LinearFilter]) -> float:
    """What is left of a constant behind filters."""
    for one in filters:
        value = one.passed(value)
    return value


def log_filter(filters: Sequence[Filters], rate: float) -> Callable[[Array], Array]:
    """The filters of a simulated log: the next n samples (n, s) at ``rate`` (Hz) at each call.

    Columns without filters, and those beyond ``filters``, pass unchanged.
    """
    states: dict[tuple[int, int], Array] = {}

    def take(signals: Array) -> Array:
        if not any(filters) or not len(signals):
            return signals
        through = signals.copy()
        for k, own in enumerate(filters):
            for number, one in enumerate(own):
                place = (k, number)
                state = states.get(place)
                if state is None:
                    state = one.settled(through[0, k], rate)
                through[:, k], states[place] = one.apply(through[:, k], state, rate)
        return through

    return take
