"""The excitations: a module each, block and acceleration together, and a line here.

``mcsim.vibration.excitations.excitation`` tells what one must say.
"""

from __future__ import annotations

from typing import Annotated

from mcsim.registry import Registry
from mcsim.scenario.one_of import OneOf
from mcsim.vibration.excitations import elevator, harmonic, rest, sweep
from mcsim.vibration.excitations.excitation import Array, Excitation, ExcitationBlock

__all__ = ["EXCITATIONS", "AnyExcitation", "Excitation", "ExcitationBlock", "acceleration"]

EXCITATIONS: Registry[Excitation] = Registry(
    "excitation",
    (harmonic.EXCITATION, sweep.EXCITATION, elevator.EXCITATION, rest.EXCITATION),
)

_ONE_OF_THEM = OneOf(EXCITATIONS)
#: The excitation block of scenarios: the block of one of them.
AnyExcitation = Annotated[ExcitationBlock, _ONE_OF_THEM]


def acceleration(block: ExcitationBlock, time: Array, duration: float) -> Array:
    """Acceleration (m/s²) at ``time`` (s), both (n,), of an excitation that lasts ``duration``."""
    excitation: Excitation = _ONE_OF_THEM.part_of(block)
    return excitation.acceleration(block, time, duration)
