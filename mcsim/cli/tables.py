"""Tables printed to the terminal."""

from __future__ import annotations

from typing import Any

from mcsim import catalogue
from mcsim.results import Results

_QUANTITIES = {"range": "range", "noise_density": "noise density", "rate": "largest rate"}


def summary(results: Results) -> str:
    """Estimates of a single run, one line per error."""
    table = results.table
    statistics = ["mean", "std", "rms", "p95", "method"]
    lines = [_line("error", "unit", statistics)]
    for name, rows in table.groupby("error", sort=False):
        by_statistic = rows.set_index("statistic")
        cells = []
        for statistic in statistics:
            row = by_statistic.loc[statistic]
            text = f"{row['value']:.4g}"
            if statistic != "method":
                text += f" [{row['ci_low']:.3g}, {row['ci_high']:.3g}]"
            cells.append(text)
        lines.append(_line(str(name), str(rows["unit"].iloc[0]), cells))
    lines.append(f"{int(table['realizations'].iloc[0]):,} realizations")
    return "\n".join(lines)


def _line(name: str, unit: str, cells: list[str]) -> str:
    return f"{name:<9} {unit:<4} " + " ".join(f"{cell:<27}" for cell in cells).rstrip()


def sensor_list() -> str:
    """One line per built-in sensor."""
    rows = [(s.name, ", ".join(s.elements), s.description) for s in catalogue.sensors().values()]
    widths = [max(len(row[i]) for row in rows) for i in range(2)]
    return "\n".join(
        f"{name:<{widths[0]}}  {elements:<{widths[1]}}  {description}"
        for name, elements, description in rows
    )


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
