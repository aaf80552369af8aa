"""A point of a planar scenario as a problem."""

from __future__ import annotations

from pathlib import Path

from mcsim.simulation.driven import driven
from mcsim.simulation.planar import PlanarProblem, initial_deviations
from mcsim.systems.planar.scenario import PlanarScenario


def planar_problem(model: PlanarScenario, folder: Path) -> PlanarProblem:
    """Truth, sampling and error model of one point.

    Raises
    ------
    InputError
        No such track, or one that is shorter than a sample or absurdly long.
    """
    drive = driven(model.trajectory, model.sensors, folder, model.reconstruction.intervals)
    return PlanarProblem(
        signals=drive.signals,
        sensor_errors=drive.sensor_errors,
        initial_deviations=initial_deviations(model.initial),
        truth=drive.truth,
        interval=drive.interval,
        rule=model.reconstruction.integration,
        previous_share=0.0 if model.sensors.sampling == "average" else 0.5,
        missing=drive.missing,
        beyond_rate=drive.beyond_rate,
    )
