"""A velocity through points, linear between them: its integral and its derivative are exact."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Le, Len
from pydantic import model_validator

from mcsim.scenario.block import Block
from mcsim.scenario.fields import Speed, Time, reject
from mcsim.systems.velocity.profiles.profile import (
    JUMP,
    LONGEST,
    Array,
    Profile,
    RunBlock,
    VelocityProfile,
)

_FASTEST = 1e5
Velocity = Annotated[Speed, Ge(-_FASTEST), Le(_FASTEST)]


class Point(Block):
    """The velocity at a time: the vehicle's, or those of its left and right wheels."""

    time: Annotated[Time, Ge(0.0), Le(LONGEST)]
    """After the start."""
    velocity: Velocity | None = None
    """Of the vehicle."""
    left: Velocity | None = None
    """Of the left wheel; the vehicle's is the mean of both."""
    right: Velocity | None = None
    """Of the right wheel."""

    @model_validator(mode="after")
    def _of_vehicle_or_wheels(self) -> Point:
        given = [name for name in ("velocity", "left", "right") if getattr(self, name) is not None]
        if given not in (["velocity"], ["left", "right"]):
            raise reject(
                "write the `velocity` of the vehicle, or those of its `left` and `right` wheels, "
                f"not {' and '.join(given) or 'none of them'}"
            )
        return self

    @property
    def of_vehicle(self) -> float:
        """The vehicle's velocity (m/s)."""
        if self.velocity is not None:
            return self.velocity
        assert self.left is not None
        assert self.right is not None
        return 0.5 * (self.left + self.right)


class PointsRun(RunBlock):
    """A straight run whose velocity is linear between given points."""

    shape: Literal["points"]
    points: Annotated[tuple[Point, ...], Len(2, 10_000)]
    """From rest at 0 s on; the last one ends the run."""

    @model_validator(mode="after")
    def _from_rest(self) -> PointsRun:
        first = self.points[0]
        if first.time != 0.0 or first.of_vehicle != 0.0:
            raise reject("points: the first must be a standstill at 0 s: the vehicle rests before")
        for number, (one, two) in enumerate(pairwise(self.points)):
            if two.time - one.time < 1e-6:
                raise reject(
                    f"points: times must ascend, but {two.time:g} s follows {one.time:g} s "
                    f"(points {number} and {number + 1})"
                )
        return self

    @property
    def duration(self) -> float:
        """How long the run lasts (s)."""
        return self.points[-1].time


def linear_between(times: Array, velocities: Array, notes: tuple[str, ...] = ()) -> Profile:
    """The profile through velocities (n,) at ascending times (n,) from 0 on."""
    slopes = np.concatenate([[0.0], np.diff(velocities) / np.diff(times), [0.0]])

    def velocity(time: Array) -> Array:
        return np.interp(time, times, velocities)

    def acceleration(time: Array) -> Array:
        before, after = (np.searchsorted(times, time + side, "right") for side in (-JUMP, JUMP))
        return np.asarray(0.5 * (slopes[before] + slopes[after]))

    return Profile(velocity, acceleration, tuple(times.tolist()), notes)


def _profile(run: PointsRun, _: Path) -> Profile:
    return linear_between(
        np.array([point.time for point in run.points]),
        np.array([point.of_vehicle for point in run.points]),
    )


PROFILE = VelocityProfile("points", PointsRun, _profile)
