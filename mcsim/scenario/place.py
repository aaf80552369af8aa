"""Where on the earth a scenario takes place, for the acceleration of gravity there."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar

from annotated_types import Ge, Le
from pydantic import model_validator

from mcsim.gravity import normal_gravity
from mcsim.scenario.block import Block
from mcsim.scenario.fields import Angle, Length, reject

_POLE = math.pi / 2.0


class Place(Block):
    """A block that holds the acceleration of gravity, or says where that is to be taken."""

    #: The key of the value.
    VALUE: ClassVar[str]

    latitude: Annotated[Angle, Ge(-_POLE), Le(_POLE)] | None = None
    """Geodetic latitude: gravity by the international formula, instead of its value."""
    height: Annotated[Length, Ge(-500.0), Le(10_000.0)] = 0.0
    """Height above the sea, with `latitude`."""

    @property
    def local_gravity(self) -> float:
        """Acceleration of gravity (m/s²): the value, or normal gravity at the latitude."""
        if self.latitude is None:
            return float(getattr(self, self.VALUE))
        return normal_gravity(self.latitude, self.height)

    @model_validator(mode="after")
    def _gravity_is_said_once(self) -> Place:
        usual = type(self).model_fields[self.VALUE].default
        if self.latitude is None and self.height:
            raise reject("height acts on gravity at a latitude; write `latitude: 52 °` as well")
        if self.latitude is not None and getattr(self, self.VALUE) != usual:
            raise reject(f"write either `{self.VALUE}` or `latitude`, not both")
        return self
