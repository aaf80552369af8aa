"""A trapezoid of velocity: constant acceleration, constant velocity, constant braking."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Le
from pydantic import model_validator

from mcsim.scenario.fields import Acceleration, Positive, Speed, Time, reject
from mcsim.systems.velocity.profiles.profile import (
    JUMP,
    LARGEST_ACCELERATION,
    LONGEST,
    Array,
    Profile,
    RunBlock,
    VelocityProfile,
    breaks_of,
)


class RampedRun(RunBlock):
    """A straight run from rest to rest with a ramp up and a ramp down."""

    top_speed: Annotated[Speed, Ge(1e-6)]
    """Speed between acceleration and braking."""
    acceleration: Annotated[Acceleration, Positive, Le(LARGEST_ACCELERATION)] = 2.0
    """Largest acceleration; of the braking as well, unless `deceleration` says otherwise."""
    deceleration: Annotated[Acceleration, Positive, Le(LARGEST_ACCELERATION)] | None = None
    """Largest deceleration of the braking; that of `acceleration` if absent."""
    duration: Annotated[Time, Positive, Le(LONGEST)] = 1.5
    """From standstill to standstill."""

    @property
    def braking(self) -> float:
        """Largest deceleration of the braking (m/s²)."""
        return self.acceleration if self.deceleration is None else self.deceleration


class Trapezoid(RampedRun):
    """A straight run from rest to rest with trapezoidal velocity."""

    shape: Literal["trapezoid"] = "trapezoid"

    @model_validator(mode="after")
    def _reaches_top_speed(self) -> Trapezoid:
        ramps = self.top_speed / self.acceleration + self.top_speed / self.braking
        if ramps > self.duration * (1.0 + 1e-9):
            formula = "2 top_speed / acceleration"
            if self.deceleration is not None:
                formula = "top_speed / acceleration + top_speed / deceleration"
            raise reject(
                f"speeding up and braking take {formula} = {ramps:.4g} s, longer "
                "than the duration; lower `top_speed`, or raise `acceleration` or `duration`"
            )
        return self


def _profile(run: Trapezoid, _: Path) -> Profile:
    up, down = run.top_speed / run.acceleration, run.top_speed / run.braking
    braking = run.duration - down
    # To rounding the speed; the ramp ends where it is reached.
    top = run.acceleration * up

    def velocity(time: Array) -> Array:
        ramps = np.minimum(run.acceleration * time, run.braking * (run.duration - time))
        return np.clip(ramps, 0.0, top)

    def acceleration(time: Array) -> Array:
        driving = run.acceleration * _between(time, 0.0, up)
        return np.asarray(driving - run.braking * _between(time, braking, run.duration))

    return Profile(velocity, acceleration, breaks_of(0.0, up, braking, run.duration))


def _between(time: Array, begin: float, end: float) -> Array:
    """1 inside, 1/2 on the ends (to rounding of the times), 0 outside."""
    return 0.5 * (
        np.sign(np.where(np.abs(time - begin) < JUMP, 0.0, time - begin))
        - np.sign(np.where(np.abs(time - end) < JUMP, 0.0, time - end))
    )


PROFILE = VelocityProfile("trapezoid", Trapezoid, _profile)
