"""KF-GINS: the ``imunoise`` block of its configuration.

Its source puts arw² and vrw² on the diagonal of the continuous-time noise matrix (Allan's N)
and ``2 σ² / Tc`` for biases and scale factors: stationary Gauss-Markov processes of deviation
σ, with one correlation time for all.  1 mGal is 1e-5 m/s².
"""

from __future__ import annotations

from mcsim.dialects.description import (
    CORRELATION_TIME,
    DEVIATION,
    RANDOM_WALK,
    Assumptions,
    Description,
    Reading,
    Values,
    three,
    two_sided,
)
from mcsim.dialects.foreign import (
    Term,
    element_or_refuse,
    plain_numbers,
    required,
    without_words,
)
from mcsim.dialects.numbers import number
from mcsim.errors import InputError
from mcsim.scenario.document import parse_document

CONVENTION = (
    "arw and vrw are two-sided, Allan's N; gbstd, abstd, gsstd, asstd are the deviations of "
    "stationary Gauss-Markov processes, all with the time corrtime (KF-GINS source, Q = 2 σ² / Tc)"
)
TERMS = (
    Term("arw", "gyroscope", "angle_random_walk", "°/√h"),
    Term("vrw", "accelerometer", "velocity_random_walk", "m/s/√h"),
    Term("gbstd", "gyroscope", DEVIATION, "°/h"),
    Term("abstd", "accelerometer", DEVIATION, "mGal"),
    Term("gsstd", "gyroscope", "scale_factor_error", "ppm"),
    Term("asstd", "accelerometer", "scale_factor_error", "ppm"),
)
_PRINTED = {"°/√h": "deg/sqrt(hr)", "m/s/√h": "m/s/sqrt(hr)", "°/h": "deg/hr"}
_HOUR = 3600.0


def read(text: str, source: str, _: Assumptions) -> Reading:
    """A configuration with an ``imunoise`` block.

    Raises
    ------
    InputError
        A parameter is missing or no number.
    """
    document = parse_document(text, source)
    elements: dict[str, dict[str, Values]] = {"accelerometer": {}, "gyroscope": {}}
    for term in TERMS:
        values = plain_numbers(*required(document, ("imunoise", term.name)))
        elements[term.element][term.key] = tuple(value * term.si for value in values)
    time, place = required(document, ("imunoise", "corrtime"))
    correlation = plain_numbers(time, place)
    if len(correlation) != 1 or correlation[0] == 0.0:
        raise InputError(f"{place}: one number above zero is needed here")
    for quantities in elements.values():
        quantities[CORRELATION_TIME] = (correlation[0] * _HOUR,)
    rate = document.tree.get("imudatarate")
    notes = ("KF-GINS lets scale factors vary with corrtime; they are kept as constant errors",)
    return Reading(Description(None, float(rate) if rate else None, elements), notes)


def write(sensor: Description, assumptions: Assumptions) -> str:
    """An ``imunoise`` block; terms that the sensor does not have are zero.

    Raises
    ------
    InputError
        An element is missing, or the correlation times differ and none was chosen.
    """
    lines = []
    for term in TERMS:
        quantities = element_or_refuse(sensor, term.element, "KF-GINS")
        is_white = term.key == RANDOM_WALK[term.element]
        values = two_sided(quantities, term.element) if is_white else quantities.get(term.key)
        missing = ", not given by the sensor" if values is None else ""
        texts = ", ".join(number(v / term.si) for v in three(values or (0.0,)))
        unit = _PRINTED.get(term.unit, term.unit)
        lines.append(f"  {term.name}: [{texts}]  # {unit}{missing}")
    time = _correlation_time(sensor, assumptions)
    missing = "" if time is not None else ", no Gauss-Markov process given by the sensor"
    lines.append(f"  corrtime: {number((time or _HOUR) / _HOUR)}  # hr{missing}")
    carried = [*RANDOM_WALK.values(), "noise_density", DEVIATION, CORRELATION_TIME]
    carried.append("scale_factor_error")
    return "\n".join([*without_words(sensor, carried), "imunoise:", *lines]) + "\n"


def _correlation_time(sensor: Description, assumptions: Assumptions) -> float | None:
    """The one time (s) for all processes."""
    by_element = {
        element: assumptions.one(quantities[CORRELATION_TIME], f"{element}: {CORRELATION_TIME}")
        for element, quantities in sensor.elements.items()
        if CORRELATION_TIME in quantities
    }
    if not by_element:
        return None
    if len(set(by_element.values())) > 1:
        chosen = assumptions.answer(
            "corrtime",
            "KF-GINS has one corrtime for all processes; those of this sensor differ",
            {e: f"that of the {e}, {time:g} s" for e, time in by_element.items()},
        )
        return by_element[chosen]
    return next(iter(by_element.values()))
