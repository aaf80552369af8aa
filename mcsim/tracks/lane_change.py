"""Lane changes: a half-cosine, and polynomials whose curvature has no jump, or no kink either."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge

from mcsim.scenario.fields import Length
from mcsim.tracks.track import DrivenTrackBlock, Track, along
from mcsim.trajectory.curves import ParametricCurve
from mcsim.trajectory.profiles import graph, lane_change


class LaneChange(DrivenTrackBlock):
    """A lane change: half-cosine, Eq. (1) of the paper, or a polynomial.

    The curvature of the quintic is continuous, that of the nonic smooth: signals without a kink.
    """

    shape: Literal["half_cosine", "quintic", "nonic"]
    length: Annotated[Length, Ge(1e-3)]
    """Distance L along the road."""
    width: Length
    """Displacement D across the road, positive to the left."""


def _curve(block: LaneChange) -> ParametricCurve:
    return graph(lane_change(block.shape, block.length, block.width), [0.0, block.length])


HALF_COSINE = Track("half_cosine", LaneChange, along(_curve))
QUINTIC = Track("quintic", LaneChange, along(_curve))
NONIC = Track("nonic", LaneChange, along(_curve))
