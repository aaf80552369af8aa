"""KF-GINS: the ``imunoise`` block of its configuration.

Its source puts arw² and vrw² on the diagonal of the continuous-time noise matrix (Allan's N)
and ``2 σ² / Tc`` for biases and scale factors: stationary Gauss-Markov processes of deviation
σ, with one correlation time for all.  1 mGal is 1e-5 m/s².
"""

from __future__ import annotations

import re

from mcsim.dialects.bias import Process, process_of
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
from mcsim.dialects.dialect import Dialect
from mcsim.dialects.foreign import (
    element_or_refuse,
    foreign_document,
    one_number,
    plain_numbers,
    refuse_unknown,
    required,
    without_words,
)
from mcsim.dialects.numbers import number
from mcsim.dialects.terms import terms_of

CONVENTION = (
    "arw and vrw are two-sided, Allan's N; gbstd, abstd, gsstd, asstd are the deviations of "
    "stationary Gauss-Markov processes, all with the time corrtime (KF-GINS source, Q = 2 σ² / Tc)"
)
TERMS = terms_of(
    "KF-GINS",
    ("arw", "gyroscope", "angle_random_walk", "°/√h"),
    ("vrw", "accelerometer", "velocity_random_walk", "m/s/√h"),
    ("gbstd", "gyroscope", DEVIATION, "°/h"),
    ("abstd", "accelerometer", DEVIATION, "mGal"),
    ("gsstd", "gyroscope", "scale_factor_error", "ppm"),
    ("asstd", "accelerometer", "scale_factor_error", "ppm"),
)
_KNOWN = (*(term.name for term in TERMS), "corrtime")
_PRINTED = {"°/√h": "deg/sqrt(hr)", "m/s/√h": "m/s/sqrt(hr)", "°/h": "deg/hr"}
_HOUR = 3600.0


def recognises(text: str) -> bool:
    """An ``imunoise`` block."""
    return bool(re.search(r"(?m)^\s*['\"{]*imunoise['\"]?\s*:", text))


def read(text: str, source: str, _: Assumptions) -> Reading:
    """A configuration with an ``imunoise`` block.

    Raises
    ------
    InputError
        A parameter is missing, unknown or no number.
    """
    document = foreign_document(text, source)
    block, _place = required(document, ("imunoise",))
    for name in block if isinstance(block, dict) else ():
        refuse_unknown(name, _KNOWN, document.place(("imunoise", name)))
    elements: dict[str, dict[str, Values]] = {"accelerometer": {}, "gyroscope": {}}
    for term in TERMS:
        values = plain_numbers(*required(document, ("imunoise", term.name)))
        elements[term.element][term.key] = tuple(value * term.si for value in values)
    correlation = one_number(*required(document, ("imunoise", "corrtime")))
    for quantities in elements.values():
        quantities[CORRELATION_TIME] = (correlation * _HOUR,)
    rate = None
    if document.tree.get("imudatarate") is not None:
        rate = one_number(*required(document, ("imudatarate",)))
    notes = ("KF-GINS lets scale factors vary with corrtime; they are kept as constant errors",)
    return Reading(Description(None, rate, elements), notes)


def write(sensor: Description, assumptions: Assumptions) -> str:
    """An ``imunoise`` block; terms that the sensor does not have are zero, and said to be.

    Raises
    ------
    InputError
        An element is missing, the correlation times differ and none was chosen, or a bias
        instability is given and how to make a Gauss-Markov process of it was not stated.
    """
    processes = {
        term.element: process_of(
            element_or_refuse(sensor, term.element, "KF-GINS"),
            term.element,
            f"KF-GINS' {term.name}",
            assumptions,
        )
        for term in TERMS
        if term.key == DEVIATION
    }
    lines = []
    for term in TERMS:
        quantities = sensor.elements[term.element]
        process = processes[term.element] if term.key == DEVIATION else None
        if process is not None:
            values: Values | None = process.deviation
        elif term.key == RANDOM_WALK[term.element]:
            values = two_sided(quantities, term.element)
        else:
            values = quantities.get(term.key)
        texts = ", ".join(number(v / term.si) for v in three(values or (0.0,)))
        remark = _PRINTED.get(term.unit, term.unit)
        remark += ", not given by the sensor" if values is None else ""
        remark += f", {process.origin}" if process is not None and process.origin else ""
        lines.append(f"  {term.name}: [{texts}]  # {remark}")
    time = _correlation_time(processes, assumptions)
    missing = "" if time is not None else ", no Gauss-Markov process given by the sensor"
    lines.append(f"  corrtime: {number((time or _HOUR) / _HOUR)}  # hr{missing}")
    head = [] if sensor.rate is None else [f"imudatarate: {number(sensor.rate)}"]
    carried = [*RANDOM_WALK.values(), "noise_density", DEVIATION, CORRELATION_TIME]
    carried.append("scale_factor_error")
    if any(process is not None and process.origin for process in processes.values()):
        carried.append("bias_instability")
    return "\n".join([*without_words(sensor, carried), *head, "imunoise:", *lines]) + "\n"


def _correlation_time(
    processes: dict[str, Process | None], assumptions: Assumptions
) -> float | None:
    """The one time (s) for all processes."""
    by_element = {
        element: assumptions.one(process.time, f"{element}: {CORRELATION_TIME}")
        for element, process in processes.items()
        if process is not None and any(process.deviation)
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


DIALECT = Dialect(
    "kf-gins", "KF-GINS imunoise block", CONVENTION, recognises, read, write, terms=TERMS
)
