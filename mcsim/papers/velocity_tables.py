"""``mcsim table velocity``: Tables 2 to 4 of the velocity paper."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from mcsim.papers import Computed, PaperTable
from mcsim.papers.shipped import VELOCITY_SENSORS, velocity_sensor
from mcsim.text_table import frame_text

if TYPE_CHECKING:
    import pandas as pd

#: Table 2, after 1.5 s: largest error of twelve runs and error of their mean (both measured
#: once, against a wheel encoder), uc of the mean, s(v) of the twelve.
_TABLE_2 = {"a1": (0.04, -0.01, 0.02, 0.006), "a2": (0.06, 0.01, 0.04, 0.009)}
#: Top speeds that agree with Table 2; the one of the run is not printed.
_TOP_SPEEDS = ("0.3 m/s", "0.4 m/s", "0.5 m/s")
#: Groups of runs simulated for Table 2, and the shares of them between which 95 % lie.
GROUPS, _ENDS = 2000, (2.5, 50.0, 97.5)


def velocity_tables() -> Computed:
    """Tables 2, 3 and 4, printed and computed."""
    from mcsim.gum import course_of_uncertainty, step_budget
    from mcsim.gum.tables import budget_table

    tables: dict[str, pd.DataFrame] = {"table2": table_2()}
    for name, number in zip(VELOCITY_SENSORS, (3, 4), strict=True):
        _, model = velocity_sensor(name)
        tables[f"table{number}"] = budget_table(step_budget(model), course_of_uncertainty(model))
    texts = [f"{name}\n{frame_text(table)}\n" for name, table in tables.items()]
    return Computed(tables, "\n".join(texts))


def table_2() -> pd.DataFrame:
    """Table 2 after 1.5 s: printed values beside ours, for the top speeds that agree with it.

    What the source measured on one group of twelve runs stands beside the simulated distribution
    of the same quantity over groups: its median, and the ends between which 95 % of the groups
    lie.  What the source computed, uc, stands beside the same equation.  The error that sampling
    and integration alone make, which nobody measured, has a row of its own.
    """
    import pandas as pd

    rows: list[tuple[Any, ...]] = []
    for name in VELOCITY_SENSORS:
        for speed in _TOP_SPEEDS:
            rows += [(name.upper(), speed, *row) for row in rows_of_table_2(name, speed)]
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


def rows_of_table_2(name: str, speed: str) -> Iterator[tuple[Any, ...]]:
    """Quantity, printed, computed, the ends of 95 % of the groups, and what kinds these are."""
    from mcsim.engine import point_key
    from mcsim.gum import course_of_uncertainty
    from mcsim.systems.velocity.problem import VelocityProblem

    largest, of_mean, uc, scatter = _TABLE_2[name]
    nothing = math.nan
    for label, errors in (("time stamps err", "stamps"), ("intervals err", "independent")):
        _, model = velocity_sensor(name, trajectory__top_speed=speed, sensor__time_errors=errors)
        problem = VelocityProblem.from_model(model)
        runs = problem.velocities(point_key(model.monte_carlo, ()), 0, GROUPS)[-1]
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


TABLE = PaperTable(
    "velocity",
    "Tables 2, 3 and 4 of the velocity paper, printed and computed.",
    velocity_tables,
    files=("table2", "table3", "table4"),
    folder="velocity-tables",
    output="output",
)
