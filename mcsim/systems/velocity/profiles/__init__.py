"""The velocity profiles of straight runs: a module each, block and profile, and a line here."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Annotated

from mcsim.registry import Registry
from mcsim.scenario.one_of import OneOf
from mcsim.systems.velocity.profiles import points, recorded, s_curve, trapezoid
from mcsim.systems.velocity.profiles.profile import Profile, RunBlock, VelocityProfile

__all__ = ["PROFILES", "Profile", "RunBlock", "StraightRun", "VelocityProfile", "profile_of"]

PROFILES: Registry[VelocityProfile] = Registry(
    "velocity profile",
    (trapezoid.PROFILE, s_curve.PROFILE, points.PROFILE, recorded.PROFILE),
)

_ONE_OF_THEM = OneOf(PROFILES, default="trapezoid")
#: The trajectory block of scenarios: the block of one of the profiles.
StraightRun = Annotated[RunBlock, _ONE_OF_THEM]


@lru_cache(maxsize=256)
def profile_of(run: RunBlock, folder: Path) -> Profile:
    """The profile that a run describes; ``folder`` is where recorded files lie.

    Raises
    ------
    InputError
        A recorded file that cannot be used.
    """
    part: VelocityProfile = _ONE_OF_THEM.part_of(run)
    return part.profile(run, folder)
