"""What a velocity profile must say, and what all straight runs have in common."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import NDArray

from mcsim.scenario.block import Block
from mcsim.scenario.fields import Acceleration, Angle, Frequency, NotNegative, Positive, Time

Array = NDArray[np.float64]

#: The longest run, and rest before it (s).
LONGEST = 3600.0
#: The largest acceleration of a vehicle (m/s²).
LARGEST_ACCELERATION = 1e5
#: At a jump the acceleration is the mean of both sides, to this rounding of times (s).
JUMP = 1e-9


class Swing(Block):
    """A sinusoid that begins at zero with the motion."""

    frequency: Annotated[Frequency, Positive] = 1.0


class PitchSwing(Swing):
    """Pitch of the vehicle while it moves."""

    amplitude: Annotated[Angle, Ge(-1.0), Le(1.0)] = 0.0


class VerticalSwing(Swing):
    """Vertical acceleration of uneven ground."""

    amplitude: Annotated[Acceleration, Ge(-LARGEST_ACCELERATION), Le(LARGEST_ACCELERATION)] = 0.0


class RunBlock(Block):
    """What every straight run has; a profile adds its ``shape: Literal[…]`` and its own keys.

    Each says its ``duration`` (s), as a key or as a property.
    """

    rest: Annotated[Time, NotNegative, Le(LONGEST)] = 10.0
    """Standstill before, from which the initial tilt is taken."""
    mounting_angle: Annotated[Angle, Ge(-1.0), Le(1.0)] = 0.0
    """Tilt κ of the sensor against the horizontal, constant."""
    pitch: PitchSwing = PitchSwing()
    """Change α(t) of the tilt while moving; the measurement does not see it."""
    vertical: VerticalSwing = VerticalSwing()
    """Vertical acceleration while moving."""

    if TYPE_CHECKING:

        @property
        def duration(self) -> float:
            """How long the run lasts (s)."""

    @property
    def files(self) -> tuple[str, ...]:
        """Files that the run is read from, as written."""
        return ()


@dataclass(frozen=True, eq=False)
class Profile:
    """The velocity of a run's wheels over time, and the acceleration that is its derivative.

    Attributes
    ----------
    velocity, acceleration : callable
        Times (s, after the start, any shape) to m/s and m/s²; at a jump the acceleration is the
        mean of both sides.
    breaks : tuple of float
        Ascending times (s) from 0 to the end between which the acceleration is smooth.
    notes : tuple of str
        What a user should know of where the profile comes from.
    """

    velocity: Callable[[Array], Array]
    acceleration: Callable[[Array], Array]
    breaks: tuple[float, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class VelocityProfile:
    """A shape of velocity profile: its block in scenarios, and the profile that one describes.

    Attributes
    ----------
    name : str
        What scenarios write after ``shape:``; the block's ``shape`` allows it.
    block : type
        The validated block, a ``RunBlock``; quantities in SI units.
    profile : callable
        ``profile(block, folder) -> Profile``; relative files are looked up in ``folder``.
        Raises InputError where there is none.
    """

    name: str
    block: type[RunBlock]
    profile: Callable[[Any, Path], Profile]


def breaks_of(*times: float) -> tuple[float, ...]:
    """Ascending times (s) without those that only rounding tells apart."""
    ascending = sorted(map(float, times))
    return (ascending[0], *(b for a, b in pairwise(ascending) if b - a > JUMP))
