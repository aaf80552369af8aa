"""Scale factors that differ between positive and negative signals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.shaped import Shaped
from mcsim.sensor_terms.term import SensorKey, SensorTerm

Array = NDArray[np.float64]

_KEYS = (
    SensorKey(
        "scale_factor_asymmetry",
        "ratio",
        "Scale factor of positive signals less that of negative ones: its standard deviation.",
    ),
)


def amount(signal: Array, temperature: Array) -> Array:  # noqa: ARG001
    """The course of an error that has one sign for both directions."""
    return np.abs(signal)


def _acts(scale_factor_asymmetry: float) -> Shaped:
    return Shaped(0.5 * scale_factor_asymmetry, amount)


TERM = SensorTerm("scale factor asymmetry", _acts, _KEYS, _KEYS)
