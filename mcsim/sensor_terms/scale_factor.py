"""The scale factor's error: a share of the channel's own signal."""

from mcsim.sensor_terms.mechanisms.mixing import Coefficient, Source
from mcsim.sensor_terms.term import SensorKey, SensorTerm

_KEYS = (SensorKey("scale_factor_error", "ratio", "Standard deviation of the scale factor error."),)


def _acts(scale_factor_error: float) -> Coefficient:
    return Coefficient(scale_factor_error, Source.ITSELF)


TERM = SensorTerm("scale factor", _acts, _KEYS, _KEYS)
