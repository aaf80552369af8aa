"""The constant offset that is assumed to be left by a calibration."""

from mcsim.sensor_terms.mechanisms.offset import Offset
from mcsim.sensor_terms.term import Key, Term

_KEYS = (Key("miscalibration", "{signal}", "Standard deviation of the constant offset."),)


def _acts(miscalibration: float) -> Offset:
    return Offset(miscalibration, assumed=True)


TERM = Term("miscalibration", _acts, _KEYS, _KEYS)
