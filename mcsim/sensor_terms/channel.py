"""The channels of a sensor: each element has up to three axes."""

from __future__ import annotations

from dataclasses import dataclass

ACCELEROMETER, GYROSCOPE = "accelerometer", "gyroscope"
#: What each element measures.
SIGNALS = {ACCELEROMETER: "acceleration", GYROSCOPE: "angular rate"}


@dataclass(frozen=True)
class Channel:
    """A measured channel: its element and its axis (0, 1, 2 for x, y, z)."""

    element: str
    axis: int
