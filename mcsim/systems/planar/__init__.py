"""The planar case: 2-D dead reckoning from two accelerometer axes and one gyroscope."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mcsim.scenario.idle import IdleKey, always
from mcsim.simulation.case import Case
from mcsim.simulation.problem import Problem
from mcsim.systems.planar.scenario import RULES, PlanarScenario


def _problem(model: PlanarScenario, folder: Path) -> Problem:
    from mcsim.systems.planar.problem import planar_problem

    return planar_problem(model, folder)


def _samples(model: PlanarScenario, folder: Path) -> int:
    from mcsim.simulation.planar_samples import scheduled_count
    from mcsim.tracks import drive_of

    return scheduled_count(drive_of(model.trajectory, folder), model.sensors, folder)


def _notes(model: PlanarScenario, folder: Path) -> tuple[str, ...]:
    from mcsim.simulation.planar_samples import end_notes
    from mcsim.tracks import drive_of

    return end_notes(drive_of(model.trajectory, folder), model.sensors.rate)


def _kernel() -> type[Any]:
    from mcsim.kernels.planar import Planar

    return Planar


CASE = Case(
    "planar",
    PlanarScenario,
    _problem,
    _samples,
    idle=(
        IdleKey("trajectory.pitch_positive", (), always, "no recorded pitch is used"),
        IdleKey("trajectory.columns.roll", (), always, "the planar case has no attitude"),
        IdleKey("trajectory.columns.pitch", (), always, "the planar case has no attitude"),
        IdleKey(
            "sensors.gyroscope.misalignment",
            (),
            always,
            "a level vehicle turns about one axis alone",
        ),
    ),
    rules=RULES,
    kernel=_kernel,
    notes=_notes,
)
