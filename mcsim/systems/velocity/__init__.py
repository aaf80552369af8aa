"""The velocity case: a straight run by a tri-axial accelerometer, with an uncertainty budget."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mcsim.simulation.case import Case
from mcsim.simulation.problem import Problem
from mcsim.systems.velocity.scenario import VelocityScenario


def _problem(model: VelocityScenario, _: Path) -> Problem:
    from mcsim.systems.velocity.problem import VelocityProblem

    return VelocityProblem.from_model(model)


def _samples(model: VelocityScenario, _: Path) -> int:
    from mcsim.systems.velocity.steps import step_count

    return step_count(model)


def _raw_log(model: VelocityScenario) -> Mapping[str, Any] | None:
    from mcsim.systems.velocity.raw_log import raw_log

    return raw_log(model, model.monte_carlo.seed) if model.outputs.runs else None


CASE = Case("velocity", VelocityScenario, _problem, _samples, raw_log=_raw_log)
