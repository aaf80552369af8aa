"""The budget and the comparison as tables, and what the numbers say in words."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from mcsim.gum.budget import Budget
from mcsim.gum.course import Course

if TYPE_CHECKING:
    import pandas as pd

BUDGET_COLUMNS = (
    "i",
    "quantity",
    "estimate",
    "uncertainty",
    "equation",
    "sensitivity",
    "variance",
    "printed",
    "ratio",
)


def budget_table(budget: Budget, course: Course) -> pd.DataFrame:
    """Columns ``BUDGET_COLUMNS``: the 26 rows, then totals with their equations.

    Totals hold the combined standard uncertainty; ``ratio`` is variance to printed variance.
    """
    import pandas as pd

    rows: list[tuple[Any, ...]] = [
        (
            row.number,
            row.quantity,
            row.estimate,
            row.uncertainty,
            row.equation,
            row.sensitivity,
            row.variance,
            row.printed if row.printed is not None else math.nan,
            row.variance / row.printed if row.printed is not None else math.nan,
        )
        for row in budget.rows
    ]
    names = {"acx": "(26)", "acz": "(27)", "theta": "(28)", "Dv": "(29)"}
    totals = [
        (f"u({name})", budget.estimates[name], budget.uncertainty(name), equation)
        for name, equation in names.items()
    ]
    end = float(course.truth[-1])
    totals.append(("uc(vX,N)", end, float(course.summed_total[-1]), "(30)"))
    if course.runs > 1:
        totals.append(("uc(mean vX,N)", end, float(course.summed_mean[-1]), "(31)"))
    nothing = math.nan
    rows += [
        (None, name, value, u, equation, nothing, u**2, nothing, nothing)
        for name, value, u, equation in totals
    ]
    table = pd.DataFrame(rows, columns=list(BUDGET_COLUMNS))
    return table.astype({"i": "Int64"})


def comparison_table(course: Course) -> pd.DataFrame:
    """Columns ``time [s], method, of, source, uncertainty [m/s]``; one row per step."""
    import pandas as pd

    frames = [
        pd.DataFrame(
            {
                "time [s]": course.time,
                "method": method,
                "of": of,
                "source": source,
                "uncertainty [m/s]": values,
            }
        )
        for method, of, source, values in _curves(course)
    ]
    return pd.concat(frames, ignore_index=True)


def _curves(course: Course) -> Iterator[tuple[str, str, str, np.ndarray]]:
    run, mean = "one run", f"mean of {course.runs} runs"
    yield "Eq. (30)", run, "all", course.summed_total
    if course.runs > 1:
        yield "Eq. (31)", mean, "all", course.summed_mean
    yield "Monte Carlo", run, "all", course.total
    if course.runs > 1:
        yield "Monte Carlo", mean, "all", course.total_mean
        method = "measured" if course.measured else "Monte Carlo"
        yield method, "scatter of the runs", "all", course.scatter
    for source, values in course.summed.items():
        yield "Eq. (30)", run, source, values
    for source, values in course.simulated.items():
        yield "Monte Carlo", run, source, values
    interaction = np.sign(course.interaction) * np.sqrt(np.abs(course.interaction))
    yield "Monte Carlo", run, "interaction (signed root of the variance)", interaction
