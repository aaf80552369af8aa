"""Scenarios: YAML text in, validated frozen models with SI values out."""

from mcsim.scenario.axes import Axis, Value
from mcsim.scenario.model import ERROR_NAMES, STATISTICS, ErrorName, PlanarScenario, Statistic
from mcsim.scenario.scenario import Point, Scenario

__all__ = [
    "ERROR_NAMES",
    "STATISTICS",
    "Axis",
    "ErrorName",
    "PlanarScenario",
    "Point",
    "Scenario",
    "Statistic",
    "Value",
]
