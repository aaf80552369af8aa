"""Scenarios of the velocity case."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from annotated_types import Ge, Le, Len
from pydantic import FiniteFloat, ModelWrapValidatorHandler, field_validator, model_validator

from mcsim.scenario.block import Block, Whole
from mcsim.scenario.case import CaseScenario
from mcsim.scenario.error_quantities import ErrorRow
from mcsim.scenario.fields import (
    Acceleration,
    Angle,
    Frequency,
    Length,
    NotNegative,
    Positive,
    Ratio,
    SensorOutput,
    Time,
    reject,
)
from mcsim.scenario.named_sensor import ReckoningAccelerometer
from mcsim.scenario.place import Place
from mcsim.scenario.response import Response
from mcsim.scenario.run import Outputs
from mcsim.scenario.sensor_block import NOISE_KEYS, AccelerometerErrors, is_file
from mcsim.scenario.temperature import Temperature
from mcsim.systems.velocity.profiles import StraightRun
from mcsim.systems.velocity.profiles.profile import LONGEST

#: Rows of the source's budget tables.
BUDGET_ROWS = 26
#: Bounds of what a correction of a sensor that works may hold: factors, and biases (g).
_LARGEST_FACTOR, _LARGEST_BIAS = 100.0, 1000.0
#: Gravity (m/s²) from small bodies to large ones; accelerations in fractions of it stay finite.
_GRAVITY = (0.01, 1000.0)
#: The largest angle of a vehicle's tilt (rad), and distance of a sensor from its pitch axis (m).
_LARGEST_ANGLE, _HIGHEST = 1.5, 100.0
#: Full scale and amplitudes of a shaker test (g).
_SHAKEN = (1e-3, 1e6)


class PitchingBody(Block):
    """How the vehicle's body pitches while it drives and brakes; nobody measures it."""

    pitch: Response = Response()
    """Nose up under driving and down under braking: gravity then shows on the axis x."""
    height: Annotated[Length, Ge(-_HIGHEST), Le(_HIGHEST)] = 0.0
    """Of the sensor above the axis about which the body pitches. Its own swing, backwards while
    the nose rises, is measured, and is an error against the velocity of the wheels."""

    @model_validator(mode="after")
    def _swings_smoothly(self) -> PitchingBody:
        if self.height != 0.0 and self.pitch.gradient and self.pitch.natural_frequency == 0.0:
            raise reject(
                "a body that follows at once swings a sensor at a `height` by jerks; give "
                "`pitch.natural_frequency`"
            )
        return self


class Axes(Block):
    """A value for each sensor axis."""

    x: Annotated[SensorOutput, NotNegative]
    y: Annotated[SensorOutput, NotNegative]
    z: Annotated[SensorOutput, NotNegative]


class Output(Block):
    """Raw output of the three axes, in fractions of g."""

    x: SensorOutput
    y: SensorOutput
    z: SensorOutput


class RawAccelerometer(Block):
    """A tri-axial accelerometer with output in fractions of g."""

    rate: Annotated[Frequency, Positive, Ge(0.1), Le(100_000.0)]
    accelerometer: ReckoningAccelerometer | None = None
    """Error terms of the raw output: a built-in sensor's name, a sensor file, or a block.
    Offsets, scale factors and angles are drawn once per group of runs; drifts begin with the
    rest and go on through all its runs."""
    noise: Axes | None = None
    """Standard deviation of one raw sample, u(am); replaces the accelerometer's noise density."""
    temperature: Temperature | None = None
    """Of the sensor, less that of its calibration; begins with the rest, and goes on through all
    runs of a group."""
    sampling: Literal["average", "none"] = "average"
    """A sample is the mean over the interval that begins with it, or the momentary value just
    after it."""
    time_error: Annotated[Time, NotNegative] = 0.0
    """Standard uncertainty u(Δt) of each interval between samples."""
    time_errors: Literal["independent", "stamps"] = "independent"
    """Intervals err independently, as the source assumes; or time stamps do, so that an
    interval that is too long is followed by one that is too short."""

    @model_validator(mode="wrap")
    @classmethod
    def _noise_written_once(
        cls, value: Any, handler: ModelWrapValidatorHandler[RawAccelerometer]
    ) -> RawAccelerometer:
        # What is wrong within the blocks comes first.
        sensor = handler(value)
        if isinstance(value, dict) and value.get("noise") is not None:
            block = value.get("accelerometer")
            twice = sorted(NOISE_KEYS & block.keys()) if isinstance(block, dict) else []
            if twice:
                raise reject(
                    f"`noise` and `accelerometer.{twice[0]}` say the same thing twice; keep one"
                )
        return sensor

    @model_validator(mode="after")
    def _noise_given(self) -> RawAccelerometer:
        block = self.accelerometer
        if self.noise is None and (block is None or not block.has_noise):
            source = "" if block is None or block.model is None else f"{block.model}: "
            raise reject(
                f"{source}no noise is given; write `noise: {{x: 3.8e-3 g, y: 3.0e-3 g, z: 4.9e-3 "
                "g}`, the deviation of one sample, or an `accelerometer` with a `noise_density`"
            )
        return self

    @model_validator(mode="after")
    def _senses_gravity(self) -> RawAccelerometer:
        if self.terms.ac_coupled:
            raise reject(
                "behind an `ac_coupling` no gravity is left, from which the initial tilt is taken; "
                "remove it"
            )
        return self

    @property
    def terms(self) -> AccelerometerErrors:
        """The accelerometer's error terms; an empty block if the scenario has none."""
        return self.accelerometer or AccelerometerErrors()


class Number(Block):
    """A dimensionless quantity: estimate and standard uncertainty."""

    estimate: Annotated[FiniteFloat, Ge(-_LARGEST_FACTOR), Le(_LARGEST_FACTOR)]
    uncertainty: Annotated[FiniteFloat, NotNegative, Le(_LARGEST_FACTOR)] = 0.0


class Bias(Block):
    """A zero bias: estimate and standard uncertainty."""

    estimate: Annotated[SensorOutput, Ge(-_LARGEST_BIAS), Le(_LARGEST_BIAS)]
    uncertainty: Annotated[SensorOutput, NotNegative, Le(_LARGEST_BIAS)] = 0.0


class Gravity(Place):
    """Acceleration of gravity where the sensor was calibrated."""

    VALUE: ClassVar[str] = "estimate"

    estimate: Annotated[Acceleration, Ge(_GRAVITY[0]), Le(_GRAVITY[1])] = 9.80665
    uncertainty: Annotated[Acceleration, NotNegative, Le(_GRAVITY[1])] = 0.0


class Calibration(Block):
    """Correction ac = L (am − B) of the axes x and z, Eq. (3)–(5)."""

    lxx: Number
    lxy: Number = Number(estimate=0.0)
    lxz: Number = Number(estimate=0.0)
    lzx: Number = Number(estimate=0.0)
    lzy: Number = Number(estimate=0.0)
    lzz: Number
    bx: Bias
    by: Bias = Bias.model_validate({"estimate": "0 g"})
    bz: Bias

    @model_validator(mode="after")
    def _invertible(self) -> Calibration:
        determinant = self.lxx.estimate * self.lzz.estimate - self.lxz.estimate * self.lzx.estimate
        if abs(determinant) < 0.01:
            raise reject("the matrix of the l is singular: no sensor has such a correction")
        return self


class Tilt(Block):
    """The angle between sensor and horizontal while moving, Eq. (16)–(20)."""

    change: Annotated[Angle, NotNegative, Le(_LARGEST_ANGLE)] = 0.0
    """Standard uncertainty u(δα) of its change after the rest; the estimate is zero."""
    order: Literal["first", "second", "exact"] = "first"
    """`first` is Eq. (15), `second` Eq. (12) solved for aX, `exact` the whole rotation."""


class Shaker(Block):
    """The harmonic test that shows the non-linearity of the scale factor of axis x."""

    full_scale: Annotated[SensorOutput, Ge(_SHAKEN[0]), Le(_SHAKEN[1])]
    nonlinearity: Annotated[Ratio, NotNegative, Le(1.0)]
    """What the test is to find, as a share of the full scale."""
    lowest: Annotated[Frequency, Positive] = 1.0
    highest: Annotated[Frequency, Positive] = 10.0
    points: Annotated[int, Whole, Ge(4), Le(1000)] = 10
    amplitude: Annotated[SensorOutput, Ge(_SHAKEN[0]), Le(_SHAKEN[1])] = 1.0
    """Amplitude at the highest frequency; in proportion at the others."""
    duration: Annotated[Time, Positive, Le(LONGEST)] = 10.0
    """Time at each frequency."""
    series: Annotated[int, Whole, Ge(1), Le(1000)] = 10
    """Series that are averaged."""

    @model_validator(mode="after")
    def _ascending(self) -> Shaker:
        if self.highest < 1.1 * self.lowest:
            raise reject("`highest` must be above `lowest`, by a tenth at least")
        if self.duration * self.lowest < 1.0 - 1e-9:
            raise reject(
                f"`duration` must hold a period of the lowest frequency, {1.0 / self.lowest:.4g} s"
            )
        return self


class BudgetPoint(Block):
    """Where the uncertainty budget of one step is evaluated, and what was printed for it."""

    output: Output
    """Raw output am, rows 4–6 and 13–15."""
    rest_x: Bias
    """Corrected acx,0 at rest, row 20."""
    rest_z: Bias
    """Corrected acz,0 at rest, row 21."""
    interval: Annotated[Time, Positive] | None = None
    """Δt, row 26; one sampling interval if absent."""
    printed: (
        Annotated[
            tuple[Annotated[float, Ge(1e-100), Le(1e100)], ...], Len(BUDGET_ROWS, BUDGET_ROWS)
        ]
        | None
    ) = None
    """Variances that a publication prints for the 26 rows, to be compared."""

    @model_validator(mode="after")
    def _senses_gravity(self) -> BudgetPoint:
        if abs(self.rest_z.estimate) < 0.01:
            raise reject(
                "rest_z: at rest the upward axis reads about 1 g; the initial tilt, Eq. (20), "
                f"cannot follow from {self.rest_z.estimate:g} g"
            )
        return self


class VelocityOutputs(Outputs):
    """What to keep of a velocity scenario."""

    runs: bool = False
    """Raw output of the runs of one group with their rests, as `mcsim velocity` reads it; the
    scenario's uncertainties are errors in it."""


class VelocityScenario(CaseScenario):
    """1-D velocity from a tri-axial accelerometer, with an uncertainty budget."""

    ERRORS: ClassVar[tuple[str, ...]] = ("velocity", "mean_velocity", "repeatability")
    DRAWN: ClassVar[tuple[str, ...]] = ERRORS
    # The ends of the 95 % coverage interval that JCGM 101 asks for are among them.
    PERCENTILES: ClassVar[tuple[float, ...]] = (0.025, 0.50, 0.95, 0.975)

    case: Literal["velocity"]
    trajectory: StraightRun
    body: PitchingBody = PitchingBody()
    sensor: RawAccelerometer
    calibration: Calibration
    gravity: Gravity = Gravity()
    tilt: Tilt = Tilt()
    runs: Annotated[int, Whole, Ge(1), Le(1000)] = 12
    """Runs M of a group; all runs of a group share calibration, rest, tilt and gravity."""
    outputs: VelocityOutputs = VelocityOutputs()
    instants: Annotated[tuple[Annotated[Time, Positive], ...], Len(1, 100)] | None = None
    """When errors are reported, after the start; the end of the run if absent."""
    budget: BudgetPoint | None = None
    """For `mcsim budget`: where the budget of one step is evaluated."""
    shaker: Shaker | None = None
    """For `mcsim linearity`: the harmonic test of this sensor."""

    @field_validator("instants")
    @classmethod
    def _ascending(cls, value: tuple[float, ...] | None) -> tuple[float, ...] | None:
        for before, after in pairwise(value or ()):
            if after <= before:
                raise reject(f"must ascend, but {after:g} s follows {before:g} s")
        return value

    @model_validator(mode="after")
    def _instants_within_the_run(self) -> VelocityScenario:
        for instant in self.reported:
            if instant > self.trajectory.duration * (1.0 + 1e-9):
                raise reject(
                    f"instants: {instant:g} s lies after the run, "
                    f"which lasts {self.trajectory.duration:g} s"
                )
        return self

    @property
    def files(self) -> tuple[str, ...]:
        model = self.sensor.terms.model
        of_sensor = (model,) if model is not None and is_file(model) else ()
        return (*self.trajectory.files, *of_sensor)

    @property
    def reported(self) -> tuple[float, ...]:
        """Instants at which errors are reported (s); the last sample if none is asked for."""
        return self.instants or (self.last_sample,)

    @property
    def last_sample(self) -> float:
        """When the last whole sampling interval of the run ends (s)."""
        rate = self.sensor.rate
        return math.floor(self.trajectory.duration * rate * (1.0 + 1e-12) + 1e-9) / rate

    @property
    def error_rows(self) -> tuple[ErrorRow, ...]:
        return tuple(ErrorRow(name, t) for t in self.reported for name in self.ERRORS)
