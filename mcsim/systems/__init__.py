"""The cases: a folder each, and a line here; ``mcsim.simulation.case`` tells what they must say."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mcsim.errors import InputError
from mcsim.registry import Registry
from mcsim.scenario.case import CaseScenario
from mcsim.scenario.error_quantities import ERROR_QUANTITIES
from mcsim.simulation.case import Case
from mcsim.simulation.problem import Problem

#: A run imports the case that it simulates, and no other.
SYSTEMS: Registry[Case] = Registry(
    "case",
    later={
        "planar": "mcsim.systems.planar:CASE",
        "velocity": "mcsim.systems.velocity:CASE",
        "strapdown": "mcsim.systems.strapdown:CASE",
    },
)


def _bring_quantities(case: Case) -> None:
    for quantity in case.quantities:
        ERROR_QUANTITIES.add(quantity)
    unknown = [name for name in case.scenario.ERRORS if name not in ERROR_QUANTITIES]
    if unknown:
        raise InputError(
            f"{case.name}: nobody knows its error {unknown[0]}; give the case an "
            "`ErrorQuantity` with its unit and words"
        )


SYSTEMS.tell(_bring_quantities)


def problem_of(model: CaseScenario, folder: Path) -> Problem:
    """The problem of a validated point; relative files are looked up in ``folder``.

    Raises
    ------
    InputError
        The track cannot be built, or is shorter than one sampling interval.
    """
    return SYSTEMS[model.case].problem(model, folder)


def notes_of(model: CaseScenario, folder: Path) -> tuple[str, ...]:
    """What a user should know of where a point's truth comes from.

    Raises
    ------
    InputError
        See ``problem_of``.
    """
    return SYSTEMS[model.case].notes(model, folder)


def check_point(model: CaseScenario, folder: Path) -> int:
    """Samples per realization; refuses a point that cannot run, without preparing it.

    Raises
    ------
    InputError
        See ``problem_of``.
    """
    return SYSTEMS[model.case].samples(model, folder)


def raw_log_of(model: CaseScenario, folder: Path) -> Mapping[str, Any] | None:
    """Columns by title of what the sensors of a point would have recorded, if it asks for them."""
    make = SYSTEMS[model.case].raw_log
    return None if make is None else make(model, folder)
