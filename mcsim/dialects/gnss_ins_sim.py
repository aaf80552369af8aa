"""gnss-ins-sim's accuracy dictionary (Python).

Its source (``pathgen.bias_drift``) adds white noise of ``vrw / √dt``: Allan's N.  The bias is a
first-order Gauss-Markov process, ``x += -x dt/Tc + b √(1 - exp(-2 dt/Tc)) w``, which begins at
zero: its stationary deviation is b within dt / (4 Tc).  Versions before 20 February 2021 had
``x += -x dt/Tc + b dt w``, whose stationary deviation ``b dt / √(1 - (1 - dt/Tc)²)``, about
b √(dt Tc / 2), depends on the rate.  An infinite time gives white noise of deviation b per
sample, in both.
"""

from __future__ import annotations

import math
import re

from mcsim.dialects.arithmetic import Value
from mcsim.dialects.bias import process_of
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
    plain_numbers,
    refuse_unknown,
    without_words,
)
from mcsim.dialects.numbers import number
from mcsim.dialects.python_text import Entry, dictionary_with
from mcsim.dialects.terms import terms_of
from mcsim.errors import InputError

CONVENTION = (
    "gyro_arw and accel_vrw are two-sided, Allan's N; b_stability (b_drift) with b_corr is the "
    "stationary deviation of a Gauss-Markov process (source, pathgen.bias_drift, since February "
    "2021; before, the driving noise b dt)"
)
TERMS = terms_of(
    "gnss-ins-sim",
    ("gyro_arw", "gyroscope", "angle_random_walk", "°/√h"),
    ("gyro_b_stability", "gyroscope", DEVIATION, "°/h"),
    ("gyro_b_corr", "gyroscope", CORRELATION_TIME, "s"),
    ("accel_vrw", "accelerometer", "velocity_random_walk", "m/s/√h"),
    ("accel_b_stability", "accelerometer", DEVIATION, "m/s²"),
    ("accel_b_corr", "accelerometer", CORRELATION_TIME, "s"),
)
_PREFIX = {"gyroscope": "gyro", "accelerometer": "accel"}
_KNOWN = (
    *(term.name for term in TERMS),
    *(f"{prefix}_{name}" for prefix in _PREFIX.values() for name in ("b", "b_drift")),
    *("mag_std", "mag_si", "mag_hi"),
)
_CHOICES = {
    "deviation": "the deviation of the bias, as gnss-ins-sim simulates it since February 2021",
    "driving": "the driving noise b dt per sample, as it did before (needs --rate)",
}
#: Correlation time (s) that is written beside a bias of zero.
_UNUSED_TIME = 100.0
_QUESTION = "gnss-ins-sim's b_stability has changed its meaning"


def _is_driving(assumptions: Assumptions) -> bool:
    """Whether the program is an old one; if unsaid, today's, which does what its names say."""
    if "b_stability" not in assumptions.answers:
        return False
    return assumptions.answer("b_stability", _QUESTION, _CHOICES) == "driving"


def recognises(text: str) -> bool:
    """The gyroscope's random walk under its name there."""
    return bool(re.search(r"(?m)^[^#\n]*(['\"]gyro_arw['\"]\s*:|\bgyro_arw\s*=)", text))


def read(text: str, source: str, assumptions: Assumptions) -> Reading:
    """The dictionary, as it stands in a Python file (``np.array``, lists, plain arithmetic).

    Raises
    ------
    InputError
        No such dictionary; a missing, unknown or odd value; a question.
    """
    given = dictionary_with(text, source, "gyro_arw")
    for name, known in given.items():
        refuse_unknown(name, _KNOWN, known.place.removesuffix(f": {name}"))
    elements: dict[str, dict[str, Values]] = {"gyroscope": {}, "accelerometer": {}}
    for term in TERMS:
        entry = _entry(given, term.name, source)
        if entry is None:
            if term.key == RANDOM_WALK[term.element]:
                raise InputError(f"{source}: {term.name}: is missing")
            continue
        values = plain_numbers(_finite(entry.value()), entry.place)
        elements[term.element][term.key] = tuple(value * term.si for value in values)
    notes = []
    for element, quantities in elements.items():
        elements[element] = _bias(quantities, element, source, assumptions)
        if DEVIATION in elements[element] and "b_stability" not in assumptions.answers:
            notes.append(
                f"{_PREFIX[element]}_b_stability taken as the deviation of the bias; of versions "
                "before February 2021 say --assume b_stability=driving"
            )
        constant = given.get(f"{_PREFIX[element]}_b")
        if constant is not None and _nonzero(constant):
            notes.append(f"{_PREFIX[element]}_b, a known constant bias, is not carried over")
    return Reading(Description(None, None, elements), tuple(notes))


def _entry(given: dict[str, Entry], name: str, source: str) -> Entry | None:
    """An item, or the one under the name that older versions had."""
    former = name.replace("b_stability", "b_drift")
    if former != name and name in given and former in given:
        raise InputError(f"{source}: {name} and {former} say the same thing twice; keep one")
    return given.get(name, given.get(former))


def _nonzero(entry: Entry) -> bool:
    """Whether it holds anything but zeros, or is not to be told."""
    try:
        value = entry.value()
    except InputError:
        return True
    return any(value) if isinstance(value, tuple) else bool(value)


def _finite(value: Value) -> Value:
    """Infinite correlation times are dealt with apart."""
    if isinstance(value, tuple):
        return tuple(0.0 if item == math.inf else item for item in value)
    return 0.0 if value == math.inf else value


def _bias(
    quantities: dict[str, Values],
    element: str,
    source: str,
    assumptions: Assumptions,
) -> dict[str, Values]:
    """The Gauss-Markov process that the drift and its time mean, or none."""
    drift = quantities.pop(DEVIATION, (0.0,))
    time = quantities.pop(CORRELATION_TIME, (0.0,))
    if not any(drift):
        return quantities
    name = f"{_PREFIX[element]}_b_corr"
    if not all(time):
        raise InputError(
            f"{source}: {name}: is infinite or missing; gnss-ins-sim then adds b_stability as "
            "white noise to every sample, which is no bias: add it to the random walk "
            "(N² + b²/fs) and set b_stability to zero, or give a finite time"
        )
    if _is_driving(assumptions):
        rate = assumptions.required_rate("the driving noise of gnss-ins-sim depends on the rate")
        drift = tuple(
            b * _gain(tc, rate, f"{source}: {name}")
            for b, tc in zip(three(drift), three(time), strict=True)
        )
        if len(set(drift)) == 1:
            drift = drift[:1]
    return {**quantities, DEVIATION: drift, CORRELATION_TIME: time}


def _gain(correlation_time: float, rate: float, name: str) -> float:
    """Stationary deviation of the recursion before 2021 over its parameter."""
    step = 1.0 / rate
    if not 2.0 * correlation_time > step:
        raise InputError(f"{name}: {correlation_time:g} s is too short for a rate of {rate:g} Hz")
    return step / math.sqrt(1.0 - (1.0 - step / correlation_time) ** 2)


def write(sensor: Description, assumptions: Assumptions) -> str:
    """The dictionary for ``imu_model.IMU(accuracy=…)``; absent terms are zero.

    Raises
    ------
    InputError
        An element is missing, or an unanswered question.
    """
    lines = []
    carried = [*RANDOM_WALK.values(), "noise_density", DEVIATION, CORRELATION_TIME]
    for element in ("gyroscope", "accelerometer"):
        quantities = element_or_refuse(sensor, element, "gnss-ins-sim")
        lines.append(f"    '{_PREFIX[element]}_b': np.array([0.0, 0.0, 0.0]),")
        tool = f"gnss-ins-sim's {_PREFIX[element]}_b_stability"
        process = process_of(quantities, element, tool, assumptions)
        drift: Values = (0.0,) * 3
        time: Values = (_UNUSED_TIME,) * 3
        origin = ""
        if process is not None:
            drift = process.deviation
            time = process.time if any(drift) else time
            origin = f", {process.origin}" if process.origin else ""
            carried += ["bias_instability"] if origin else []
        if any(drift) and _is_driving(assumptions):
            rate = sensor.rate or assumptions.required_rate("the driving noise depends on the rate")
            drift = tuple(
                b / _gain(tc, rate, f"{element}: {CORRELATION_TIME}")
                for b, tc in zip(drift, time, strict=True)
            )
        held = {
            RANDOM_WALK[element]: three(two_sided(quantities, element) or (0.0,)),
            DEVIATION: drift,
            CORRELATION_TIME: time,
        }
        for term in TERMS:
            if term.element == element:
                texts = ", ".join(number(value / term.si) for value in held[term.key])
                remark = term.unit + (origin if term.key == DEVIATION else "")
                lines.append(f"    '{term.name}': np.array([{texts}]),  # {remark}")
    head = [*without_words(sensor, carried), "import numpy as np", "", "imu_err = {"]
    return "\n".join([*head, *lines, "}"]) + "\n"


DIALECT = Dialect(
    "gnss-ins-sim",
    "gnss-ins-sim accuracy dictionary",
    CONVENTION,
    recognises,
    read,
    write,
    terms=TERMS,
    ending=".py",
)
