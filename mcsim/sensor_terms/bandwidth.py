"""A sensor that answers late and not to everything."""

from mcsim.sensor_terms.mechanisms.low_pass import LowPass
from mcsim.sensor_terms.term import SensorKey, SensorTerm

_KEYS = (SensorKey("bandwidth", "frequency", "First-order low-pass, -3 dB.", positive=True),)

TERM = SensorTerm("bandwidth", LowPass, _KEYS, _KEYS)
