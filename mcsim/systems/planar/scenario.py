"""Scenarios of the planar case."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import model_validator

from mcsim.scenario.block import Block
from mcsim.scenario.case import CaseScenario
from mcsim.scenario.fields import reject
from mcsim.scenario.initial import Initial
from mcsim.scenario.rules import Rules
from mcsim.scenario.sample_times import Intervals
from mcsim.scenario.sensors import Sensors
from mcsim.tracks import Trajectory

RULES = Rules("rectangular", "trapezoidal", "cubic")
Rule = Annotated[str, RULES.checked(), RULES.listed()]


class Reconstruction(Block):
    """How the sensor data are integrated."""

    integration: Rule = "rectangular"
    """What happens between samples. `rectangular`, the paper's way, holds each sample for its
    interval; `trapezoidal` takes straight lines (second order); `cubic` interpolates by cubics
    through four neighbours (fourth order where the signals are smooth), and knows an interval one
    sample later; or a rule of your own."""
    intervals: Intervals = "measured"
    """The time between two samples: by their time stamps, or the nominal one, whatever they say."""


class PlanarScenario(CaseScenario):
    """2-D dead reckoning from two accelerometer axes and one gyroscope."""

    ERRORS: ClassVar[tuple[str, ...]] = ("along", "across", "position", "heading", "course")
    DRAWN: ClassVar[tuple[str, ...]] = ("along", "across", "heading", "course")

    case: Literal["planar"]
    trajectory: Trajectory
    sensors: Sensors
    reconstruction: Reconstruction = Reconstruction()
    initial: Initial = Initial()

    @model_validator(mode="after")
    def _momentary_values_are_interpolated(self) -> PlanarScenario:
        if self.reconstruction.integration == "cubic" and self.sensors.sampling == "average":
            raise reject(
                "cubics go through momentary values, and `sampling: average` gives means over "
                "intervals, whose sums need none; write `integration: trapezoidal`, or "
                "`sampling: fir`, `iir` or `none`"
            )
        return self

    @model_validator(mode="after")
    def _cubics_are_even(self) -> PlanarScenario:
        if self.reconstruction.integration == "cubic" and self.sensors.time.varies:
            raise reject(
                "the cubics of `integration: cubic` go through evenly spaced samples; with "
                "`sensors.time` write `integration: trapezoidal`"
            )
        return self

    @property
    def files(self) -> tuple[str, ...]:
        return (*self.trajectory.files, *self.sensors.files)
