"""The bias that is another at each turn-on."""

from mcsim.sensor_terms.mechanisms.offset import Offset
from mcsim.sensor_terms.term import SensorKey, SensorTerm

_KEYS = (
    SensorKey(
        "turn_on_bias",
        "{signal}",
        "Standard deviation of the bias drawn at each turn-on.",
        role="deviation",
    ),
)

TERM = SensorTerm("turn-on bias", Offset, _KEYS, _KEYS)
