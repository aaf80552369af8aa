"""What the readers of other tools' files share: YAML that OpenCV wrote too, numbers in SI."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any

from mcsim.dialects.description import Description, Quantities, Values, left_out
from mcsim.errors import InputError
from mcsim.scenario.document import Document, Genre, PathKey, get_path, parse_document

_PARAMETERS = Genre("parameter", "has `gyroscope_noise_density: …`, `imunoise:` or the like")
_OPENCV_HEAD = re.compile(r"\A(\s*)%(?=YAML:)")


def foreign_document(text: str, source: str) -> Document:
    """The YAML text of another tool; OpenCV's head, ``%YAML:1.0``, is no YAML and passed over.

    Raises
    ------
    InputError
        Not YAML, not a mapping, or absurdly large.
    """
    return parse_document(_OPENCV_HEAD.sub(r"\1#", text, count=1), source, _PARAMETERS)


def within(document: Document, path: PathKey) -> Document:
    """The document of the block at ``path``, whose lines stay those of the file."""
    lines = {
        key[len(path) :]: line for key, line in document.lines.items() if key[: len(path)] == path
    }
    return replace(document, tree=get_path(document.tree, path), lines=lines)


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
        raise InputError(
            f"{place}: one number, or three for x, y and z, are needed here, not {_shown(value)}"
        )
    try:
        numbers = tuple(float(item) for item in items)
    except OverflowError:
        numbers = (math.inf,)
    if not all(0.0 <= item < math.inf for item in numbers):
        raise InputError(f"{place}: a noise parameter is a finite number, zero or above")
    return numbers


def one_number(value: Any, place: str) -> float:
    """One number above zero.

    Raises
    ------
    InputError
        Something else.
    """
    numbers = plain_numbers(value, place)
    if len(numbers) != 1 or numbers[0] == 0.0:
        raise InputError(f"{place}: one number above zero is needed here")
    return numbers[0]


def _shown(value: Any) -> str:
    if value is None:
        return "nothing"
    text = str(value) if isinstance(value, str) else f"{value}"
    return f'"{text}"' if len(text) < 40 else f'"{text[:37]}…"'


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


def refuse_unknown(name: str, known: Collection[str], place: str) -> None:
    """Refuse a name that is like none of a closed list.

    Raises
    ------
    InputError
        It is not in the list; the message names the closest one.
    """
    if name in known:
        return
    close = difflib.get_close_matches(name[:40], known, n=1)
    hint = f'; did you mean "{close[0]}"?' if close else f" (known: {', '.join(known)})"
    raise InputError(f"{place}: {name[:40]}: is not known here{hint}")


def without_words(sensor: Description, carried: Sequence[str], comment: str = "#") -> list[str]:
    """A comment line per element that has quantities which the target cannot hold.

    Parameters
    ----------
    sensor : Description
    carried : sequence of str
        Keys that the target holds.
    comment : str
        What begins a comment line there.

    Returns
    -------
    list of str
    """
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
