"""Rare events of a sample: spikes of either sign."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.mechanism import Mechanism, stream

Array = NDArray[np.float64]

#: Its name in budgets.
SPIKES = "spikes"
#: The kernels draw 31 bits for each sample.
_WORDS = 2.0**31


@dataclass(frozen=True)
class Event(Mechanism):
    """A sample has one spike or none: with the probability ``rate`` times interval, at most one.

    So the mean number per second is what is written, whatever the sampling rate, and no spike is
    higher than ``amplitude``.  Counts after Poisson would put spikes of twice and three times
    that into a sample, which no source of outliers tells of.
    """

    rate: float = 0.0
    amplitude: float = 0.0
    alone: ClassVar[bool] = True


def probability(rates: Array, interval: float) -> Array:
    """Probability (c,) that a sample has a spike."""
    return np.minimum(rates * interval, 1.0)


def thresholds_of(probabilities: Array) -> NDArray[np.uint32]:
    """What the kernels compare a random word of 31 bits with."""
    return np.round(probabilities * _WORDS).astype(np.uint32)


def drawn_probability(thresholds: NDArray[np.uint32]) -> Array:
    """The probabilities that the kernels really draw."""
    return np.asarray(thresholds * 2.0**-31)


def spikes(rates: Array, amplitudes: Array, interval: float, seed: int) -> Callable[[int], Array]:
    """Spikes of a simulated log: the next n samples (n, c) at each call."""
    limits = probability(rates, interval)
    when, which = stream(seed, SPIKES, 0), stream(seed, SPIKES, 1)

    def take(count: int) -> Array:
        shape = (count, len(rates))
        up = np.where(which.random(shape) < 0.5, -amplitudes, amplitudes)
        return np.where(when.random(shape) < limits, up, 0.0)

    return take


def variance(squared_weights: Array, probability: float, amplitude: float) -> Array:
    """Variance (e,) of errors with these sums (e,) of the samples' squared weights."""
    return np.asarray(squared_weights * probability * amplitude**2)


def with_spikes(white: float, per_sample: float, amplitude: float) -> float:
    """Deviation of all that a sensor adds anew to every sample: white noise and spikes."""
    share = min(per_sample, 1.0) * amplitude**2
    return white if share == 0.0 else math.sqrt(white**2 + share)


def equal_events(weights: Array, probabilities: Array, amplitudes: Array) -> Array:
    """How many spikes of equal weight a realization has on average, per error (e,).

    A sum of spikes with weights w has the variance ``V = sum p (w a)^2`` and the fourth
    cumulant ``C = sum p (w a)^4``; as many equal ones as ``V^2 / C`` have the same.
    """
    heights = weights * amplitudes
    second = np.sum(probabilities * heights**2, axis=(1, 2))
    fourth = np.sum(probabilities * heights**4, axis=(1, 2))
    return np.divide(second**2, fourth, out=np.zeros(len(weights)), where=fourth > 0.0)
