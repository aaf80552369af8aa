"""Axes that are not at right angles, or not where they should be."""

from mcsim.sensor_terms.mechanisms.mixing import Coefficient, Source
from mcsim.sensor_terms.term import SensorKey, SensorTerm

_KEYS = (
    SensorKey(
        "misalignment",
        "angle",
        "Standard deviation of the angles between the axes. Gravity shows by them in the level "
        "axes, in the planar case as well.",
    ),
)


def _acts(misalignment: float) -> Coefficient:
    return Coefficient(misalignment, Source.OTHER_AXES)


TERM = SensorTerm("misalignment", _acts, _KEYS, _KEYS)
