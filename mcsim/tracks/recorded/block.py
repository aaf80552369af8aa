"""The block of a recorded drive: its file, and which column holds what."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le
from pydantic import model_validator

from mcsim.scenario.block import Block
from mcsim.scenario.fields import NotNegative, Positive, Time, reject
from mcsim.tracks.track import TrackBlock


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


class Recorded(TrackBlock):
    """A recorded drive from a file, smoothed into a consistent truth."""

    shape: Literal["recorded"]
    file: str
    """File of the drive, CSV or another format of logs, relative to the scenario file."""
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

    @property
    def files(self) -> tuple[str, ...]:
        return (self.file,)

    @property
    def has_attitude(self) -> bool:
        return self.columns.has_attitude

    @model_validator(mode="after")
    def _slip_is_recorded(self) -> Recorded:
        if self.side_slip != 0.0:
            raise reject("a recorded track brings its own side-slip: give a heading column instead")
        return self
