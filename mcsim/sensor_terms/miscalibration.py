"""The constant offset that is assumed to be left by a calibration."""

from mcsim.sensor_terms.mechanisms.offset import Offset
from mcsim.sensor_terms.term import SensorKey, SensorTerm

_KEYS = (SensorKey("miscalibration", "{signal}", "Standard deviation of the constant offset."),)


def _acts(miscalibration: float) -> Offset:
    return Offset(miscalibration, assumed=True)


TERM = SensorTerm("miscalibration", _acts, _KEYS, _KEYS)
