"""Scenarios of the strapdown case."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from annotated_types import Ge, Le
from pydantic import model_validator

from mcsim.scenario.block import Block
from mcsim.scenario.case import CaseScenario
from mcsim.scenario.fields import (
    Acceleration,
    Angle,
    NotNegative,
    Positive,
    Time,
    reject,
)
from mcsim.scenario.initial import Initial
from mcsim.scenario.place import Place
from mcsim.scenario.response import Response
from mcsim.scenario.rules import Rules
from mcsim.scenario.sensors import Sensors
from mcsim.tracks import Trajectory
from mcsim.units import STANDARD_GRAVITY

RULES = Rules("rectangular", "forward_euler", "trapezoidal", "two_sample")
Rule = Annotated[str, RULES.checked(), RULES.listed()]
_STEEPEST = 0.8


class Body(Place):
    """Attitude of the vehicle's body: the road's plane, and how the body leans in it.

    Roll is positive with the left side up, pitch with the nose down (ISO 8855).
    """

    VALUE: ClassVar[str] = "gravity"

    bank: Annotated[Angle, Ge(-_STEEPEST), Le(_STEEPEST)] = 0.0
    """Slope of the road's plane across its initial direction, left side up positive."""
    grade: Annotated[Angle, Ge(-_STEEPEST), Le(_STEEPEST)] = 0.0
    """Slope of the road's plane in its initial direction, uphill positive."""
    roll: Response = Response()
    """Outwards under leftward acceleration, to which gravity adds on a bank."""
    pitch: Response = Response()
    """Nose down under deceleration, to which gravity adds on a grade."""
    gravity: Annotated[Acceleration, Positive, Le(30.0)] = STANDARD_GRAVITY
    """Local gravity."""


class StrapdownReconstruction(Block):
    """How the sensor data are integrated."""

    algorithm: Literal["strapdown", "planar"] = "strapdown"
    """`strapdown` uses all six channels; `planar` takes three and the vehicle for level."""
    integration: Rule = "rectangular"
    """`rectangular`: attitude, velocity, position, each from the new one before, as in the
    planar case; `forward_euler`: the application note's recursion; `trapezoidal`: second
    order; `two_sample`: second order with coning and sculling corrections; or a rule of your
    own."""

    @model_validator(mode="after")
    def _planar_integrates_its_own_way(self) -> StrapdownReconstruction:
        if self.algorithm == "planar" and self.integration not in ("rectangular", "trapezoidal"):
            raise reject(
                f"the planar algorithm has no integration `{self.integration}`; "
                "write `rectangular` or `trapezoidal`"
            )
        return self


class Levelling(Block):
    """Initial roll and pitch from the mean specific force of a vehicle at rest.

    The mean holds all that stands in the accelerometers' output meanwhile: offsets, gravity
    by misalignment, in-run noise that goes on in the drive, what a calibration (which comes
    before) has left, spikes, quantisation and saturation.
    """

    duration: Annotated[Time, Positive, Le(86_400.0)]
    """How long the vehicle stands before the drive, in the attitude of the first sample."""


class StrapdownInitial(Initial):
    """Standard deviations of the errors of the state at the first sample."""

    tilt_error: Annotated[Angle, NotNegative] = 0.0
    """Of roll and of pitch, independently. For the planar algorithm it is the tilt of a vehicle
    that is taken for level."""
    roll_error: Annotated[Angle, NotNegative] = 0.0
    """Of the roll alone."""
    pitch_error: Annotated[Angle, NotNegative] = 0.0
    """Of the pitch alone."""
    levelling: Levelling | None = None
    """Takes roll and pitch from the accelerometers at rest: their offsets then tilt the
    attitude; the errors above come on top."""


class StrapdownScenario(CaseScenario):
    """3-D dead reckoning from three accelerometer axes and three gyroscopes."""

    ERRORS: ClassVar[tuple[str, ...]] = (
        "along",
        "across",
        "height",
        "position",
        "roll",
        "pitch",
        "heading",
        "course",
    )
    DRAWN: ClassVar[tuple[str, ...]] = (
        "along",
        "across",
        "height",
        "roll",
        "pitch",
        "heading",
    )

    case: Literal["strapdown"]
    trajectory: Trajectory
    body: Body = Body()
    sensors: Sensors
    reconstruction: StrapdownReconstruction = StrapdownReconstruction()
    initial: StrapdownInitial = StrapdownInitial()

    @model_validator(mode="after")
    def _own_rules_level_themselves(self) -> StrapdownScenario:
        if self.initial.levelling and self.reconstruction.integration not in RULES.shipped:
            raise reject(
                "levelling before the drive is for the shipped rules; leave `initial.levelling` "
                "out, or let the rule level itself while it runs"
            )
        return self

    @model_validator(mode="after")
    def _levels_by_gravity(self) -> StrapdownScenario:
        if self.initial.levelling and self.sensors.accelerometer.ac_coupled:
            raise reject(
                "behind an `ac_coupling` no gravity is left to level by; remove it, or write "
                "`initial.tilt_error` instead of `initial.levelling`"
            )
        return self

    @model_validator(mode="after")
    def _one_attitude(self) -> StrapdownScenario:
        if not self.records_attitude:
            return self
        body = self.body
        if body.bank or body.grade or body.roll.gradient or body.pitch.gradient:
            raise reject(
                "the record has roll and pitch columns: leave bank, grade and gradients out "
                "of `body`, or the columns out of `trajectory`"
            )
        return self

    @property
    def records_attitude(self) -> bool:
        """Whether roll and pitch come from the recorded track."""
        return self.trajectory.has_attitude

    @property
    def files(self) -> tuple[str, ...]:
        return (*self.trajectory.files, *self.sensors.files)
