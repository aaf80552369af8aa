"""A proof mass on a spring: second-order dynamics with a resonance."""

from mcsim.sensor_terms.mechanisms.resonance import Resonance
from mcsim.sensor_terms.term import InnerBlock, SensorKey, SensorTerm

_KEYS = (
    SensorKey(
        "natural_frequency",
        "frequency",
        "Frequency of the undamped mass on its spring.",
        positive=True,
    ),
    SensorKey(
        "damping",
        "ratio",
        "Share of the critical damping: the gain at the natural frequency is 1/(2 damping).",
        positive=True,
    ),
)

TERM = SensorTerm(
    "resonance",
    Resonance,
    _KEYS,
    _KEYS,
    InnerBlock("resonance", "Resonance", "Second-order dynamics of mass, spring and damper."),
)
