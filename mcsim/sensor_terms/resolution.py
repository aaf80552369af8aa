"""The step of a digital output."""

from mcsim.sensor_terms.mechanisms.digitise import QUANTISATION, Quantisation
from mcsim.sensor_terms.term import Key, Term

_KEYS = (Key("resolution", "{signal}", "Quantisation step.", role="step"),)

TERM = Term(QUANTISATION, Quantisation, _KEYS, _KEYS)
