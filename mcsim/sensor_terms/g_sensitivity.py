"""What an acceleration makes of a gyroscope's output."""

from mcsim.sensor_terms.mechanisms.mixing import Coefficient, Source
from mcsim.sensor_terms.term import SensorKey, SensorTerm


def _acts(g_sensitivity: float) -> Coefficient:
    return Coefficient(g_sensitivity, Source.SPECIFIC_FORCE)


TERM = SensorTerm(
    "g-sensitivity",
    _acts,
    gyroscope=(
        SensorKey(
            "g_sensitivity",
            "g-sensitivity",
            "Standard deviation of the bias that an acceleration brings.",
        ),
    ),
)
