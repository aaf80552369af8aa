"""Two lane changes: into the other lane and back."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge

from mcsim.scenario.fields import Length, NotNegative
from mcsim.tracks.track import DrivenTrackBlock, Track, along
from mcsim.trajectory.curves import Array, ParametricCurve
from mcsim.trajectory.profiles import graph, lane_change


class DoubleLaneChange(DrivenTrackBlock):
    """Into the other lane and back."""

    shape: Literal["double_lane_change"]
    length: Annotated[Length, Ge(1e-3)]
    """Distance along the road of each of the two lane changes."""
    width: Length
    """Displacement across the road, positive to the left."""
    gap: Annotated[Length, NotNegative] = 0.0
    """Straight distance between the two lane changes."""
    profile: Literal["half_cosine", "quintic", "nonic"] = "quintic"
    """Shape of each lane change."""


def _curve(block: DoubleLaneChange) -> ParametricCurve:
    out = lane_change(block.profile, block.length, block.width)
    back_at = block.length + block.gap
    end = back_at + block.length

    def profile(u: Array) -> tuple[Array, Array, Array]:
        d, slope, bend = out(np.clip(u, 0.0, block.length))
        e, fall, dip = out(np.clip(u - back_at, 0.0, block.length))
        going = u <= block.length
        returning = u >= back_at
        return (
            d - e,
            np.where(going, slope, 0.0) - np.where(returning, fall, 0.0),
            np.where(going, bend, 0.0) - np.where(returning, dip, 0.0),
        )

    return graph(profile, sorted({0.0, block.length, back_at, end}))


TRACK = Track("double_lane_change", DoubleLaneChange, along(_curve))
