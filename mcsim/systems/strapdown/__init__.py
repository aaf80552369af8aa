"""The strapdown case: 3-D dead reckoning from three accelerometer axes and three gyroscopes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mcsim.scenario.idle import IdleKey
from mcsim.scenario.response import idle_response
from mcsim.simulation.case import Case
from mcsim.simulation.problem import Problem
from mcsim.systems.strapdown.scenario import RULES, StrapdownScenario


def _problem(model: StrapdownScenario, folder: Path) -> Problem:
    if model.reconstruction.algorithm == "planar":
        from mcsim.systems.strapdown.level import LevelProblem

        return LevelProblem.from_model(model, folder)
    from mcsim.systems.strapdown.problem import StrapdownProblem

    return StrapdownProblem.from_model(model, folder)


def _samples(model: StrapdownScenario, folder: Path) -> int:
    from mcsim.simulation.planar_samples import sample_count
    from mcsim.systems.strapdown.truth import check_lean
    from mcsim.tracks import drive_of

    drive = drive_of(model.trajectory, folder)
    count = sample_count(drive, model.sensors.rate)
    check_lean(model, drive)
    return count


def _kernel() -> type[Any]:
    from mcsim.kernels.strapdown import Strapdown

    return Strapdown


def _takes_for_level(model: StrapdownScenario) -> bool:
    return model.reconstruction.algorithm == "planar"


CASE = Case(
    "strapdown",
    StrapdownScenario,
    _problem,
    _samples,
    idle=(
        IdleKey(
            "initial.levelling",
            ("reconstruction.algorithm",),
            _takes_for_level,
            "the planar algorithm takes the vehicle for level",
        ),
        IdleKey(
            "trajectory.pitch_positive",
            ("trajectory.columns",),
            lambda model: not model.records_attitude,
            "no recorded pitch is used",
        ),
        *idle_response("body.roll"),
        *idle_response("body.pitch"),
    ),
    rules=RULES,
    kernel=_kernel,
)
