"""MATLAB's ``accelparams`` and ``gyroparams`` (Navigation, Sensor Fusion and Tracking toolboxes).

MathWorks' example "Inertial Sensor Noise Analysis Using Allan Variance" passes Allan's N, K
and B with ``NoiseType`` "single-sided", "to match the parameter scaling": the variance of one
sample is ``NoiseDensity² fs``.  The default, "double-sided", scales by ``fs / 2``: there
NoiseDensity is what a data sheet prints.  (The names are the other way round from a spectrum's.)
"""

from __future__ import annotations

import re

from mcsim.dialects.description import (
    BIAS_WALK,
    RANDOM_WALK,
    Assumptions,
    Description,
    Reading,
    Values,
    two_sided,
)
from mcsim.dialects.foreign import Term, plain_numbers, without_words
from mcsim.dialects.numbers import number
from mcsim.errors import InputError

CONVENTION = (
    "with NoiseType 'single-sided' NoiseDensity is Allan's N (variance ND² fs per sample); with "
    "'double-sided', the default, it is a data sheet's density (ND² fs / 2)"
)
_FUNCTION = {"accelerometer": "accelparams", "gyroscope": "gyroparams"}


def _terms(element: str) -> tuple[Term, ...]:
    acceleration = element == "accelerometer"
    unit = "m/s²" if acceleration else "rad/s"
    walk = "m/s²/√s" if acceleration else "rad/s/√s"
    return (
        Term("NoiseDensity", element, RANDOM_WALK[element], f"{unit}/√Hz"),
        Term("BiasInstability", element, "bias_instability", unit),
        Term("RandomWalk", element, BIAS_WALK[element], walk),
        Term("MeasurementRange", element, "range", unit),
        Term("Resolution", element, "resolution", unit),
    )


_CALL = r"{}\s*\(((?:[^()']|'[^']*'|\([^()]*\))*)\)"
_PAIR = re.compile(r"['\"]?(\w+)['\"]?\s*[,=]\s*(\[[^\]]*\]|'[^']*'|\"[^\"]*\"|[-+\w.]+)\s*(?:,|$)")
_RANDOM_WALK_CHOICES = {
    "K": "RandomWalk is Allan's K",
    "K/sqrt2": "RandomWalk is scaled like the noise, with 2 / fs: K is √2 times it",
}


def read(text: str, source: str, assumptions: Assumptions) -> Reading:
    """Calls of ``accelparams`` and ``gyroparams`` with name-value pairs of plain numbers.

    Raises
    ------
    InputError
        No such call, a value that is no number, an unanswered question.
    """
    code = re.sub(r"\.\.\.[^\n]*\n", " ", re.sub(r"(?m)^\s*%.*$", "", text))
    code = re.sub(r"%[^\n]*", "", code)
    elements: dict[str, dict[str, Values]] = {}
    notes: list[str] = []
    for element, function in _FUNCTION.items():
        match = re.search(_CALL.format(function), code)
        if match is not None:
            pairs = dict(_PAIR.findall(match[1].replace("\n", " ")))
            place = f"{source}: {function}"
            elements[element] = _element(element, pairs, place, assumptions, notes)
    if not elements:
        raise InputError(f"{source}: no call of accelparams or gyroparams")
    return Reading(Description(None, assumptions.rate, elements), tuple(notes))


def _element(
    element: str, pairs: dict[str, str], place: str, assumptions: Assumptions, notes: list[str]
) -> dict[str, Values]:
    quantities: dict[str, Values] = {}
    noise_type = pairs.pop("NoiseType", "").strip("'\"")
    if noise_type not in ("", "single-sided", "double-sided"):
        raise InputError(f'{place}: NoiseType: "{noise_type}" is not single-sided or double-sided')
    if not noise_type:
        notes.append(f"{place}: without NoiseType, MATLAB's default, double-sided, is meant")
    for term in _terms(element):
        if term.name not in pairs:
            continue
        values = plain_numbers(_numbers(pairs.pop(term.name)), f"{place}: {term.name}")
        if term.name == "NoiseDensity" and noise_type != "single-sided":
            quantities["noise_density"] = values
        else:
            quantities[term.key] = values
    walk = quantities.get(BIAS_WALK[element], ())
    if any(walk) and noise_type != "single-sided":
        question = f"{place}: RandomWalk with NoiseType 'double-sided' is scaled in one of two ways"
        if assumptions.answer("RandomWalk", question, _RANDOM_WALK_CHOICES) == "K/sqrt2":
            quantities[BIAS_WALK[element]] = tuple(2.0**0.5 * value for value in walk)
    rest = [name for name, value in pairs.items() if value.strip("[]0. ,;'")]
    if rest:
        notes.append(f"{place}: not carried over: {', '.join(rest)}")
    return {key: values for key, values in quantities.items() if any(values)}


def _numbers(text: str) -> object:
    try:
        items = [float(item) for item in re.split(r"[\s,;]+", text.strip("[] "))]
    except ValueError:
        return None
    return items if len(items) > 1 else items[0]


def write(sensor: Description, _: Assumptions) -> str:
    """MATLAB code, with NoiseType 'single-sided' and Allan's coefficients."""
    lines = []
    carried = ["noise_density"]
    for element, quantities in sensor.elements.items():
        walk = two_sided(quantities, element)
        held = {**quantities, RANDOM_WALK[element]: walk} if walk is not None else quantities
        pairs = ["'NoiseType', 'single-sided'"]
        for term in _terms(element):
            carried.append(term.key)
            values = held.get(term.key)
            if values is None:
                continue
            if term.name in ("MeasurementRange", "Resolution"):
                # MATLAB has one range and one resolution for all axes.
                values = (max(values),)
            texts = [number(value / term.si) for value in values]
            shown = texts[0] if len(texts) == 1 else f"[{' '.join(texts)}]"
            pairs.append(f"'{term.name}', {shown}")
        name = element[:5] if element == "accelerometer" else "gyro"
        lines.append(f"{name} = {_FUNCTION[element]}( ...\n    " + ", ...\n    ".join(pairs) + ");")
    return "\n".join([*without_words(sensor, carried, "%"), *lines]) + "\n"
