"""Figures 10 to 14 of the velocity paper."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from mcsim.figures.style import printed
from mcsim.papers import PaperFigure
from mcsim.papers.shipped import VELOCITY_SENSORS, shipped_scenarios, velocity_sensor
from mcsim.provenance import provenance_of
from mcsim.report import Report

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

_NAMES = [name.upper() for name in VELOCITY_SENSORS]


def _files(*sensors: str) -> list[Path]:
    return [shipped_scenarios() / "velocity" / f"{name}.yaml" for name in sensors]


def _written(
    number: str, sensors: tuple[str, ...], table: pd.DataFrame, figure: Figure, folder: Path
) -> list[Path]:
    """Write a figure and its table; the picture."""
    Report(
        provenance=provenance_of(f"figures {number}", _files(*sensors)),
        tables={"table": table},
        pictures=printed(figure, "figure"),
    ).write(folder)
    return [folder / "figure.png"]


def _runs(number: str, name: str) -> PaperFigure:
    """Figures 10 and 11: twelve runs with their mean; the mean with its uncertainty."""

    def make(folder: Path) -> list[Path]:
        import numpy as np
        import pandas as pd

        from mcsim.api.budget import budget
        from mcsim.engine import point_key
        from mcsim.figures.budget import draw_runs
        from mcsim.systems.velocity.problem import VelocityProblem

        scenario, model = velocity_sensor(name)
        found = budget(scenario)
        course = found.course
        problem = VelocityProblem.from_model(model)
        runs = problem.velocities(point_key(model.monte_carlo, ()), 0, 1)[:, :, 0]
        runs = np.concatenate([np.zeros((1, runs.shape[1])), runs])
        columns = {f"run {i + 1} [m/s]": run for i, run in enumerate(runs.T)}
        table = pd.DataFrame(
            {
                "time [s]": course.time,
                "true [m/s]": course.truth,
                **columns,
                "mean [m/s]": runs.mean(axis=1),
                "uc of the mean [m/s]": course.summed_mean,
            }
        )
        title = scenario.base.title or name
        figure = draw_runs(course.time, runs, course.truth, course.summed_mean, title)
        pictures = _written(number, (name,), table, figure, folder)
        found.write(folder / "budget")
        return pictures

    return PaperFigure(number, make=make)


def _linearity(folder: Path) -> list[Path]:
    """Figure 12: simulated over reference acceleration."""
    import pandas as pd

    from mcsim.api.linearity import linearity
    from mcsim.figures.linearity import draw_linearity

    tests = [linearity(path) for path in _files(*VELOCITY_SENSORS)]
    tables = [test.table.assign(sensor=name) for test, name in zip(tests, _NAMES, strict=True)]
    table = pd.concat(tables, ignore_index=True)
    figure = draw_linearity([test.fit for test in tests], _NAMES)
    return _written("12", VELOCITY_SENSORS, table, figure, folder)


def _shares(number: str, output: Literal["Dv", "acx"], title: str) -> PaperFigure:
    """Figures 13 and 14: shares of the variance of a step's velocity change, and of acx."""

    def make(folder: Path) -> list[Path]:
        import pandas as pd

        from mcsim.figures.budget import draw_shares
        from mcsim.gum import step_budget

        budgets = [step_budget(velocity_sensor(name)[1]) for name in VELOCITY_SENSORS]
        table = pd.DataFrame(
            [
                (name, row.number, row.quantity, row.variance / budget.uncertainty(output) ** 2)
                for name, budget in zip(_NAMES, budgets, strict=True)
                for row in budget.group(output)
            ],
            columns=["sensor", "i", "quantity", "share"],
        )
        figure = draw_shares(budgets, _NAMES, output, title)
        return _written(number, VELOCITY_SENSORS, table, figure, folder)

    return PaperFigure(number, make=make)


FIGURE_10 = _runs("10", "a1")
FIGURE_11 = _runs("11", "a2")
FIGURE_12 = PaperFigure("12", make=_linearity)
FIGURE_13 = _shares("13", "Dv", "Shares of the variance of the velocity change of one step")
FIGURE_14 = _shares("14", "acx", "Shares of the variance of the corrected acceleration acx")
