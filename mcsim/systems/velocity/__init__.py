"""The velocity case: a straight run by a tri-axial accelerometer, with an uncertainty budget."""

from __future__ import annotations

from pathlib import Path

from mcsim.simulation.case import Case
from mcsim.simulation.problem import Problem
from mcsim.systems.velocity.scenario import VelocityScenario


def _problem(model: VelocityScenario, _: Path) -> Problem:
    from mcsim.systems.velocity.problem import VelocityProblem

    return VelocityProblem.from_model(model)


def _samples(model: VelocityScenario, _: Path) -> int:
    from mcsim.systems.velocity.steps import step_count

    return step_count(model)


CASE = Case("velocity", VelocityScenario, _problem, _samples)
