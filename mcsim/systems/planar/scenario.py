"""Scenarios of the planar case."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from mcsim.scenario.block import Block
from mcsim.scenario.case import CaseScenario
from mcsim.scenario.initial import Initial
from mcsim.scenario.rules import Rules
from mcsim.scenario.sample_times import Intervals
from mcsim.scenario.sensors import Sensors
from mcsim.tracks import Trajectory

RULES = Rules("rectangular", "trapezoidal")
Rule = Annotated[str, RULES.checked(), RULES.listed()]


class Reconstruction(Block):
    """How the sensor data are integrated."""

    integration: Rule = "rectangular"
    """`rectangular` is the paper's way; `trapezoidal` is of second order; or a rule of your own."""
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

    @property
    def files(self) -> tuple[str, ...]:
        return (*self.trajectory.files, *self.sensors.files)
