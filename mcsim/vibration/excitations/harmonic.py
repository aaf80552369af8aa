"""A machine that turns steadily."""

from __future__ import annotations

import cmath
import math
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Le, Len

from mcsim.scenario.block import Block, Whole
from mcsim.scenario.fields import Acceleration, Angle, NotNegative, Positive, RotationalSpeed
from mcsim.vibration.excitations.excitation import Array, Excitation, ExcitationBlock, Tone


class Order(Block):
    """One harmonic of a shaft."""

    order: Annotated[float, Positive, Le(1000.0)]
    """Periods per revolution of the crankshaft."""
    amplitude: Annotated[Acceleration, NotNegative]
    phase: Angle = 0.0


class Harmonic(ExcitationBlock):
    """A machine that turns steadily: a sum of orders."""

    shape: Literal["harmonic"]
    speed: Annotated[RotationalSpeed, Positive]
    """Speed of the crankshaft."""
    cylinders: Annotated[int, Whole, Ge(1), Le(64)] = 4
    """Of a four-stroke engine: half as many firings per revolution."""
    orders: Annotated[tuple[Order, ...], Len(1, 100)]

    @property
    def engine(self) -> tuple[float, int]:
        return self.speed, self.cylinders

    @property
    def tones(self) -> tuple[Tone, ...]:
        """One per order; what is written of an order more than once adds up by phase."""
        sums: dict[float, complex] = {}
        for part in self.orders:
            sums[part.order] = sums.get(part.order, 0.0) + cmath.rect(part.amplitude, part.phase)
        return tuple(
            Tone(f"order {order:g}", order * self.speed, abs(sums[order]), order)
            for order in sorted(sums)
        )


def _acceleration(block: Harmonic, time: Array, _: float) -> Array:
    turn = 2.0 * math.pi * block.speed * time
    total: Array = np.zeros_like(time)
    for order in block.orders:
        total += order.amplitude * np.sin(order.order * turn + order.phase)
    return total


EXCITATION = Excitation("harmonic", Harmonic, _acceleration)
