"""What a temperature other than that of the calibration does to offset and scale factor.

Both act by the temperature's difference from that of the calibration, whose course scenarios
write in a block ``temperature``; without one they have no effect.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.shaped import Shaped
from mcsim.sensor_terms.term import SensorKey, SensorTerm

Array = NDArray[np.float64]

_OFFSET = (
    SensorKey(
        "temperature_offset",
        "{signal} per kelvin",
        "Offset per kelvin of difference from the temperature of calibration: its standard "
        "deviation.",
    ),
)
_SCALE = (
    SensorKey(
        "temperature_scale",
        "ratio per kelvin",
        "Scale factor error per kelvin of difference from the temperature of calibration: its "
        "standard deviation.",
    ),
)


def warmed(signal: Array, temperature: Array) -> Array:  # noqa: ARG001
    """The course of an offset that goes with the temperature."""
    return temperature


def warmed_signal(signal: Array, temperature: Array) -> Array:
    """The course of a scale factor that goes with the temperature."""
    return np.asarray(temperature * signal, float)


def _offset(temperature_offset: float) -> Shaped:
    return Shaped(temperature_offset, warmed)


def _scale(temperature_scale: float) -> Shaped:
    return Shaped(temperature_scale, warmed_signal)


OFFSET = SensorTerm("temperature offset", _offset, _OFFSET, _OFFSET)
SCALE = SensorTerm("temperature scale factor", _scale, _SCALE, _SCALE)
#: Terms that need a temperature.
TERMS = (OFFSET, SCALE)
