"""Where a sensor saturates."""

from mcsim.sensor_terms.mechanisms.digitise import Saturation
from mcsim.sensor_terms.term import Key, Term

_KEYS = (Key("range", "{signal}", "Saturation, plus and minus.", role="largest", positive=True),)

TERM = Term("range", Saturation, _KEYS, _KEYS)
