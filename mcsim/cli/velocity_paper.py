"""Figures 10 to 14 and Tables 2 to 4 of the velocity paper."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from mcsim.cli.paper import shipped_scenarios

if TYPE_CHECKING:
    import pandas as pd

    from mcsim.scenario_file import Scenario
    from mcsim.systems.velocity.scenario import VelocityScenario

SENSORS = ("a1", "a2")
#: Table 2, after 1.5 s: largest error of twelve runs and error of their mean (both measured
#: once, against a wheel encoder), uc of the mean, s(v) of the twelve.
_TABLE_2 = {"a1": (0.04, -0.01, 0.02, 0.006), "a2": (0.06, 0.01, 0.04, 0.009)}
#: Top speeds that agree with Table 2; the one of the run is not printed.
_TOP_SPEEDS = ("0.3 m/s", "0.4 m/s", "0.5 m/s")


def draw_figure(number: int, output: Path) -> list[Path]:
    """Write the figure and its table into ``output/figureN``; the pictures."""
    return FIGURES[number](output / f"figure{number}")


def _scenario(name: str, **overrides: str) -> tuple[Scenario, VelocityScenario]:
    from mcsim.scenario_file import Scenario
    from mcsim.systems.velocity.scenario import VelocityScenario

    path = shipped_scenarios() / "velocity" / f"{name}.yaml"
    scenario = Scenario.from_yaml(path, {k.replace("__", "."): v for k, v in overrides.items()})
    assert isinstance(scenario.base, VelocityScenario)
    return scenario, scenario.base


def _runs(name: str) -> Callable[[Path], list[Path]]:
    """Figures 10 and 11: twelve runs with their mean; the mean with its uncertainty."""

    def draw(folder: Path) -> list[Path]:
        import numpy as np
        import pandas as pd

        from mcsim.cli.budget import write_budget
        from mcsim.engine import point_key
        from mcsim.figures import write_figure
        from mcsim.figures.budget import draw_runs
        from mcsim.gum import course_of_uncertainty
        from mcsim.store import write_table
        from mcsim.systems.velocity.problem import VelocityProblem

        scenario, model = _scenario(name)
        problem = VelocityProblem.from_model(model)
        course = course_of_uncertainty(model)
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
        write_table(table, folder, "table")
        title = scenario.base.title or name
        figure = draw_runs(course.time, runs, course.truth, course.summed_mean, title)
        write_budget(scenario, folder / "budget")
        return write_figure(figure, folder, "figure")

    return draw


def _linearity(folder: Path) -> list[Path]:
    """Figure 12: simulated over reference acceleration."""
    import pandas as pd

    from mcsim.cli.calibrate import linearity_of, linearity_table
    from mcsim.figures import write_figure
    from mcsim.figures.linearity import draw_linearity
    from mcsim.store import write_table

    paths = [shipped_scenarios() / "velocity" / f"{name}.yaml" for name in SENSORS]
    fits = [linearity_of(path, None, 1) for path in paths]
    names = [name.upper() for name in SENSORS]
    tables = [
        linearity_table(fit).assign(sensor=name) for fit, name in zip(fits, names, strict=True)
    ]
    write_table(pd.concat(tables, ignore_index=True), folder, "table")
    return write_figure(draw_linearity(fits, names), folder, "figure")


def _shares(output: Literal["Dv", "acx"], title: str) -> Callable[[Path], list[Path]]:
    """Figures 13 and 14: shares of the variance of a step's velocity change, and of acx."""

    def draw(folder: Path) -> list[Path]:
        import pandas as pd

        from mcsim.figures import write_figure
        from mcsim.figures.budget import draw_shares
        from mcsim.gum import step_budget
        from mcsim.store import write_table

        budgets = [step_budget(_scenario(name)[1]) for name in SENSORS]
        names = [name.upper() for name in SENSORS]
        table = pd.DataFrame(
            [
                (name, row.number, row.quantity, row.variance / budget.uncertainty(output) ** 2)
                for name, budget in zip(names, budgets, strict=True)
                for row in budget.group(output)
            ],
            columns=["sensor", "i", "quantity", "share"],
        )
        write_table(table, folder, "table")
        return write_figure(draw_shares(budgets, names, output, title), folder, "figure")

    return draw


FIGURES: dict[int, Callable[[Path], list[Path]]] = {
    10: _runs("a1"),
    11: _runs("a2"),
    12: _linearity,
    13: _shares("Dv", "Shares of the variance of the velocity change of one step"),
    14: _shares("acx", "Shares of the variance of the corrected acceleration acx"),
}


#: Groups of runs simulated for Table 2, and the shares of them between which 95 % lie.
_GROUPS, _ENDS = 2000, (2.5, 50.0, 97.5)


def table_2() -> pd.DataFrame:
    """Table 2 after 1.5 s: printed values beside ours, for the top speeds that agree with it.

    What the source measured on one group of twelve runs stands beside the simulated distribution
    of the same quantity over groups: its median, and the ends between which 95 % of the groups
    lie.  What the source computed, uc, stands beside the same equation.  The error that sampling
    and integration alone make, which nobody measured, has a row of its own.
    """
    import pandas as pd

    rows: list[tuple[Any, ...]] = []
    for name in SENSORS:
        for speed in _TOP_SPEEDS:
            rows += [(name.upper(), speed, *row) for row in _rows_of_table_2(name, speed)]
    return pd.DataFrame(
        rows,
        columns=[
            "sensor",
            "top speed",
            "quantity [m/s]",
            "printed",
            "computed",
            "2.5 % of groups",
            "97.5 % of groups",
            "kind",
        ],
    )


def _rows_of_table_2(name: str, speed: str) -> Iterator[tuple[Any, ...]]:
    import numpy as np

    from mcsim.engine import point_key
    from mcsim.gum import course_of_uncertainty
    from mcsim.systems.velocity.problem import VelocityProblem

    largest, of_mean, uc, scatter = _TABLE_2[name]
    nothing = math.nan
    for label, errors in (("time stamps err", "stamps"), ("intervals err", "independent")):
        _, model = _scenario(name, trajectory__top_speed=speed, sensor__time_errors=errors)
        problem = VelocityProblem.from_model(model)
        runs = problem.velocities(point_key(model.monte_carlo, ()), 0, _GROUPS)[-1]
        runs = runs - problem.truth[-1]
        for quantity, printed, values in (
            (f"largest |error| of {len(runs)} runs", largest, np.abs(runs).max(axis=0)),
            (f"error of the mean of {len(runs)} runs", of_mean, runs.mean(axis=0)),
            (f"s(v) of {len(runs)} runs", scatter, runs.std(axis=0, ddof=1)),
        ):
            low, median, high = np.percentile(values, _ENDS)
            kind = "measured once | simulated, median"
            yield f"{quantity}, {label}", printed, median, low, high, kind
    course = course_of_uncertainty(model)
    kind = "computed | computed"
    yield "uc of the mean, Eq. (31)", uc, float(course.summed_mean[-1]), nothing, nothing, kind
    method = float(problem.method_errors()[-3])
    yield "error of the method", nothing, method, nothing, nothing, "– | computed, no sensor error"


@click.command("velocity")
@click.option("--quiet", is_flag=True, help="No table on the terminal.")
@click.option(
    "--output", type=click.Path(path_type=Path), default=Path("output"), show_default=True
)
def velocity_tables(output: Path, quiet: bool) -> None:
    """Tables 2, 3 and 4 of the velocity paper, printed and computed."""

    from mcsim.cli.tables import budget_summary
    from mcsim.gum import course_of_uncertainty, step_budget
    from mcsim.gum.tables import budget_table
    from mcsim.store import write_table

    tables: dict[str, pd.DataFrame] = {"table2": table_2()}
    for name, number in zip(SENSORS, (3, 4), strict=True):
        _, model = _scenario(name)
        tables[f"table{number}"] = budget_table(step_budget(model), course_of_uncertainty(model))
    for name, table in tables.items():
        write_table(table, output / "velocity-tables", name)
        if not quiet:
            click.echo(f"{name}\n{budget_summary(table)}\n")
