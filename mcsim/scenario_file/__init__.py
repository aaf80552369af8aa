"""A scenario file as a whole: its case, its sweep, its schema, and what in it has no effect."""

from mcsim.scenario_file.scenario import Point, Scenario

__all__ = ["Point", "Scenario"]
