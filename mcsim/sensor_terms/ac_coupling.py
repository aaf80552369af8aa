"""A sensor that passes nothing constant, as piezo-electric ones."""

from mcsim.sensor_terms.mechanisms.high_pass import HighPass
from mcsim.sensor_terms.term import SensorKey, SensorTerm

_KEYS = (
    SensorKey(
        "ac_coupling",
        "frequency",
        "First-order high-pass, -3 dB: gravity and steady accelerations vanish behind it.",
        role="corner",
    ),
)

TERM = SensorTerm("AC coupling", HighPass, _KEYS, _KEYS)
