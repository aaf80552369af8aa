"""The trajectory block: shapes of tracks, and recorded drives."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le, Len
from pydantic import Field, model_validator

from mcsim.scenario.block import Block
from mcsim.scenario.fields import (
    Acceleration,
    Angle,
    Length,
    NotNegative,
    Positive,
    Speed,
    Time,
    reject,
)


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
    angle: Annotated[Angle, Ge(-1e4), Le(1e4)]
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
    """Time stamps; jitter is welcome, a clock that was set back or begins anew is continued."""
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
    roll: str | None = None
    """Roll of the body, left side up positive; with `pitch` the attitude of a strapdown case."""
    pitch: str | None = None
    """Pitch of the body, positive as `pitch_positive` says."""

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

    @model_validator(mode="after")
    def _roll_and_pitch(self) -> Columns:
        if (self.roll is None) != (self.pitch is None):
            missing = "roll" if self.roll is None else "pitch"
            raise reject(f"roll and pitch go together; `{missing}` is missing")
        return self

    @property
    def has_attitude(self) -> bool:
        """Whether the body's attitude is recorded."""
        return self.roll is not None


class Recorded(_Track):
    """A recorded drive from a CSV file, smoothed into a consistent truth."""

    shape: Literal["recorded"]
    file: str
    """CSV file, relative to the scenario file."""
    columns: Columns
    """Which column holds what, in which unit."""
    angles: Literal["compass", "mathematical"] = "compass"
    """Course and heading: clockwise from north, or counter-clockwise from x."""
    pitch_positive: Literal["nose_down", "nose_up"] = "nose_down"
    """Which way the recorded pitch counts: as here (ISO 8855), or as in aviation."""
    unknown: float | None = None
    """What the file writes for a value that is not known, beside empty cells; -1 for speed and
    course is known without it."""
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
