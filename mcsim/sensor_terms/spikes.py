"""Outliers."""

from mcsim.sensor_terms.mechanisms.event import SPIKES, Event
from mcsim.sensor_terms.term import Inner, Key, Term

_KEYS = (
    Key(
        "rate",
        "frequency",
        "Mean number per second and axis; a sample has one or none.",
        per_axis=False,
    ),
    Key("amplitude", "{signal}", "What a spike adds or takes away.", per_axis=False),
)

TERM = Term(SPIKES, Event, _KEYS, _KEYS, Inner("spikes", "Spikes", "Outliers of either sign."))
