"""Scenarios of the planar case."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from mcsim.scenario.block import Block
from mcsim.scenario.case import CaseScenario
from mcsim.scenario.error_names import ErrorName
from mcsim.scenario.fields import Angle, NotNegative, Speed
from mcsim.scenario.rules import PlanarRule
from mcsim.scenario.sensors import Sensors
from mcsim.scenario.tracks import Recorded, Trajectory


class Reconstruction(Block):
    """How the sensor data are integrated."""

    integration: PlanarRule = "rectangular"
    """`rectangular` is the paper's way; `trapezoidal` is of second order; or a rule of your own."""


class Initial(Block):
    """Standard deviations of the errors of the state at the first sample."""

    speed_error: Annotated[Speed, NotNegative] = 0.0
    direction_error: Annotated[Angle, NotNegative] = 0.0
    """Turns heading and course together."""
    heading_error: Annotated[Angle, NotNegative] = 0.0
    """Turns the heading alone."""
    course_error: Annotated[Angle, NotNegative] = 0.0
    """Turns the velocity vector alone."""


class PlanarScenario(CaseScenario):
    """2-D dead reckoning from two accelerometer axes and one gyroscope."""

    ERRORS: ClassVar[tuple[ErrorName, ...]] = ("along", "across", "position", "heading", "course")
    DRAWN: ClassVar[tuple[ErrorName, ...]] = ("along", "across", "heading", "course")

    case: Literal["planar"]
    trajectory: Trajectory
    sensors: Sensors
    reconstruction: Reconstruction = Reconstruction()
    initial: Initial = Initial()

    @property
    def files(self) -> tuple[str, ...]:
        drives = (self.trajectory.file,) if isinstance(self.trajectory, Recorded) else ()
        return (*drives, *self.sensors.files)
