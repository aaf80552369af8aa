"""The velocity case: a straight run by a tri-axial accelerometer, with an uncertainty budget."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mcsim.scenario.idle import IdleKey
from mcsim.scenario.response import idle_response
from mcsim.simulation.case import Case
from mcsim.simulation.problem import Problem
from mcsim.systems.velocity.profiles import profile_of
from mcsim.systems.velocity.scenario import VelocityScenario


def _problem(model: VelocityScenario, folder: Path) -> Problem:
    from mcsim.systems.velocity.problem import VelocityProblem

    return VelocityProblem.from_model(model, folder)


def _samples(model: VelocityScenario, folder: Path) -> int:
    from mcsim.systems.velocity.steps import step_count
    from mcsim.systems.velocity.truth import true_run

    count = step_count(model, folder)
    true_run(model, folder)
    return count


def _notes(model: VelocityScenario, folder: Path) -> tuple[str, ...]:
    return profile_of(model.trajectory, folder).notes


def _raw_log(model: VelocityScenario, folder: Path) -> Mapping[str, Any] | None:
    from mcsim.systems.velocity.raw_log import raw_log

    return raw_log(model, model.monte_carlo.seed, folder=folder) if model.outputs.runs else None


CASE = Case(
    "velocity",
    VelocityScenario,
    _problem,
    _samples,
    idle=(
        *idle_response("body.pitch"),
        IdleKey(
            "body.height",
            ("body.pitch.gradient",),
            lambda model: model.body.pitch.gradient == 0.0,
            "`body.pitch.gradient` is zero: the body does not pitch",
        ),
    ),
    notes=_notes,
    raw_log=_raw_log,
)
