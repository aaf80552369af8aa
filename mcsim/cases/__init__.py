"""Cases: one point of a scenario becomes a problem that an engine can simulate.

All cases look the same from outside: see ``Problem``.
"""

from __future__ import annotations

from pathlib import Path

from mcsim.cases.problem import History, Problem
from mcsim.scenario import PlanarScenario

__all__ = ["History", "Problem", "check_point", "problem_of"]


def problem_of(model: PlanarScenario, folder: Path) -> Problem:
    """The problem of a validated point; relative files are looked up in ``folder``.

    Raises
    ------
    InputError
        The track cannot be built, or is shorter than one sampling interval.
    """
    from mcsim.cases.planar import PlanarProblem

    return PlanarProblem.from_model(model, folder)


def check_point(model: PlanarScenario, folder: Path) -> int:
    """Samples per realization; refuses a point that cannot run, without preparing it.

    Raises
    ------
    InputError
        See ``problem_of``.
    """
    from mcsim.cases.planar import sample_count
    from mcsim.trajectory import drive_of

    return sample_count(drive_of(model.trajectory, folder), model.sensors.rate)
