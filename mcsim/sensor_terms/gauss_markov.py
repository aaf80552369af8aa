"""A drift that forgets: a first-order Gauss-Markov process."""

from __future__ import annotations

from collections.abc import Sequence

from mcsim.sensor_terms.mechanisms.process import FirstOrder, Process, gauss_markov
from mcsim.sensor_terms.term import InnerBlock, SensorKey, SensorTerm

_KEYS = (
    SensorKey("deviation", "{signal}", "Standard deviation of the process.", scales=True),
    SensorKey(
        "correlation_time",
        "time",
        "Time after which the autocorrelation has fallen to 1/e.",
        positive=True,
    ),
)


def drift(deviation: float, correlation_time: float) -> Process:
    """A process of that standard deviation, and time (s) after which it has fallen to 1/e."""

    def parts(interval: float, _: float) -> Sequence[FirstOrder]:
        return [gauss_markov(deviation**2, correlation_time, interval)] if deviation > 0.0 else ()

    return Process(parts)


TERM = SensorTerm(
    "Gauss-Markov drift",
    drift,
    _KEYS,
    _KEYS,
    InnerBlock(
        "gauss_markov",
        "Process",
        "A first-order Gauss-Markov process, in its stationary state.",
    ),
)
