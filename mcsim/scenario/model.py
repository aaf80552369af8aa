"""What a scenario may say: validated, frozen, SI inside.

One class per block of the YAML file.  Defaults are the planar paper's; what has
no sensible default must be written.  ``docs`` in the field descriptions end up
in the JSON schema that editors show.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, get_args

from annotated_types import Ge, Le, Len
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema, model_validator

from mcsim import catalogue
from mcsim.errors import InputError
from mcsim.scenario.fields import (
    Acceleration,
    AccelerationNoiseDensity,
    Angle,
    AngleRandomWalk,
    AngularRate,
    Confidence,
    Frequency,
    Length,
    NotNegative,
    Positive,
    RateNoiseDensity,
    Ratio,
    Speed,
    Time,
    VelocityRandomWalk,
    reject,
)
from mcsim.units import density_from_random_walk

LARGEST_SEED = 2**64 - 1
#: Errors of the planar case, in the order of every table.
ErrorName = Literal["along", "across", "position", "heading", "course"]
Statistic = Literal["mean", "std", "rms", "p50", "p95", "method"]
ERROR_NAMES: tuple[ErrorName, ...] = get_args(ErrorName)
STATISTICS: tuple[Statistic, ...] = get_args(Statistic)


class Block(BaseModel):
    """Base of all blocks: unknown keys are errors, values never change."""

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)


def _no_boolean(value: Any) -> Any:
    if isinstance(value, bool):
        raise reject(f"a whole number is needed here, not {str(value).lower()}")
    return value


Whole = BeforeValidator(_no_boolean)


class _Track(Block):
    """What every shape of track has."""

    lead: Annotated[Time, NotNegative, Le(60.0)] = 0.1
    """Duration of the straight segments before and after the manoeuvre."""
    side_slip: Annotated[Angle, Ge(-1.6), Le(1.6)] = 0.0
    """Course minus heading of the vehicle; its largest value for the profile `bump`."""
    side_slip_profile: Literal["constant", "bump"] = "constant"
    """`bump` rises and falls as a squared sine over the manoeuvre."""


class _Motion(_Track):
    """A shape driven at a given speed along the track."""

    speed: Annotated[Speed, Ge(1e-3)]
    """Speed along the track where the manoeuvre starts."""
    deceleration: Acceleration = 0.0
    """Constant deceleration during the manoeuvre; negative speeds up."""


class Straight(_Motion):
    """A straight run."""

    shape: Literal["straight"]
    length: Annotated[Length, Ge(1e-3)]
    """Length of the run."""


class LaneChange(_Motion):
    """A lane change: half-cosine, Eq. (1) of the paper, or a quintic of continuous curvature."""

    shape: Literal["half_cosine", "quintic"]
    length: Annotated[Length, Ge(1e-3)]
    """Distance L along the road."""
    width: Length
    """Displacement D across the road, positive to the left."""


class DoubleLaneChange(_Motion):
    """Into the other lane and back."""

    shape: Literal["double_lane_change"]
    length: Annotated[Length, Ge(1e-3)]
    """Distance along the road of each of the two lane changes."""
    width: Length
    """Displacement across the road, positive to the left."""
    gap: Annotated[Length, NotNegative] = 0.0
    """Straight distance between the two lane changes."""
    profile: Literal["half_cosine", "quintic"] = "quintic"
    """Shape of each lane change."""


class Curve(_Motion):
    """A curve of constant radius with clothoid entry and exit."""

    shape: Literal["curve"]
    radius: Annotated[Length, Ge(1e-3)]
    """Radius of the circular part."""
    angle: Angle
    """Change of course over the whole curve, positive to the left."""
    clothoid: Annotated[Length, NotNegative] = 0.0
    """Length of each clothoid."""

    @model_validator(mode="after")
    def _clothoids_fit(self) -> Curve:
        if self.angle == 0.0:
            raise reject("angle must not be zero; use the shape `straight`")
        if self.clothoid > self.radius * abs(self.angle):
            raise reject(
                f"the clothoids alone turn by clothoid / radius = "
                f"{self.clothoid / self.radius:.4g} rad, more than the angle asked for; "
                "shorten `clothoid` or enlarge `angle` or `radius`"
            )
        return self


Waypoint = Annotated[tuple[Length, ...], Len(2, 2)]


class Waypoints(_Motion):
    """A smooth track (cubic spline) through given points."""

    shape: Literal["waypoints"]
    points: Annotated[tuple[Waypoint, ...], Len(2, 10_000)]
    """Points [x, y]; turned so that `along` is the initial direction of movement."""


class Columns(Block):
    """Columns of a recorded track, each written as `NAME in UNIT`."""

    time: str = "time in s"
    """Time stamps; jitter is welcome, going backwards is not."""
    x: str | None = None
    """Position to the east, or along any axis."""
    y: str | None = None
    """Position to the north, or to the left of x."""
    latitude: str | None = None
    """WGS 84 latitude, instead of x and y."""
    longitude: str | None = None
    """WGS 84 longitude, instead of x and y."""
    speed: str | None = None
    """Speed over ground; with `course` it replaces positions."""
    course: str | None = None
    """Direction of movement, clockwise from north (compass) unless `angles` says otherwise."""
    heading: str | None = None
    """Direction of the vehicle's axis; the course is used where it is not given."""

    @model_validator(mode="after")
    def _position_or_velocity(self) -> Columns:
        sources = [
            pair
            for pair in (("x", "y"), ("latitude", "longitude"), ("speed", "course"))
            if any(getattr(self, name) is not None for name in pair)
        ]
        if len(sources) != 1:
            raise reject(
                "name the columns of exactly one pair: x and y, latitude and longitude, "
                "or speed and course"
            )
        for name in sources[0]:
            if getattr(self, name) is None:
                raise reject(f"{' and '.join(sources[0])} go together; `{name}` is missing")
        return self


class Recorded(_Track):
    """A recorded drive from a CSV file, smoothed into a consistent truth."""

    shape: Literal["recorded"]
    file: str
    """CSV file, relative to the scenario file."""
    columns: Columns
    """Which column holds what, in which unit."""
    angles: Literal["compass", "mathematical"] = "compass"
    """Course and heading: clockwise from north, or counter-clockwise from x."""
    smoothing: Annotated[Time, Ge(0.01), Le(1e4)] = 0.5
    """Time constant of the smoothing; slower motion passes, faster motion is noise."""
    start: Annotated[Time, NotNegative] = 0.0
    """Where to begin, after the first row."""
    duration: Annotated[Time, Positive] | None = None
    """How much of the drive to use; all of it if absent."""

    @model_validator(mode="after")
    def _slip_is_recorded(self) -> Recorded:
        if self.side_slip != 0.0:
            raise reject("a recorded track brings its own side-slip: give a heading column instead")
        return self


Trajectory = Annotated[
    Straight | LaneChange | DoubleLaneChange | Curve | Waypoints | Recorded,
    Field(discriminator="shape"),
]


def _named_sensor(element: str) -> Any:
    """Accept a sensor's name for its block, and fill the block from the catalogue."""

    def expand(value: Any) -> Any:
        block = {"model": value} if isinstance(value, str) else value
        if not isinstance(block, dict) or not isinstance(block.get("model"), str):
            return block
        try:
            known = catalogue.element(block["model"], element)
        except InputError as error:
            raise reject(str(error)) from None
        given = block.keys() & {"noise_density", "velocity_random_walk", "angle_random_walk"}
        if given:
            return block
        if "noise_density" not in known:
            raise reject(
                f"{block['model']}: its source gives no noise density; "
                f"write `{element}: {{model: {block['model']}, noise_density: …}}`"
            )
        return {**block, "noise_density": known["noise_density"]}

    return BeforeValidator(expand)


def _one_noise(block: Block, names: tuple[str, str], example: str) -> None:
    given = [name for name in names if getattr(block, name) is not None]
    if len(given) == 2:
        raise reject(f"`{names[0]}` and `{names[1]}` say the same thing twice; keep one")
    if not given:
        raise reject(f"write `noise_density: {example}` (zero for none), or name a `model`")


class Accelerometer(Block):
    """Both accelerometer axes (forward and left)."""

    model: str | None = None
    """Name of a built-in sensor (`mcsim sensors`); its values hold unless written here."""
    noise_density: Annotated[AccelerationNoiseDensity, NotNegative] | None = None
    """White noise, one-sided density as data sheets print it."""
    velocity_random_walk: Annotated[VelocityRandomWalk, NotNegative] | None = None
    """White noise as Allan's N (two-sided), instead of `noise_density`."""
    miscalibration: Annotated[Acceleration, NotNegative] = 0.0
    """Standard deviation of the constant offset drawn once per realization and axis."""

    @model_validator(mode="after")
    def _noise_given_once(self) -> Accelerometer:
        _one_noise(self, ("noise_density", "velocity_random_walk"), "2.2e-3 m/s²/√Hz")
        return self

    @property
    def density(self) -> float:
        """One-sided noise density, m/s²/√Hz."""
        if self.velocity_random_walk is not None:
            return density_from_random_walk(self.velocity_random_walk)
        return self.noise_density or 0.0


class Gyroscope(Block):
    """The gyroscope about the vertical axis."""

    model: str | None = None
    """Name of a built-in sensor (`mcsim sensors`); its values hold unless written here."""
    noise_density: Annotated[RateNoiseDensity, NotNegative] | None = None
    """White noise, one-sided density as data sheets print it."""
    angle_random_walk: Annotated[AngleRandomWalk, NotNegative] | None = None
    """White noise as Allan's N (two-sided), instead of `noise_density`."""
    miscalibration: Annotated[AngularRate, NotNegative] = 0.0
    """Standard deviation of the constant offset drawn once per realization."""

    @model_validator(mode="after")
    def _noise_given_once(self) -> Gyroscope:
        _one_noise(self, ("noise_density", "angle_random_walk"), "0.03 °/s/√Hz")
        return self

    @property
    def density(self) -> float:
        """One-sided noise density, rad/s/√Hz."""
        if self.angle_random_walk is not None:
            return density_from_random_walk(self.angle_random_walk)
        return self.noise_density or 0.0


class Sensors(Block):
    """The measured channels: forward and left acceleration, yaw rate."""

    rate: Annotated[Frequency, Positive, Ge(0.1), Le(100_000.0)]
    """Output rate of the sensors."""
    sampling: Literal["fir", "iir", "none", "average"] = "fir"
    """From dense truth to samples: filtered, picked, or averaged over the interval."""
    accelerometer: Annotated[Accelerometer, _named_sensor("accelerometer")]
    gyroscope: Annotated[Gyroscope, _named_sensor("gyroscope")]


class Reconstruction(Block):
    """How the sensor data are integrated."""

    integration: Literal["rectangular", "trapezoidal"] = "rectangular"
    """`rectangular` is the paper's way; `trapezoidal` is of second order."""


class Initial(Block):
    """Standard deviations of the errors of the state at the first sample."""

    speed_error: Annotated[Speed, NotNegative] = 0.0
    direction_error: Annotated[Angle, NotNegative] = 0.0
    """Turns heading and course together."""
    heading_error: Annotated[Angle, NotNegative] = 0.0
    """Turns the heading alone."""
    course_error: Annotated[Angle, NotNegative] = 0.0
    """Turns the velocity vector alone."""


class MonteCarlo(Block):
    """How many realizations, and how sure the intervals are."""

    realizations: Annotated[int, Whole, Ge(1), Le(20_000_000)] | None = None
    """Number of realizations per point."""
    precision: Annotated[Ratio, Positive, Le(1.0)] | None = None
    """Go on until the intervals of all RMS values are within this share of the value."""
    max_realizations: Annotated[int, Whole, Ge(1000), Le(20_000_000)] = 1_000_000
    """Where `precision` gives up."""
    seed: Annotated[int, Whole, Ge(0), Le(LARGEST_SEED)] = 1
    estimator: Literal["control_variate", "plain", "linear"] = "control_variate"
    """`control_variate` estimates only what the linear model leaves, `plain` everything;
    `linear` reports the linear model, and where Monte Carlo contradicts it."""
    confidence: Confidence = 3.0
    """Confidence of the intervals, `3 sigma` or `95 %`."""
    resamples: Annotated[int, Whole, Ge(100), Le(100_000)] = 1000
    """Bootstrap resamples."""
    common_random_numbers: bool = False
    """The same random numbers at every point of the sweep."""

    @model_validator(mode="after")
    def _count_or_precision(self) -> MonteCarlo:
        if self.realizations is not None and self.precision is not None:
            raise reject("give `realizations` or `precision`, not both")
        if self.realizations is None and self.precision is None:
            raise reject("write `realizations: 1000`, or `precision: 1 %`")
        return self


class Outputs(Block):
    """What to keep beyond the table of final errors."""

    history: bool = False
    """Statistics of the errors at every sample."""
    tracks: Annotated[int, Whole, Ge(0), Le(1000)] = 0
    """Number of reconstructed sample tracks."""


class Range(Block):
    """Equally spaced values of a swept quantity, ends included."""

    from_: Annotated[str | int | float, Field(alias="from")]
    to: str | int | float
    points: Annotated[int, Whole, Ge(2), Le(100_000)]
    scale: Literal["linear", "log"] = "linear"


def _as_tuple(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


class Panel(Block):
    """One pair of axes of a figure."""

    errors: Annotated[
        tuple[ErrorName, ...],
        Len(1, 5),
        BeforeValidator(_as_tuple),
        WithJsonSchema(
            {
                "oneOf": [
                    {"enum": list(ERROR_NAMES)},
                    {"type": "array", "items": {"enum": list(ERROR_NAMES)}, "minItems": 1},
                ]
            }
        ),
    ]
    """The errors drawn."""
    x: str | None = None
    """Swept path on the horizontal axis; the first one if absent."""
    curves: str | None = None
    """Swept path that distinguishes the curves; the second one if absent."""

    @model_validator(mode="after")
    def _one_unit_and_two_paths(self) -> Panel:
        if len({name in ("heading", "course") for name in self.errors}) > 1:
            raise reject("positions and angles cannot share a panel; write two panels")
        if self.x is not None and self.x == self.curves:
            raise reject("`x` and `curves` name the same path")
        return self


class Limits(Block):
    """Requirement lines."""

    position: Annotated[Length, Positive] | None = None
    angle: Annotated[Angle, Positive] | None = None


class Figure(Block):
    """How the sweep is drawn."""

    title: str | None = None
    """Second line of the title; heads the column where figures stand side by side."""
    method: bool = False
    """Also draw, dotted, the error that sampling and integration alone make."""
    statistic: Literal["mean", "std", "rms", "p50", "p95"] = "rms"
    panels: Annotated[tuple[Panel, ...], Len(1, 12)] = tuple(
        Panel(errors=(name,)) for name in ("along", "across", "heading", "course")
    )
    limits: Limits = Limits()


class PlanarScenario(Block):
    """2-D dead reckoning from two accelerometer axes and one gyroscope."""

    case: Literal["planar"]
    title: str | None = None
    """One line for people."""
    trajectory: Trajectory
    sensors: Sensors
    reconstruction: Reconstruction = Reconstruction()
    initial: Initial = Initial()
    monte_carlo: MonteCarlo
    outputs: Outputs = Outputs()
    figure: Figure = Figure()
