"""What a log is, whatever file it came from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ACCELEROMETER, GYROSCOPE = "accelerometer", "gyroscope"
AXES = ("x", "y", "z")
#: Names of channels, in the order of all outputs.
SHORT = {ACCELEROMETER: "accel", GYROSCOPE: "gyro"}
#: Kinds of quantity (``mcsim.units``) of the samples.
KIND = {ACCELEROMETER: "acceleration", GYROSCOPE: "angular rate"}


@dataclass(frozen=True)
class ReadOptions:
    """What the file itself does not say.

    ``rate`` in Hz, ``columns`` and ``units`` as the command line takes them, ``topic``
    of a bag, ``start`` and ``end`` in s from the first sample.
    """

    rate: float | None = None
    columns: str | None = None
    units: str | None = None
    topic: str | None = None
    start: float | None = None
    end: float | None = None


@dataclass(frozen=True)
class Channel:
    """Samples (n,) of one axis in SI units (m/s² or rad/s)."""

    element: str
    axis: str
    samples: Array

    @property
    def name(self) -> str:
        """``accel_x`` … ``gyro_z``."""
        return f"{SHORT[self.element]}_{self.axis}"


@dataclass(frozen=True)
class Timing:
    """What the time stamps say; without stamps the stated rate alone.

    ``rate`` in Hz; ``jitter`` is the standard deviation of the intervals as a part of
    their mean; ``notes`` are sentences for the reader, ``doubt`` one about the rate.
    """

    rate: float
    stamped: bool
    duplicates: int = 0
    missing: int = 0
    jitter: float = 0.0
    notes: tuple[str, ...] = ()
    doubt: str = ""


@dataclass(frozen=True)
class Log:
    """Equally spaced samples of up to six channels, all of the same length.

    ``notes`` say what is doubtful about the log, ``remarks`` how it was read.
    """

    path: Path
    channels: tuple[Channel, ...]
    timing: Timing
    notes: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def rate(self) -> float:
        """Samples per second."""
        return self.timing.rate

    @property
    def duration(self) -> float:
        """Length in s."""
        return len(self.channels[0].samples) / self.timing.rate
