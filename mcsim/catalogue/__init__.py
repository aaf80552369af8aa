"""The built-in sensors, each value with its origin and source.

The data live in ``sensors.yaml`` beside this file; quantities stay as text with
their units and are parsed where they are used.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from mcsim.errors import InputError

#: Kinds of sensing element that a sensor may hold.
ELEMENTS = ("accelerometer", "gyroscope")


@dataclass(frozen=True)
class Sensor:
    """A catalogue entry; ``elements`` maps an element to its quantities as text."""

    name: str
    description: str
    origin: str
    source: str
    elements: Mapping[str, Mapping[str, Any]]


@cache
def sensors() -> dict[str, Sensor]:
    """All built-in sensors by name."""
    from ruamel.yaml import YAML

    text = files("mcsim.catalogue").joinpath("sensors.yaml").read_text(encoding="utf-8")
    data = YAML(typ="safe", pure=True).load(text)
    return {
        name: Sensor(
            name=name,
            description=entry["description"],
            origin=entry["origin"],
            source=" ".join(data["sources"][entry["source"]].split()),
            elements={e: entry[e] for e in ELEMENTS if e in entry},
        )
        for name, entry in data["sensors"].items()
    }


def find(name: str) -> Sensor:
    """The sensor of that name (case does not matter).

    Raises
    ------
    InputError
        No such sensor; the message names the closest one.
    """
    by_folded = {known.casefold(): sensor for known, sensor in sensors().items()}
    folded = name.casefold()
    if folded in by_folded:
        return by_folded[folded]
    close = difflib.get_close_matches(folded, by_folded, n=1)
    hint = f'; did you mean "{by_folded[close[0]].name}"?' if close else ""
    raise InputError(f'no sensor "{name}" in the catalogue{hint} (it holds {", ".join(sensors())})')


def element(name: str, kind: str) -> Mapping[str, Any]:
    """The quantities of one element (``accelerometer`` or ``gyroscope``) of a sensor.

    Raises
    ------
    InputError
        No such sensor, or it has no such element.
    """
    sensor = find(name)
    if kind not in sensor.elements:
        with_it = ", ".join(s.name for s in sensors().values() if kind in s.elements)
        raise InputError(f"{sensor.name} has no {kind} (sensors that have one: {with_it})")
    return sensor.elements[kind]
