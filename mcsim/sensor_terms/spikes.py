"""Outliers."""

from mcsim.sensor_terms.mechanisms.event import SPIKES, Event
from mcsim.sensor_terms.term import InnerBlock, SensorKey, SensorTerm

_KEYS = (
    SensorKey(
        "rate",
        "frequency",
        "Mean number per second and axis; a sample has one or none.",
        per_axis=False,
        scales=True,
    ),
    SensorKey(
        "amplitude", "{signal}", "What a spike adds or takes away.", per_axis=False, scales=True
    ),
)

TERM = SensorTerm(
    SPIKES, Event, _KEYS, _KEYS, InnerBlock("spikes", "Spikes", "Outliers of either sign.")
)
