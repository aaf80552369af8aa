"""A curve of constant radius with clothoid entry and exit."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le
from pydantic import model_validator

from mcsim.scenario.fields import Angle, Length, NotNegative, reject
from mcsim.tracks.track import DrivenTrackBlock, Track, along
from mcsim.trajectory.curves import ClothoidCurve


class Curve(DrivenTrackBlock):
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


def _curve(block: Curve) -> ClothoidCurve:
    return ClothoidCurve(block.radius, block.angle, block.clothoid)


TRACK = Track("curve", Curve, along(_curve))
