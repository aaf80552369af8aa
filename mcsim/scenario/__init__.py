"""Scenarios: YAML text in, validated frozen models with SI values out."""

from mcsim.scenario.axes import Axis, Value
from mcsim.scenario.case import CaseScenario
from mcsim.scenario.error_names import UNITS, ErrorName, ErrorRow
from mcsim.scenario.planar import PlanarScenario
from mcsim.scenario.scenario import Point, Scenario
from mcsim.scenario.strapdown import StrapdownScenario
from mcsim.scenario.velocity import VelocityScenario

__all__ = [
    "UNITS",
    "Axis",
    "CaseScenario",
    "ErrorName",
    "ErrorRow",
    "PlanarScenario",
    "Point",
    "Scenario",
    "StrapdownScenario",
    "Value",
    "VelocityScenario",
]
