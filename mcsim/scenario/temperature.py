"""The temperature of the sensors over time, as its difference from that of their calibration."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from mcsim.scenario.block import Block
from mcsim.scenario.fields import (
    NotNegative,
    Positive,
    TemperatureDifference,
    TemperatureRate,
    Time,
    reject,
)

Array = NDArray[np.float64]


class TemperaturePoint(Block):
    """A point of the temperature's course."""

    time: Annotated[Time, NotNegative]
    """Since the sensors were switched on."""
    difference: TemperatureDifference


class Temperature(Block):
    """Temperature of the sensors less that at which they were calibrated; its parts add up.

    Time counts from when the sensors are switched on, and before the run they may have been on:
    the first rest before it begins (or, without one, the run itself) when they have been
    `on_before`.
    """

    difference: TemperatureDifference = 0.0
    """Constant part, positive where they are warmer."""
    ramp: TemperatureRate = 0.0
    """Rise with time since they were switched on."""
    warm_up: TemperatureDifference = 0.0
    """What they warm up by in the end, by their own power."""
    time_constant: Annotated[Time, Positive] | None = None
    """Time after which the warm-up has done all but 1/e."""
    points: Annotated[list[TemperaturePoint], Field(min_length=2, max_length=10_000)] | None = None
    """Points with straight lines between them, constant before the first and after the last."""
    on_before: Annotated[Time, NotNegative] = 0.0
    """How long the sensors have been on when the first rest begins, or the run without one."""

    @model_validator(mode="after")
    def _whole(self) -> Temperature:
        if self.warm_up != 0.0 and self.time_constant is None:
            raise reject("a `warm_up` needs its `time_constant`, such as 5 min")
        if any(b.time <= a.time for a, b in pairwise(self.points or ())):
            raise reject("the times of `points` must rise from one to the next")
        return self

    @property
    def changes(self) -> bool:
        """Whether it is not the same all the time."""
        return bool(self.ramp or self.warm_up or self.points)

    def at(self, times: Array) -> Array:
        """Differences (n,) in K at ``times`` (n,) since the first rest began, or the run."""
        on = self.on_before + np.asarray(times, float)
        total = self.difference + self.ramp * on
        if self.time_constant is not None:
            total = total - self.warm_up * np.expm1(-on / self.time_constant)
        if self.points:
            known = [point.time for point in self.points]
            total = total + np.interp(on, known, [point.difference for point in self.points])
        return np.asarray(total, float)
