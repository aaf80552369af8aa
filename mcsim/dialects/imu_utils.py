"""imu_utils' result files: read, never written, since their numbers do not say what they are.

``*_n`` is the Allan deviation at 1 s, Allan's N, in some published results, and the deviation
of one sample (N √rate) in others; ``*_w`` is documented as a bias instability, used as Kalibr's
random walk, and computed as the least Allan deviation.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from mcsim.dialects.bias import FLOOR
from mcsim.dialects.description import (
    AXES,
    BIAS_WALK,
    RANDOM_WALK,
    Assumptions,
    Description,
    Reading,
    Values,
)
from mcsim.dialects.dialect import Dialect
from mcsim.dialects.foreign import (
    foreign_document,
    plain_numbers,
    refuse_unknown,
    required,
)
from mcsim.errors import InputError, UnitError
from mcsim.scenario.document import Document, get_path
from mcsim.units import KINDS, factor

CONVENTION = "n is Allan's N or N √rate, w the least Allan deviation or something else: say which"
_SECTIONS = {"accelerometer": ("Acc", "acc"), "gyroscope": ("Gyr", "gyr")}
_KIND = {"accelerometer": KINDS["acceleration"], "gyroscope": KINDS["angular rate"]}
_KNOWN = ("type", "name", "Gyr", "Acc")
_N = {
    "continuous": "Allan's N, the Allan deviation at 1 s",
    "per_sample": "the deviation of one sample, N √rate (needs --rate)",
}
_W = {
    "allan_minimum": "the least Allan deviation, 0.664 B (what the program computes)",
    "bias_instability": "B itself",
    "random_walk": "Allan's K",
    "ignore": "leave it out",
}


def recognises(text: str) -> bool:
    """A section of one of the elements."""
    return bool(re.search(r"(?m)^\s*['\"{]*(Gyr|Acc)['\"]?\s*:", text))


def read(text: str, source: str, assumptions: Assumptions) -> Reading:
    """A ``*_imu_param.yaml``, axis by axis; both elements and all three axes.

    Raises
    ------
    InputError
        A number is missing, or one of the questions was not answered.
    """
    document = foreign_document(text, source)
    for key in document.tree:
        refuse_unknown(key, _KNOWN, document.place((key,)))
    numbers = {
        (element, name): _per_axis(document, element, section, f"{prefix}_{name}")
        for element, (section, prefix) in _SECTIONS.items()
        for name in ("n", "w")
    }
    white, drift = _answers(source, assumptions)
    scale = 1.0
    if white == "per_sample":
        rate = assumptions.required_rate("the deviation of one sample depends on the rate")
        scale = 1.0 / math.sqrt(rate)
    elements: dict[str, dict[str, Values]] = {}
    for element in _SECTIONS:
        n, w = numbers[element, "n"], numbers[element, "w"]
        elements[element] = {RANDOM_WALK[element]: tuple(scale * value for value in n)}
        if drift == "random_walk":
            elements[element][BIAS_WALK[element]] = w
        elif drift != "ignore":
            floor = FLOOR if drift == "allan_minimum" else 1.0
            elements[element]["bias_instability"] = tuple(value / floor for value in w)
    name = document.tree.get("name")
    named = str(name) if isinstance(name, str | int) and name else None
    notes = (f"*_n taken as {white}, *_w as {drift}, as stated",)
    return Reading(Description(named, None, elements), notes)


def _per_axis(document: Document, element: str, section: str, name: str) -> Values:
    values = []
    si = _unit(document, element, section)
    for axis in AXES:
        value, place = required(document, (section, f"{axis}-axis", name))
        numbers = plain_numbers(value, place)
        if len(numbers) != 1:
            raise InputError(f"{place}: one number is needed here")
        values.append(si * numbers[0])
    return tuple(values)


def _unit(document: Document, element: str, section: str) -> float:
    """SI value of the unit that the section names; the program's own is rad/s or m/s²."""
    path = (section, "unit")
    unit = get_path(document.tree, path)
    if unit is None:
        return 1.0
    try:
        return factor(str(unit).strip(), _KIND[element])
    except UnitError as error:
        raise InputError(f"{document.place(path)}: {section}.unit: {error}") from None


def _answers(source: str, assumptions: Assumptions) -> tuple[str, str]:
    """What n and w are; both questions are put at once."""
    questions: tuple[tuple[str, str, Mapping[str, str]], ...] = (
        ("n", f"{source}: gyr_n and acc_n mean one of two things", _N),
        ("w", f"{source}: gyr_w and acc_w mean one of several things", _W),
    )
    unanswered = []
    for question in questions:
        try:
            assumptions.answer(*question)
        except InputError as error:
            unanswered.append(str(error))
    if unanswered:
        raise InputError("\n".join(unanswered))
    return assumptions.answers["n"], assumptions.answers["w"]


DIALECT = Dialect("imu_utils", "imu_utils result", CONVENTION, recognises, read, None)
