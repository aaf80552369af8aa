"""Where a sensor saturates."""

from mcsim.sensor_terms.mechanisms.digitise import Saturation
from mcsim.sensor_terms.term import SensorKey, SensorTerm

_KEYS = (
    SensorKey("range", "{signal}", "Saturation, plus and minus.", role="largest", positive=True),
)

TERM = SensorTerm("range", Saturation, _KEYS, _KEYS)
