"""What a shape of track must say, and what the shapes have in common."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from annotated_types import Ge, Le

from mcsim.scenario.block import Block
from mcsim.scenario.fields import Acceleration, Angle, NotNegative, Speed, Time
from mcsim.scenario.idle import IdleKey
from mcsim.trajectory.curves import PlaneCurve
from mcsim.trajectory.drive import CurveManoeuvre, Manoeuvre


class TrackBlock(Block):
    """What every shape of track has; a shape adds its ``shape: Literal[…]`` and its own keys."""

    lead: Annotated[Time, NotNegative, Le(60.0)] = 0.1
    """Duration of the straight segments before and after the manoeuvre."""
    side_slip: Annotated[Angle, Ge(-1.6), Le(1.6)] = 0.0
    """Course minus heading of the vehicle; its largest value for the profile `bump`."""
    side_slip_profile: Literal["constant", "bump"] = "constant"
    """`bump` rises and falls as a squared sine over the manoeuvre."""

    @property
    def files(self) -> tuple[str, ...]:
        """Files that the track is read from, as written."""
        return ()

    @property
    def has_attitude(self) -> bool:
        """Whether the track brings roll and pitch: its manoeuvre then has an ``attitude``."""
        return False


class DrivenTrackBlock(TrackBlock):
    """A shape driven at a given speed along the track."""

    speed: Annotated[Speed, Ge(1e-3)]
    """Speed along the track where the manoeuvre starts."""
    deceleration: Acceleration = 0.0
    """Constant deceleration during the manoeuvre; negative speeds up."""


@dataclass(frozen=True)
class Track:
    """A shape of track: its block in scenarios, and the motion that such a block describes.

    Attributes
    ----------
    name : str
        What scenarios write after ``shape:``; the block's ``shape`` allows it.
    block : type
        The validated block, a ``TrackBlock``; quantities in SI units.
    manoeuvre : callable
        ``manoeuvre(block, folder) -> Manoeuvre``; relative files are looked up in ``folder``.
        Raises InputError where there is no such motion.  ``along(curve)`` makes one of a curve.
    idle : tuple of IdleKey
        Keys of the block that change nothing in some scenarios.
    """

    name: str
    block: type[TrackBlock]
    manoeuvre: Callable[[Any, Path], Manoeuvre]
    idle: tuple[IdleKey, ...] = ()


def along(curve: Callable[[Any], PlaneCurve]) -> Callable[[Any, Path], CurveManoeuvre]:
    """The manoeuvre of a shape that is driven along a curve, at the block's speed.

    Parameters
    ----------
    curve : callable
        ``curve(block) -> PlaneCurve`` of a ``DrivenTrackBlock``: positions by arc length (m); see
        ``mcsim.curves``.

    Returns
    -------
    callable
        ``manoeuvre(block, folder)``, as a ``Track`` has it.

    Raises
    ------
    InputError
        What ``curve`` raises, when the manoeuvre is made: a block that no curve fits.
    """

    def manoeuvre(block: DrivenTrackBlock, _: Path) -> CurveManoeuvre:
        return CurveManoeuvre(
            curve(block),
            block.speed,
            block.deceleration,
            block.side_slip,
            block.side_slip_profile == "bump",
        )

    return manoeuvre
