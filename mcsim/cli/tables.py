"""Tables printed to the terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from mcsim import catalogue
from mcsim.results import Results, at_the_end, summarised
from mcsim.scenario import UNITS
from mcsim.statistics import METHOD

if TYPE_CHECKING:
    import pandas as pd

#: A simulated deviation this many times the first order's is remarked on.
_EXCEEDS = 1.5
_LISTED = {"noise_density": "noise density", "range": "range", "bandwidth": "bandwidth"}


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


def sensor_list() -> str:
    """One line per built-in sensor and element: what a scenario takes from it."""
    rows = [["sensor", "element", *_LISTED.values(), "origin", ""]]
    for sensor in catalogue.sensors().values():
        for element, quantities in sensor.elements.items():
            cells = [_value(quantities.get(key, "–")) for key in _LISTED]
            rows.append([sensor.name, element, *cells, sensor.origin, sensor.description])
    return "\n".join(columns(rows))


def budget_summary(table: pd.DataFrame) -> str:
    """An uncertainty budget, one line per row."""
    rows = [list(map(str, table.columns))]
    rows += [
        ["" if value is None or value != value else _short(value) for value in row]
        for row in table.astype(object).where(table.notna(), None).itertuples(index=False)
    ]
    return "\n".join(columns(rows))


def _short(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def columns(rows: list[list[str]]) -> list[str]:
    """Lines with the cells of each column padded to the same width."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def sensor_details(name: str) -> str:
    """Everything the catalogue knows about one sensor, source by source."""
    sensor = catalogue.find(name)
    lines = [f"{sensor.name}: {sensor.description} ({sensor.origin})"]
    for element, quantities in sensor.elements.items():
        known = {key: quantities.get(key) for key in dict.fromkeys([*_LISTED, *quantities])}
        lines += [f"  {element}, as a scenario takes it", *_quantities(known)]
        for record in sensor.records[element]:
            lines += [f"  {element}, {record.origin}", *_quantities(record.quantities)]
            lines += _paragraph(f"source: {record.citation}")
            lines += _paragraph(f"note: {record.note}") if record.note is not None else []
    return "\n".join(lines)


def _paragraph(text: str) -> list[str]:
    return textwrap.wrap(text, 96, initial_indent="    ", subsequent_indent="      ")


def _quantities(quantities: Mapping[str, Any]) -> list[str]:
    rows = [[f"    {key.replace('_', ' ')}", _value(value)] for key, value in quantities.items()]
    return columns(rows)


def _value(value: Any) -> str:
    if value is None:
        return "not given by the source"
    if isinstance(value, list):
        return _joined(value, " / " if len(value) == 3 else " … ")
    return str(value)


def _joined(values: list[Any], sign: str) -> str:
    """Quantities in a row; the unit that all of them have is said once."""
    numbers, units = zip(*(str(value).partition(" ")[::2] for value in values), strict=True)
    if len(set(units)) > 1:
        return sign.join(map(str, values))
    return f"{sign.join(numbers)} {units[0]}".rstrip()
