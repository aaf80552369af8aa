"""Built-in sensors on the terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

from mcsim import catalogue
from mcsim.text_table import columns

_LISTED = {"noise_density": "noise density", "range": "range", "bandwidth": "bandwidth"}


def sensor_list() -> str:
    """One line per built-in sensor and element: what a scenario takes from it."""
    rows = [["sensor", "element", *_LISTED.values(), "origin", ""]]
    for sensor in catalogue.sensors().values():
        for element, quantities in sensor.elements.items():
            cells = [_value(quantities.get(key, "–")) for key in _LISTED]
            rows.append([sensor.name, element, *cells, sensor.origin, sensor.description])
    return "\n".join(columns(rows))


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
