"""What the readers of other tools' files share: numbers, one per axis or for all, in SI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from mcsim.dialects.description import Description, Quantities, Values, left_out
from mcsim.dialects.own import kind_of
from mcsim.errors import InputError
from mcsim.scenario.document import Document, PathKey, get_path
from mcsim.units import KINDS, factor


@dataclass(frozen=True)
class Term:
    """A number of another tool: its name there, the key here, the unit there."""

    name: str
    element: str
    key: str
    unit: str

    @property
    def si(self) -> float:
        """SI value of one unit."""
        return factor(self.unit, KINDS[kind_of(self.key, self.element)])


def plain_numbers(value: Any, place: str) -> Values:
    """One number or a list of three.

    Raises
    ------
    InputError
        Something else, or a number that is negative, infinite or not one.
    """
    items = value if isinstance(value, list | tuple) else [value]
    if len(items) not in (1, 3) or not all(
        isinstance(item, int | float) and not isinstance(item, bool) for item in items
    ):
        raise InputError(f"{place}: one number, or three for x, y and z, are needed here")
    numbers = tuple(float(item) for item in items)
    if not all(0.0 <= item < float("inf") for item in numbers):
        raise InputError(f"{place}: a noise parameter is a finite number, zero or above")
    return numbers


def required(document: Document, path: PathKey) -> tuple[Any, str]:
    """The value at a path of a foreign YAML file, and its place for messages.

    Raises
    ------
    InputError
        It is missing.
    """
    name = ".".join(map(str, path))
    value = get_path(document.tree, path)
    if value is None:
        raise InputError(f"{document.place(path)}: {name}: is missing")
    return value, f"{document.place(path)}: {name}"


def without_words(sensor: Description, carried: Sequence[str], comment: str = "#") -> list[str]:
    """A comment line per element that has quantities which the target cannot hold."""
    lines = []
    for element, quantities in sensor.elements.items():
        missing = left_out(quantities, set(carried))
        if missing:
            lines.append(f"{comment} {element}, not carried over: {', '.join(missing)}")
    return lines


def element_or_refuse(sensor: Description, element: str, dialect: str) -> Quantities:
    """The quantities of an element that the dialect cannot do without.

    Raises
    ------
    InputError
        The sensor has no such element.
    """
    if element not in sensor.elements:
        raise InputError(f"{dialect} needs both elements; this sensor has no {element}")
    return sensor.elements[element]
