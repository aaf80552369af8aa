"""An S-curve of velocity: a trapezoid whose acceleration rises and falls with limited jerk."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import model_validator

from mcsim.scenario.fields import Jerk, Positive, reject
from mcsim.systems.velocity.profiles.profile import Array, Profile, VelocityProfile, breaks_of
from mcsim.systems.velocity.profiles.trapezoid import RampedRun
from mcsim.trajectory.jerk_limited import Ramp, phases, speed_of


class SCurve(RampedRun):
    """A straight run from rest to rest with limited jerk."""

    shape: Literal["s_curve"]
    jerk: Annotated[Jerk, Positive]
    """How fast the acceleration rises and falls."""

    @model_validator(mode="after")
    def _reaches_top_speed(self) -> SCurve:
        for name, value in (("acceleration", self.acceleration), ("deceleration", self.braking)):
            if self.top_speed * self.jerk < value**2 * (1.0 - 1e-12):
                raise reject(
                    f"the {name} cannot be reached: with this jerk and top speed the largest is "
                    f"{(self.top_speed * self.jerk) ** 0.5:.3g} m/s²"
                )
        ramps = sum(ramp.duration for ramp in self.ramps)
        if ramps > self.duration * (1.0 + 1e-9):
            raise reject(
                f"speeding up and braking take {ramps:.4g} s, longer than the duration; lower "
                "`top_speed`, or raise `acceleration`, `jerk` or `duration`"
            )
        return self

    @property
    def ramps(self) -> tuple[Ramp, Ramp]:
        """Speeding up, and braking."""
        return (
            Ramp(self.top_speed, self.acceleration, self.jerk),
            Ramp(self.top_speed, self.braking, self.jerk),
        )


def _profile(run: SCurve, _: Path) -> Profile:
    up, down = run.ramps
    cruise = max(run.duration - up.duration - down.duration, 0.0)
    knots, values = phases(up, cruise, down)

    def velocity(time: Array) -> Array:
        return np.maximum(speed_of(knots, values, time), 0.0)

    def acceleration(time: Array) -> Array:
        return np.interp(time, knots, values, left=0.0, right=0.0)

    return Profile(velocity, acceleration, breaks_of(*knots))


PROFILE = VelocityProfile("s_curve", SCurve, _profile)
