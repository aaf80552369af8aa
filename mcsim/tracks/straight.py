"""A straight run."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge

from mcsim.scenario.fields import Length
from mcsim.tracks.track import DrivenTrackBlock, Track, along
from mcsim.trajectory.curves import ParametricCurve
from mcsim.trajectory.profiles import graph


class Straight(DrivenTrackBlock):
    """A straight run."""

    shape: Literal["straight"]
    length: Annotated[Length, Ge(1e-3)]
    """Length of the run."""


def _curve(block: Straight) -> ParametricCurve:
    return graph(lambda u: (0.0 * u, 0.0 * u, 0.0 * u), [0.0, block.length])


TRACK = Track("straight", Straight, along(_curve))
