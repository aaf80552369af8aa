"""The blocks that describe the run: realizations, outputs, ranges of a sweep."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le
from pydantic import Field, model_validator

from mcsim.scenario.block import Block, Whole
from mcsim.scenario.fields import Confidence, Positive, Ratio, reject

LARGEST_SEED = 2**64 - 1
#: Where a precision gives up that is given no maximum.
_MOST = 1_000_000


class MonteCarlo(Block):
    """How many realizations, and how sure the intervals are."""

    realizations: Annotated[int, Whole, Ge(1), Le(20_000_000)] | None = None
    """Number of realizations per point."""
    precision: Annotated[Ratio, Positive, Le(1.0)] | None = None
    """Go on until the intervals of all RMS values are within this share of the value."""
    max_realizations: Annotated[int, Whole, Ge(1000), Le(20_000_000)] | None = None
    """Where `precision` gives up; a million if absent."""
    seed: Annotated[int, Whole, Ge(0), Le(LARGEST_SEED)] = 1
    estimator: Literal["control_variate", "plain", "linear"] = "control_variate"
    """`control_variate` estimates only what the linear model leaves, `plain` everything;
    `linear` reports the linear model, and where Monte Carlo contradicts it."""
    offsets: Literal["random", "sobol"] = "random"
    """What a realization draws once: at random, or from scrambled Sobol points, which fill
    the space evenly and narrow the intervals where such offsets dominate."""
    confidence: Confidence = 3.0
    """Confidence of the intervals, `3 sigma` or `95 %`."""
    resamples: Annotated[int, Whole, Ge(100), Le(100_000)] = 1000
    """Bootstrap resamples."""
    common_random_numbers: bool = False
    """The same random numbers at every point of the sweep."""

    @property
    def most_realizations(self) -> int:
        """How many realizations a point has at most."""
        return self.realizations or self.max_realizations or _MOST

    @model_validator(mode="after")
    def _count_or_precision(self) -> MonteCarlo:
        if self.realizations is not None and self.precision is not None:
            raise reject("give `realizations` or `precision`, not both")
        if self.realizations is None and self.precision is None:
            raise reject("write `realizations: 1000`, or `precision: 1 %`")
        return self


class Outputs(Block):
    """What to keep beyond the table of final errors."""

    history: bool = False
    """Statistics of the errors at every sample."""
    tracks: Annotated[int, Whole, Ge(0), Le(1000)] = 0
    """Number of reconstructed sample tracks."""


class Range(Block):
    """Equally spaced values of a swept quantity, ends included."""

    from_: Annotated[str | int | float, Field(alias="from")]
    to: str | int | float
    points: Annotated[int, Whole, Ge(2), Le(100_000)]
    scale: Literal["linear", "log"] = "linear"
