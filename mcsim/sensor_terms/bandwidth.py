"""A sensor that answers late and not to everything."""

from mcsim.sensor_terms.mechanisms.low_pass import LowPass
from mcsim.sensor_terms.term import Key, Term

_KEYS = (Key("bandwidth", "frequency", "First-order low-pass, -3 dB.", positive=True),)

TERM = Term("bandwidth", LowPass, _KEYS, _KEYS)
