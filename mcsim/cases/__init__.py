"""Cases: one point of a scenario becomes a problem that an engine can simulate.

All cases look the same from outside: see ``Problem``.
"""

from __future__ import annotations

from pathlib import Path

from mcsim.cases.problem import History, Problem
from mcsim.errors import McsimError
from mcsim.scenario import (
    CaseScenario,
    PlanarScenario,
    StrapdownScenario,
    VelocityScenario,
)

__all__ = ["History", "Problem", "check_point", "problem_of"]


def problem_of(model: CaseScenario, folder: Path) -> Problem:
    """The problem of a validated point; relative files are looked up in ``folder``.

    Raises
    ------
    InputError
        The track cannot be built, or is shorter than one sampling interval.
    """
    if isinstance(model, PlanarScenario):
        from mcsim.cases.planar import PlanarProblem

        return PlanarProblem.from_model(model, folder)
    if isinstance(model, VelocityScenario):
        from mcsim.cases.velocity import VelocityProblem

        return VelocityProblem.from_model(model)
    if isinstance(model, StrapdownScenario):
        from mcsim.cases.level import LevelProblem
        from mcsim.cases.strapdown import StrapdownProblem

        if model.reconstruction.algorithm == "planar":
            return LevelProblem.from_model(model, folder)
        return StrapdownProblem.from_model(model, folder)
    raise _unknown(model)


def check_point(model: CaseScenario, folder: Path) -> int:
    """Samples per realization; refuses a point that cannot run, without preparing it.

    Raises
    ------
    InputError
        See ``problem_of``.
    """
    if isinstance(model, PlanarScenario):
        from mcsim.cases.planar_samples import sample_count
        from mcsim.trajectory import drive_of

        return sample_count(drive_of(model.trajectory, folder), model.sensors.rate)
    if isinstance(model, VelocityScenario):
        from mcsim.cases.velocity_steps import step_count

        return step_count(model)
    if isinstance(model, StrapdownScenario):
        from mcsim.cases.planar_samples import sample_count
        from mcsim.trajectory import drive_of
        from mcsim.trajectory.spatial import check_lean

        drive = drive_of(model.trajectory, folder)
        count = sample_count(drive, model.sensors.rate)
        check_lean(model, drive)
        return count
    raise _unknown(model)


def _unknown(model: CaseScenario) -> McsimError:
    return McsimError(f"no engine for the case {model.case}")
