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
from pathlib import Path
from typing import Any

from mcsim.errors import InputError, UnitError
from mcsim.units import KINDS, parse

#: Kinds of sensing element that a sensor may hold.
ELEMENTS = ("accelerometer", "gyroscope")
#: Kinds of record that an element may hold, by their key in the file.
ORIGINS = {"data_sheet": "data sheet", "measured": "measured"}
#: Quantities of a sensor file that are checked where they are used.
_UNCHECKED = (
    "gauss_markov",
    "scale_factor_error",
    "misalignment",
    "g_sensitivity",
    "bandwidth",
    "range",
    "spikes",
)


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


#: Quantities of a sensor file that are checked when it is read, with their kinds.
_CHECKED = {
    "accelerometer": {
        "noise_density": "acceleration noise density",
        "velocity_random_walk": "velocity random walk",
        "miscalibration": "acceleration",
        "turn_on_bias": "acceleration",
        "bias_instability": "acceleration",
        "acceleration_random_walk": "acceleration random walk",
        "resolution": "acceleration",
    },
    "gyroscope": {
        "noise_density": "angular rate noise density",
        "angle_random_walk": "angle random walk",
        "miscalibration": "angular rate",
        "turn_on_bias": "angular rate",
        "bias_instability": "angular rate",
        "rate_random_walk": "rate random walk",
        "resolution": "angular rate",
    },
}


@dataclass(frozen=True)
class Sensor:
    """A catalogue entry.

    ``elements`` maps an element to the quantities that a scenario takes, as text;
    ``records`` to what its sources print.
    """

    name: str
    description: str
    origin: str
    elements: Mapping[str, Mapping[str, Any]]
    records: Mapping[str, tuple[Record, ...]]


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
            element: {key: value for key, value in block.items() if key not in ORIGINS}
            for element, block in blocks.items()
        },
        records={element: _records(block, sources) for element, block in blocks.items()},
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
    sensor = find(name)
    if kind not in sensor.elements:
        with_it = ", ".join(s.name for s in sensors().values() if kind in s.elements)
        raise InputError(f"{sensor.name} has no {kind} (sensors that have one: {with_it})")
    return sensor.elements[kind]


def load_file(path: str | Path) -> Sensor:
    """A sensor from a file of its own, such as ``mcsim characterise`` writes.

    The file holds what one entry of the built-in catalogue holds; its name is that of
    the file, and quantities per axis may stand under ``axes``.

    Raises
    ------
    InputError
        Not such a file, or a quantity in it that cannot be read.
    """
    path = Path(path)
    entry = _read_entry(path)
    elements = {e: entry[e] for e in ELEMENTS if isinstance(entry.get(e), dict)}
    if not elements:
        raise InputError(f"{path}: describes no sensor: it has neither {' nor '.join(ELEMENTS)}")
    for name, quantities in elements.items():
        _check_quantities(f"{path}: {name}", name, quantities)
        axes = quantities.get("axes") or {}
        if not isinstance(axes, dict) or not all(isinstance(x, dict) for x in axes.values()):
            raise InputError(f"{path}: {name}.axes: a mapping of x, y and z is needed")
        for axis, values in axes.items():
            _check_quantities(f"{path}: {name}.axes.{axis}", name, values)
    return Sensor(
        name=path.stem,
        description=str(entry.get("description", "")),
        origin=str(entry.get("origin", "measured")),
        elements=elements,
        records={},
    )


def file_element(path: Path, kind: str) -> Mapping[str, Any]:
    """The quantities that a scenario takes from one element of a sensor file.

    What the file knows of all three axes becomes a list [x, y, z].

    Raises
    ------
    InputError
        Not such a file, or no such element in it.
    """
    sensor = load_file(path)
    if kind not in sensor.elements:
        raise InputError(f"{path}: has no {kind}")
    return scenario_quantities(sensor.elements[kind], kind)


def scenario_quantities(block: Mapping[str, Any], kind: str) -> Mapping[str, Any]:
    """What a scenario takes from an element's block of a sensor file."""
    axes = block.get("axes") or {}
    of_axes = [axes.get(axis, {}) for axis in "xyz"]
    return {
        key: _per_axis([axis.get(key) for axis in of_axes], value)
        for key, value in block.items()
        if key in _CHECKED[kind] or key in _UNCHECKED
    }


def _per_axis(values: list[Any], whole: Any) -> Any:
    """The axes' values as a list, or ``whole`` where they do not all have one."""
    if any(value is None for value in values):
        return whole
    if isinstance(whole, dict):
        return {key: _per_axis([v.get(key) for v in values], whole[key]) for key in whole}
    return values


def _read_entry(path: Path) -> dict[str, Any]:
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        entry = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: cannot be read ({getattr(error, 'strerror', None) or 'not UTF-8 text'})"
        ) from None
    except YAMLError as error:
        raise InputError(f"{path}: not YAML ({str(error).splitlines()[0]})") from None
    if not isinstance(entry, dict):
        raise InputError(f"{path}: is empty or no mapping; it must describe a sensor")
    return entry


def _check_quantities(where: str, kind: str, quantities: Mapping[str, Any]) -> None:
    for key, value in quantities.items():
        if key in _CHECKED[kind]:
            try:
                parse(str(value), KINDS[_CHECKED[kind][key]])
            except UnitError as error:
                raise InputError(f"{where}.{key}: {error}") from None
