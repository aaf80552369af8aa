"""An elevator's run."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from annotated_types import Len
from pydantic import model_validator

from mcsim.scenario.block import Block
from mcsim.scenario.fields import (
    Acceleration,
    Frequency,
    Jerk,
    Length,
    NotNegative,
    Positive,
    Speed,
    Time,
    reject,
)
from mcsim.trajectory.jerk_limited import Ramp, phases, speed_of
from mcsim.vibration.excitations.excitation import Array, Excitation, ExcitationBlock


class Hum(Block):
    """A vibration of the moving car, growing with its speed."""

    frequency: Annotated[Frequency, Positive]
    amplitude: Annotated[Acceleration, NotNegative]
    """At full speed."""


class Elevator(ExcitationBlock):
    """An elevator's run: trapezoidal velocity with limited jerk."""

    shape: Literal["elevator"]
    distance: Annotated[Length, Positive]
    """Travel, upwards."""
    speed: Annotated[Speed, Positive]
    acceleration: Annotated[Acceleration, Positive]
    """Largest acceleration."""
    jerk: Annotated[Jerk, Positive]
    start: Annotated[Time, NotNegative] = 2.0
    """When the run begins."""
    hum: Annotated[tuple[Hum, ...], Len(0, 20)] = ()

    @model_validator(mode="after")
    def _reaches_its_speed(self) -> Elevator:
        if self.speed * self.jerk < self.acceleration**2:
            raise reject(
                f"the acceleration cannot be reached: with this jerk and speed the largest is "
                f"{(self.speed * self.jerk) ** 0.5:.3g} m/s²"
            )
        needed = self.speed * (self.speed / self.acceleration + self.acceleration / self.jerk)
        if self.distance < needed:
            raise reject(
                f"the distance is too short to reach the speed: at least {needed:.3g} m are needed"
            )
        return self


def elevator_phases(block: Elevator) -> tuple[Array, Array]:
    """Times (s) and accelerations (m/s²) where the run's jerk changes, (8,); linear in between."""
    ramp = Ramp(block.speed, block.acceleration, block.jerk)
    times, accelerations = phases(ramp, block.distance / block.speed - ramp.duration, ramp)
    return block.start + times, accelerations


def elevator_speed(block: Elevator, time: Array) -> Array:
    """Speed of the car (m/s) at ``time`` (s), (n,): the integral of the phases."""
    return speed_of(*elevator_phases(block), time)


def _acceleration(block: Elevator, time: Array, _: float) -> Array:
    total: Array = np.interp(time, *elevator_phases(block), left=0.0, right=0.0)
    if block.hum:
        share = elevator_speed(block, time) / block.speed
        for hum in block.hum:
            total += hum.amplitude * share * np.sin(2.0 * math.pi * hum.frequency * time)
    return total


EXCITATION = Excitation("elevator", Elevator, _acceleration)
