"""The summary of a run on the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mcsim.results import Results, at_the_end, summarised
from mcsim.scenario.error_quantities import UNITS
from mcsim.statistics import METHOD
from mcsim.text_table import columns

if TYPE_CHECKING:
    import pandas as pd

#: A simulated deviation this many times the first order's is remarked on.
_EXCEEDS = 1.5


def summary(results: Results) -> str:
    """Estimates of a single run, one line per error, intervals in brackets."""
    table = at_the_end(results.table)
    shown = tuple(summarised(results.scenario.base))
    rows = [["error", "unit", *shown]]
    for name, estimates in table.groupby("error", sort=False):
        by_statistic = estimates.set_index("statistic")
        rows.append([str(name), str(estimates["unit"].iloc[0])])
        for statistic in shown:
            row = by_statistic.loc[statistic]
            rows[-1].append(_estimate(row, with_interval=statistic != METHOD))
    count = int(table["realizations"].iloc[0])
    behind = f"{count:,} realizations" if count else "linear model, no realizations"
    return "\n".join([*columns(rows), behind, "", *_budget_lines(results)])


def _budget_lines(results: Results) -> list[str]:
    """Where the scatter comes from: standard deviation and share of the variance by source."""
    budget = results.budget
    if budget is None or not len(budget):
        return [_no_budget(results)]
    budget = at_the_end(budget)
    errors = list(budget["error"].unique())
    rows = [["source", *(f"{name} [{UNITS[name]}]" for name in errors)]]
    for source in budget["source"].unique():
        by_error = budget[budget["source"] == source].set_index("error")
        cells = [
            f"{by_error.loc[e, 'std']:.3g} ({by_error.loc[e, 'share']:.0%})"
            if e in by_error.index
            else "–"
            for e in errors
        ]
        rows.append([str(source), *cells])
    return [*columns(rows), *_beyond_first_order(results, budget)]


def _deviations(results: Results) -> pd.DataFrame:
    """The standard deviations at the end, by error."""
    table = at_the_end(results.table)
    return table[table["statistic"] == "std"].set_index("error")


def _no_budget(results: Results) -> str:
    deviations = _deviations(results)
    if (deviations["realizations"] == 0).all():
        return "to first order nothing disturbs this run"
    if (deviations["value"] > 0.0).any():
        return "to first order nothing disturbs this run: what scatters is of higher order"
    return "nothing disturbs this run"


def _beyond_first_order(results: Results, budget: pd.DataFrame) -> list[str]:
    """Errors whose simulated deviation the budget, which is of first order, does not explain."""
    explained = (budget["std"] ** 2).groupby(budget["error"]).sum() ** 0.5
    lines = []
    for name, row in _deviations(results).iterrows():
        linear = float(explained.get(name, 0.0))
        # The interval keeps a chance excess of few realizations out.
        if row["value"] > _EXCEEDS * linear and row["ci_low"] > linear:
            unit = row["unit"]
            lines.append(
                f"{name}: the budget, of first order, explains {linear:.3g} {unit} of a standard "
                f"deviation of {row['value']:.3g} {unit}"
            )
    return ["", *lines] if lines else []


def _estimate(row: Any, with_interval: bool) -> str:
    if row["value"] != row["value"]:
        return "undefined"
    low, high = f"{row['ci_low']:.3g}", f"{row['ci_high']:.3g}"
    interval = f" [{low}, {high}]" if with_interval and low != high else ""
    return f"{row['value']:.3g}{interval}"
