"""The block of the initial state, as far as all cases of dead reckoning have it."""

from __future__ import annotations

from typing import Annotated

from mcsim.scenario.block import Block
from mcsim.scenario.fields import Angle, NotNegative, Speed


class Initial(Block):
    """Standard deviations of the errors of the state at the first sample."""

    speed_error: Annotated[Speed, NotNegative] = 0.0
    direction_error: Annotated[Angle, NotNegative] = 0.0
    """Turns heading and course together."""
    heading_error: Annotated[Angle, NotNegative] = 0.0
    """Turns the heading alone."""
    course_error: Annotated[Angle, NotNegative] = 0.0
    """Turns the velocity vector alone."""
