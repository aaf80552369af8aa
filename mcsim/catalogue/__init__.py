"""The built-in sensors, each value with its origin and source.

The data live in ``sensors.yaml`` beside this file; quantities stay as text with
their units and are parsed where they are used.  An element has the values that a
scenario takes, and beside them the records of its sources, data sheet and measured
told apart.
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
#: What a sensing element is, beside its quantities: how many axes it has, and whether it passes
#: constant accelerations (``coupling: AC`` does not).
TRAITS = ("axes", "coupling")
#: Kinds of record that an element may hold, by their key in the file.
ORIGINS = {"data_sheet": "data sheet", "measured": "measured"}


@dataclass(frozen=True)
class Record:
    """What one source says about an element.

    ``origin`` is ``data sheet`` or ``measured``; ``quantities`` are texts with units under the
    source's own words, a list [x, y, z] where it tells the axes apart; ``note`` says where
    the source contradicts itself or another one.
    """

    origin: str
    source: str
    citation: str
    quantities: Mapping[str, Any]
    note: str | None


@dataclass(frozen=True)
class Sensor:
    """A catalogue entry.

    ``elements`` maps an element to the quantities that a scenario takes, as text;
    ``records`` to what its sources print; ``traits`` are what an element is, see ``TRAITS``.
    """

    name: str
    description: str
    origin: str
    elements: Mapping[str, Mapping[str, Any]]
    records: Mapping[str, tuple[Record, ...]]
    traits: Mapping[str, Mapping[str, Any]]

    def axes(self, element: str) -> int:
        """Axes of an element: three, or one."""
        return int(self.traits[element].get("axes", 3))

    def rate(self, element: str) -> str | None:
        """Output rate with its unit: as measured, else by the data sheet, else nobody's."""
        said = [r for r in self.records[element] if "rate" in r.quantities]
        rates = {record.origin: str(record.quantities["rate"]) for record in said}
        return rates.get(ORIGINS["measured"]) or rates.get(ORIGINS["data_sheet"])

    def ac_coupled(self, element: str) -> bool:
        """Whether an element passes no constant acceleration, such as gravity."""
        return self.traits[element].get("coupling") == "AC"


@cache
def sensors() -> dict[str, Sensor]:
    """All built-in sensors by name."""
    from ruamel.yaml import YAML

    text = files("mcsim.catalogue").joinpath("sensors.yaml").read_text(encoding="utf-8")
    data = YAML(typ="safe", pure=True).load(text)
    return {name: _sensor(name, entry, data["sources"]) for name, entry in data["sensors"].items()}


def _sensor(name: str, entry: Mapping[str, Any], sources: Mapping[str, str]) -> Sensor:
    blocks = {element: entry[element] for element in ELEMENTS if element in entry}
    return Sensor(
        name=name,
        description=entry["description"],
        origin=entry["origin"],
        elements={
            element: {k: v for k, v in block.items() if k not in ORIGINS and k not in TRAITS}
            for element, block in blocks.items()
        },
        records={element: _records(block, sources) for element, block in blocks.items()},
        traits={e: {k: v for k, v in b.items() if k in TRAITS} for e, b in blocks.items()},
    )


def _records(block: Mapping[str, Any], sources: Mapping[str, str]) -> tuple[Record, ...]:
    return tuple(
        Record(
            origin=words,
            source=record["source"],
            citation=" ".join(sources[record["source"]].split()),
            quantities={k: v for k, v in record.items() if k not in ("source", "note")},
            note=" ".join(record["note"].split()) if "note" in record else None,
        )
        for key, words in ORIGINS.items()
        for record in block.get(key, ())
    )


def known(name: str) -> Sensor | None:
    """The sensor of that name (case does not matter), if there is one."""
    return _by_folded_name().get(name.casefold())


@cache
def _by_folded_name() -> dict[str, Sensor]:
    return {name.casefold(): sensor for name, sensor in sensors().items()}


def find(name: str) -> Sensor:
    """The sensor of that name (case does not matter).

    Raises
    ------
    InputError
        No such sensor; the message names the closest one.
    """
    sensor = known(name)
    if sensor is not None:
        return sensor
    by_folded, folded = _by_folded_name(), name.casefold()
    close = difflib.get_close_matches(folded, by_folded, n=1)
    hint = f'; did you mean "{by_folded[close[0]].name}"?' if close else ""
    raise InputError(f'no sensor "{name}" in the catalogue{hint} (it holds {", ".join(sensors())})')


def element(name: str, kind: str) -> Mapping[str, Any]:
    """The quantities that a scenario takes from one element of a sensor.

    Parameters
    ----------
    name : str
        The sensor; case does not matter.
    kind : {"accelerometer", "gyroscope"}

    Raises
    ------
    InputError
        No such sensor, or it has no such element.
    """
    try:
        sensor = find(name)
    except InputError as error:
        raise InputError(f"{error}; the name of a sensor file ends in .yaml") from None
    if kind not in sensor.elements:
        with_it = ", ".join(s.name for s in sensors().values() if kind in s.elements)
        raise InputError(f"{sensor.name} has no {kind} (sensors that have one: {with_it})")
    return sensor.elements[kind]
