"""The figure block: how a sweep is drawn."""

from __future__ import annotations

from typing import Annotated, Any

from annotated_types import Len
from pydantic import BeforeValidator, model_validator

from mcsim.scenario.block import Block
from mcsim.scenario.error_quantities import UNITS, OneOrMoreNames, known_name
from mcsim.scenario.fields import Angle, Length, Positive, Speed, reject
from mcsim.statistics import STATISTICS
from mcsim.statistics.rms import RMS


def _as_tuple(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


class StatisticName:
    """Describes the name of a statistic in the JSON schema; which there are is the case's."""

    def __get_pydantic_json_schema__(self, *_: Any) -> dict[str, Any]:
        percentile = {"type": "string", "pattern": r"^p\d+(\.\d+)?$"}
        return {"anyOf": [{"enum": list(STATISTICS)}, percentile]}


class Panel(Block):
    """One pair of axes of a figure."""

    errors: Annotated[
        tuple[Annotated[str, known_name()], ...],
        Len(1, 5),
        BeforeValidator(_as_tuple),
        OneOrMoreNames(),
    ]
    """The errors drawn."""
    x: str | None = None
    """Swept path on the horizontal axis; the first one if absent."""
    curves: str | None = None
    """Swept path that distinguishes the curves; the second one if absent."""

    @model_validator(mode="after")
    def _one_unit_and_two_paths(self) -> Panel:
        if len({UNITS[name] for name in self.errors}) > 1:
            raise reject("errors of different units cannot share a panel; write two panels")
        if self.x is not None and self.x == self.curves:
            raise reject("`x` and `curves` name the same path")
        return self


class Limits(Block):
    """Requirement lines."""

    position: Annotated[Length, Positive] | None = None
    angle: Annotated[Angle, Positive] | None = None
    velocity: Annotated[Speed, Positive] | None = None


class Figure(Block):
    """How the sweep is drawn."""

    title: str | None = None
    """Second line of the title; heads the column where figures stand side by side."""
    method: bool = False
    """Also draw, dotted, the error that sampling and integration alone make."""
    map: bool = False
    """Also draw the first two swept numbers as a map, with contour lines and the limits in bold."""
    statistic: Annotated[str, StatisticName()] = RMS.name
    panels: Annotated[tuple[Panel, ...], Len(1, 12)] | None = None
    """The case's usual ones if absent."""
    limits: Limits = Limits()
