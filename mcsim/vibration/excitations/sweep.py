"""A shaker that runs through frequencies."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import model_validator

from mcsim.scenario.fields import Acceleration, Frequency, NotNegative, Positive, reject
from mcsim.vibration.excitations.excitation import Array, Excitation, ExcitationBlock


class Sweep(ExcitationBlock):
    """A shaker that runs through frequencies at a constant amplitude of acceleration."""

    shape: Literal["sweep"]
    first: Annotated[Frequency, Positive]
    """Frequency at the start."""
    last: Annotated[Frequency, Positive]
    """Frequency at the end."""
    amplitude: Annotated[Acceleration, NotNegative]
    scale: Literal["linear", "log"] = "log"
    """How the frequency goes with time."""

    @model_validator(mode="after")
    def _goes_somewhere(self) -> Sweep:
        if self.first == self.last:
            raise reject("`first` and `last` are equal; a harmonic excitation does that")
        return self

    def cycles(self, time: Array, duration: float) -> Array:
        first, last = self.first, self.last
        if self.scale == "linear":
            return first * time + (last - first) * time**2 / (2.0 * duration)
        octaves = math.log(last / first)
        cycles: Array = first * duration / octaves * np.expm1(octaves * time / duration)
        return cycles


def _acceleration(block: Sweep, time: Array, duration: float) -> Array:
    signal: Array = block.amplitude * np.sin(2.0 * math.pi * block.cycles(time, duration))
    return signal


EXCITATION = Excitation("sweep", Sweep, _acceleration)
