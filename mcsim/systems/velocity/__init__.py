"""The velocity case: a straight run by a tri-axial accelerometer, with an uncertainty budget."""

from __future__ import annotations

from pathlib import Path

from mcsim.simulation.case import Case
from mcsim.simulation.problem import Problem
from mcsim.systems.velocity.scenario import VelocityScenario


def _problem(model: VelocityScenario, folder: Path) -> Problem:
    from mcsim.systems.velocity.problem import VelocityProblem

    return VelocityProblem.from_model(model, folder)


def _samples(model: VelocityScenario, folder: Path) -> int:
    from mcsim.systems.velocity.steps import step_count

    return step_count(model, folder)


CASE = Case("velocity", VelocityScenario, _problem, _samples)
