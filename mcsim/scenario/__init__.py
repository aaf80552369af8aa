"""Blocks of scenarios, the text they are written in, and how both become validated models."""

from mcsim.scenario.axes import Axis, Value
from mcsim.scenario.case import CaseScenario
from mcsim.scenario.error_quantities import UNITS, ErrorRow

__all__ = ["UNITS", "Axis", "CaseScenario", "ErrorRow", "Value"]
