"""Tables printed to the terminal."""

from __future__ import annotations

from typing import Any

from mcsim import catalogue
from mcsim.results import Results, at_the_end
from mcsim.scenario import UNITS

_SUMMARY = ("mean", "std", "rms", "p95", "method")
_QUANTITIES = {"range": "range", "noise_density": "noise density", "rate": "largest rate"}


def summary(results: Results) -> str:
    """Estimates of a single run, one line per error, intervals in brackets."""
    table = at_the_end(results.table)
    rows = [["error", "unit", *_SUMMARY]]
    for name, estimates in table.groupby("error", sort=False):
        by_statistic = estimates.set_index("statistic")
        rows.append([str(name), str(estimates["unit"].iloc[0])])
        for statistic in _SUMMARY:
            row = by_statistic.loc[statistic]
            rows[-1].append(_estimate(row, with_interval=statistic != "method"))
    count = int(table["realizations"].iloc[0])
    behind = f"{count:,} realizations" if count else "linear model, no realizations"
    return "\n".join([*columns(rows), behind, "", *_budget_lines(results)])


def _budget_lines(results: Results) -> list[str]:
    """Where the scatter comes from: standard deviation and share of the variance by source."""
    budget = results.budget
    if budget is None or not len(budget):
        return ["nothing disturbs this run"]
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
    return columns(rows)


def _estimate(row: Any, with_interval: bool) -> str:
    if row["value"] != row["value"]:
        return "undefined"
    low, high = f"{row['ci_low']:.3g}", f"{row['ci_high']:.3g}"
    interval = f" [{low}, {high}]" if with_interval and low != high else ""
    return f"{row['value']:.3g}{interval}"


def sensor_list() -> str:
    """One line per built-in sensor."""
    return "\n".join(
        columns(
            [[s.name, ", ".join(s.elements), s.description] for s in catalogue.sensors().values()]
        )
    )


def columns(rows: list[list[str]]) -> list[str]:
    """Lines with the cells of each column padded to the same width."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def sensor_details(name: str) -> str:
    """Everything the catalogue knows about one sensor."""
    sensor = catalogue.find(name)
    lines = [f"{sensor.name}: {sensor.description}"]
    for element, quantities in sensor.elements.items():
        lines.append(f"  {element}")
        lines += [
            f"    {_QUANTITIES.get(key, key):<15} {_value(quantities.get(key))}"
            for key in dict.fromkeys([*_QUANTITIES, *quantities])
        ]
    lines += [f"  origin: {sensor.origin}", f"  source: {sensor.source}"]
    return "\n".join(lines)


def _value(value: Any) -> str:
    if value is None:
        return "not given by the source"
    if isinstance(value, list):
        return " … ".join(dict.fromkeys(map(str, value)))
    return str(value)
