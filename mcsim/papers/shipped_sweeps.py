"""What the shipped sweeps give that belong to no numbered figure."""

from __future__ import annotations

from mcsim.papers import PaperFigure
from mcsim.papers.shipped import scenarios_of
from mcsim.scenario_file import Scenario


def _sweeps(group: str) -> PaperFigure:
    def swept() -> list[Scenario]:
        return [scenario for scenario in scenarios_of(group) if scenario.axes]

    return PaperFigure(group, swept)


STRAPDOWN = _sweeps("strapdown")
VELOCITY = _sweeps("velocity")
