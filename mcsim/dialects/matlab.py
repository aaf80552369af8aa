"""MATLAB's ``accelparams`` and ``gyroparams`` (Navigation, Sensor Fusion and Tracking toolboxes).

MathWorks' example "Inertial Sensor Noise Analysis Using Allan Variance" passes Allan's N, K
and B with ``NoiseType`` "single-sided", "to match the parameter scaling": the variance of one
sample is ``NoiseDensity² fs``.  The default, "double-sided", scales by ``fs / 2``: there
NoiseDensity is what a data sheet prints.  (The names are the other way round from a spectrum's.)
"""

from __future__ import annotations

import math
import re

from mcsim.dialects.description import (
    BIAS_WALK,
    ELEMENTS,
    RANDOM_WALK,
    Assumptions,
    Description,
    Reading,
    Values,
    two_sided,
)
from mcsim.dialects.dialect import Dialect
from mcsim.dialects.foreign import plain_numbers, without_words
from mcsim.dialects.matlab_script import FUNCTIONS, Property, Script
from mcsim.dialects.numbers import number
from mcsim.dialects.terms import Term
from mcsim.errors import InputError

CONVENTION = (
    "with NoiseType 'single-sided' NoiseDensity is Allan's N (variance ND² fs per sample); with "
    "'double-sided', the default, it is a data sheet's density (ND² fs / 2)"
)
_FUNCTION = {element: function for function, element in FUNCTIONS.items()}
_SINGLE, _DOUBLE = "single-sided", "double-sided"
#: Parameters that mcsim has no words for.
_OTHERS = (
    "ConstantBias",
    "AxesMisalignment",
    "BiasInstabilityCoefficients",
    "TemperatureBias",
    "TemperatureScaleFactor",
    "AccelerationBias",
)
#: Of one value for all axes.
_SCALARS = ("MeasurementRange", "Resolution")


def _terms(element: str) -> tuple[Term, ...]:
    tool = f"MATLAB {_FUNCTION[element]}"
    unit = "m/s²" if element == "accelerometer" else "rad/s"
    single = f"NoiseType {_SINGLE}"
    return (
        Term("NoiseDensity", element, RANDOM_WALK[element], f"{unit}/√Hz", tool, single),
        Term("BiasInstability", element, "bias_instability", unit, tool, single),
        Term("RandomWalk", element, BIAS_WALK[element], f"{unit}/√s", tool, single),
        Term("MeasurementRange", element, "range", unit, tool),
        Term("Resolution", element, "resolution", unit, tool),
    )


def _shown_terms(element: str) -> tuple[Term, ...]:
    """With the density in the default convention beside Allan's N."""
    first, *others = _terms(element)
    double = Term(
        first.name, element, "noise_density", first.unit, first.tool, f"NoiseType {_DOUBLE}"
    )
    return first, double, *others


_RANDOM_WALK_CHOICES = {
    "K": "RandomWalk is Allan's K",
    "K/sqrt2": "RandomWalk is scaled like the noise, with 2 / fs: K is √2 times it",
}


def recognises(text: str) -> bool:
    """A call, or a property of an ``imuSensor``'s element, outside of comments."""
    return bool(
        re.search(
            r"(?m)^[^%#\n]*(\b(accelparams|gyroparams)\b"
            r"|\.(Accelerometer|Gyroscope)\.[A-Z]\w+\s*=)",
            text,
        )
    )


def read(text: str, source: str, assumptions: Assumptions) -> Reading:
    """Calls of ``accelparams`` and ``gyroparams``, and properties set afterwards.

    Raises
    ------
    InputError
        No such call, a value or a statement that is not understood, an unanswered question.
    """
    needed = ("NoiseType", *(term.name for term in _terms("accelerometer")))
    script = Script(source, (*needed, *_OTHERS), needed)
    script.run(text)
    if not script.elements:
        raise InputError(f"{source}: no call of accelparams or gyroparams")
    notes: list[str] = []
    elements = {
        element: _element(element, script.elements[element], source, assumptions, notes)
        for element in ELEMENTS
        if element in script.elements
    }
    return Reading(Description(None, None, elements), tuple(notes))


def _element(
    element: str,
    given: dict[str, Property],
    source: str,
    assumptions: Assumptions,
    notes: list[str],
) -> dict[str, Values]:
    place = f"{source}: {_FUNCTION[element]}"
    noise_type = _noise_type(given.get("NoiseType"))
    if noise_type is None:
        notes.append(f"{place}: without NoiseType, MATLAB's default, double-sided, is meant")
    quantities: dict[str, Values] = {}
    for term in _terms(element):
        if term.name not in given or given[term.name].value == math.inf:
            continue  # an infinite range is none
        values = plain_numbers(given[term.name].value, given[term.name].place)
        is_density = term.name == "NoiseDensity" and noise_type != _SINGLE
        quantities["noise_density" if is_density else term.key] = values
    walk = quantities.get(BIAS_WALK[element], ())
    if any(walk) and noise_type != _SINGLE:
        question = f"{place}: RandomWalk with NoiseType 'double-sided' is scaled in one of two ways"
        if assumptions.answer("RandomWalk", question, _RANDOM_WALK_CHOICES) == "K/sqrt2":
            quantities[BIAS_WALK[element]] = tuple(2.0**0.5 * value for value in walk)
    rest = [name for name in _OTHERS if name in given and not _is_zero(given[name].value)]
    if rest:
        notes.append(f"{place}: not carried over: {', '.join(rest)}")
    return {key: values for key, values in quantities.items() if any(values)}


def _noise_type(given: Property | None) -> str | None:
    if given is None:
        return None
    if given.value not in (_SINGLE, _DOUBLE):
        raise InputError(f'{given.place}: "{str(given.value)[:40]}" is not {_SINGLE} or {_DOUBLE}')
    return str(given.value)


def _is_zero(value: object) -> bool:
    return value == 0.0 or (isinstance(value, tuple) and not any(value))


def write(sensor: Description, assumptions: Assumptions) -> str:
    """MATLAB code, with NoiseType 'single-sided' and Allan's coefficients.

    Raises
    ------
    InputError
        A range or a resolution differs between the axes, and none was chosen.
    """
    lines = []
    carried = ["noise_density"]
    for element, quantities in sensor.elements.items():
        walk = two_sided(quantities, element)
        held = {**quantities, RANDOM_WALK[element]: walk} if walk is not None else quantities
        pairs = [f"'NoiseType', '{_SINGLE}'"]
        for term in _terms(element):
            carried.append(term.key)
            values = held.get(term.key)
            if values is None:
                continue
            if term.name in _SCALARS:
                values = (assumptions.one(values, f"{element}: {term.key}"),)
            texts = [number(value / term.si) for value in values]
            shown = texts[0] if len(texts) == 1 else f"[{' '.join(texts)}]"
            pairs.append(f"'{term.name}', {shown}")
        name = element[:5] if element == "accelerometer" else "gyro"
        lines.append(f"{name} = {_FUNCTION[element]}( ...\n    " + ", ...\n    ".join(pairs) + ");")
    return "\n".join([*without_words(sensor, carried, "%"), *lines]) + "\n"


DIALECT = Dialect(
    "matlab",
    "MATLAB accelparams and gyroparams",
    CONVENTION,
    recognises,
    read,
    write,
    comment="%",
    terms=(*_shown_terms("accelerometer"), *_shown_terms("gyroscope")),
    ending=".m",
)
