"""The step of a digital output."""

from mcsim.sensor_terms.mechanisms.digitise import QUANTISATION, Quantisation
from mcsim.sensor_terms.term import SensorKey, SensorTerm

_KEYS = (SensorKey("resolution", "{signal}", "Quantisation step.", role="step"),)

TERM = SensorTerm(QUANTISATION, Quantisation, _KEYS, _KEYS)
