"""A scale factor that depends on the signal: the bend of the sensor's characteristic.

Data sheets print the largest deviation from the best straight line over plus and minus full
scale, in per cent of full scale.  Offset and scale factor are those at zero, so that an error of
second order is ``k x²`` and one of third order ``k x³``.  The straight line that is best for x²
over (-1, 1) leaves 1/2, the one for x³ leaves 1/4 (Chebyshev): so ``k`` is twice the share of full
scale over full scale, and four times it over full scale squared.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.shaped import Shaped
from mcsim.sensor_terms.term import InnerBlock, SensorKey, SensorTerm

Array = NDArray[np.float64]

_KEYS = (
    SensorKey(
        "deviation",
        "ratio",
        "Largest deviation from the best straight line, as a share of full scale, which has either "
        "sign: its standard deviation.",
        scales=True,
    ),
    SensorKey("full_scale", "{signal}", "Full scale, plus and minus.", positive=True),
)


def squared(signal: Array, temperature: Array) -> Array:  # noqa: ARG001
    """The course of an error of second order."""
    return np.asarray(signal * signal, float)


def cubed(signal: Array, temperature: Array) -> Array:  # noqa: ARG001
    """The course of an error of third order."""
    return np.asarray(signal * signal * signal, float)


def _second(deviation: float, full_scale: float) -> Shaped:
    return Shaped(2.0 * deviation / full_scale, squared)


def _third(deviation: float, full_scale: float) -> Shaped:
    return Shaped(4.0 * deviation / full_scale**2, cubed)


SECOND_ORDER = SensorTerm(
    "second-order non-linearity",
    _second,
    _KEYS,
    _KEYS,
    InnerBlock(
        "quadratic_nonlinearity",
        "QuadraticNonlinearity",
        "Non-linearity of second order: even, so that vibration shows as a bias.",
    ),
)
THIRD_ORDER = SensorTerm(
    "third-order non-linearity",
    _third,
    _KEYS,
    _KEYS,
    InnerBlock(
        "cubic_nonlinearity",
        "CubicNonlinearity",
        "Non-linearity of third order: odd, as of a sensor that yields near its limits.",
    ),
)
