"""A constant offset per channel, drawn once per realization (at each turn-on)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.mechanism import Mechanism, stream

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Offset(Mechanism):
    """Normal with mean zero.

    A calibration at rest takes it away, with everything else that is constant there.  What is
    ``assumed`` to be left by one cannot stand beside a calibration that is simulated.
    """

    deviation: float
    assumed: bool = False


def together(deviations: Mapping[str, Array], channels: int) -> Array:
    """Standard deviation (c,) of all offsets together, from those (c,) of each term."""
    total = np.zeros(channels)
    for own in deviations.values():
        total = np.hypot(total, own)
    return total


def drawn(deviations: Mapping[str, Array], channels: int, seed: int) -> Array:
    """Offsets (c,) of a simulated log."""
    total = np.zeros(channels)
    for name, own in deviations.items():
        total += own * stream(seed, name).standard_normal(channels)
    return total


def variance(weights: Array, deviation: float) -> Array:
    """Variance (e,) of errors that have these ``weights`` (e,) per offset."""
    return np.asarray(weights**2 * deviation**2)
