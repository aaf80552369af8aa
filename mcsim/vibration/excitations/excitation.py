"""What an excitation must say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcsim.scenario.block import Block

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Tone:
    """A steady tone that an excitation holds, or that is looked for in a log.

    ``frequency`` in Hz; ``amplitude`` in m/s², None where nobody knows it; ``order`` of the
    crankshaft, None where it is no engine's; ``span`` is the stretch of time (s) in which it is
    steady, None for the whole log.
    """

    name: str
    frequency: float
    amplitude: float | None = None
    order: float | None = None
    span: tuple[float, float] | None = None


@dataclass(frozen=True)
class Travel:
    """A run from rest to rest: from ``start`` to ``end`` (s), over ``distance`` (m).

    ``motion(time)`` gives speed (m/s) and height (m), both (n,), at ``time`` (s).
    """

    start: float
    end: float
    distance: float
    motion: Callable[[Array], tuple[Array, Array]]


class ExcitationBlock(Block):
    """What every excitation has; one adds its ``shape: Literal[…]`` and its own keys.

    What sensors are compared by follows from ``tones``, ``travel`` and ``cycles``.
    """

    @property
    def engine(self) -> tuple[float, int] | None:
        """Speed of the crankshaft (Hz) and number of cylinders, where an engine excites."""
        return None

    @property
    def tones(self) -> tuple[Tone, ...]:
        """Its steady tones, in the order of their frequencies."""
        return ()

    @property
    def travel(self) -> Travel | None:
        """Its run, where it goes from rest to rest."""
        return None

    def cycles(self, time: Array, duration: float) -> Array | None:
        """Cycles until ``time`` (s), (n,), of one tone whose frequency changes; else None."""
        del time, duration
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
