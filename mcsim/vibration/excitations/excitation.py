"""What an excitation must say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcsim.scenario.block import Block

Array = NDArray[np.float64]


class ExcitationBlock(Block):
    """What every excitation has; one adds its ``shape: Literal[…]`` and its own keys."""

    @property
    def engine(self) -> tuple[float, int] | None:
        """Speed of the crankshaft (Hz) and number of cylinders, where an engine excites."""
        return None


@dataclass(frozen=True)
class Excitation:
    """An excitation: its block in vibration scenarios, and the acceleration that it describes.

    Attributes
    ----------
    name : str
        What scenarios write after ``shape:``; the block's ``shape`` allows it.
    block : type
        The validated block, an ``ExcitationBlock``; quantities in SI units.
    acceleration : callable
        ``acceleration(block, time, duration)``: ideal acceleration (m/s²) at ``time`` (s), both
        (n,), of an excitation that lasts ``duration`` (s).
    """

    name: str
    block: type[ExcitationBlock]
    acceleration: Callable[[Any, Array, float], Array]
