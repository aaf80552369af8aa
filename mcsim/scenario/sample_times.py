"""When samples are taken, and what their time stamps say of it."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le
from pydantic import model_validator

from mcsim.scenario.block import Block
from mcsim.scenario.fields import NotNegative, Ratio, Time, reject

#: What integrators take for the time between two samples.
Intervals = Literal["measured", "nominal"]


class Stamps(Block):
    """Time stamps of a log, in place of even ones."""

    file: str
    """A log of any format, relative to the scenario file; its first row is the first sample."""
    column: str | None = None
    """The time stamps, as `NAME in UNIT`; the column whose name says time if absent."""
    instants: Literal["as_stamped", "even"] = "as_stamped"
    """When the samples were taken: when the stamps say, or evenly, by count, and stamped late or
    early, as serial data are that arrive at a computer."""


class SampleTimes(Block):
    """When samples are really taken, and what their time stamps say of it.

    Each realization draws its own errors; those of a file are the same for all of them.
    """

    interval_jitter: Annotated[Time, NotNegative, Le(1.0)] = 0.0
    """Standard deviation of the instants of the samples about even ones; the stamps follow it.
    Time begins at the first sample, whose instant is its own. To first order, by the slope between
    the neighbouring samples."""
    stamp_jitter: Annotated[Time, NotNegative, Le(1.0)] = 0.0
    """Standard deviation of the stamps about the instants: a coarse clock, or a latency that
    varies."""
    latency: Annotated[Time, NotNegative, Le(60.0)] = 0.0
    """How long ago a sample was taken when it counts as present: the initial state and the truth
    are those of the later time."""
    lost: Annotated[Ratio, NotNegative, Le(0.5)] = 0.0
    """Share of the samples that never arrive; the first and the last one do."""
    rate_error: Annotated[Ratio, Ge(-0.5), Le(0.5)] = 0.0
    """How much faster the sensor samples than `rate` says."""
    stamps: Stamps | None = None
    """Recorded time stamps."""

    @model_validator(mode="after")
    def _one_source(self) -> SampleTimes:
        if self.stamps is None:
            return self
        if self.rate_error:
            raise reject("recorded `stamps` have the rate in them: leave out `rate_error`")
        if self.interval_jitter:
            raise reject("recorded `stamps` have their jitter in them: leave out `interval_jitter`")
        return self

    @property
    def varies(self) -> bool:
        """Whether any interval may be another than the sampling interval."""
        jitter = self.interval_jitter or self.stamp_jitter
        return bool(jitter or self.lost or self.rate_error or self.stamps)


def refuse_wide(jitter: float, rate: float, name: str) -> None:
    """Refuse a jitter of more than half a sampling interval."""
    if jitter * rate > 0.5:
        raise reject(f"{name} must be at most half a sampling interval, {0.5 / rate:.4g} s")
