"""A bias that wanders without end."""

from __future__ import annotations

from collections.abc import Sequence

from mcsim.sensor_terms.mechanisms.process import FirstOrder, Process, random_walk
from mcsim.sensor_terms.term import SensorKey, SensorTerm


def walk(intensity: float) -> Process:
    """Brownian motion of Allan's K."""

    def parts(interval: float, _: float) -> Sequence[FirstOrder]:
        return [random_walk(intensity, interval)] if intensity > 0.0 else ()

    return Process(parts)


TERM = SensorTerm(
    "random walk",
    walk,
    (
        SensorKey(
            "acceleration_random_walk",
            "acceleration random walk",
            "Allan's K.",
            role="intensity",
        ),
    ),
    (SensorKey("rate_random_walk", "rate random walk", "Allan's K.", role="intensity"),),
)
