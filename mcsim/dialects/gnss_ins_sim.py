"""gnss-ins-sim's accuracy dictionary (Python).

Its source adds white noise of ``vrw / √dt``: Allan's N.  The bias drift is documented as a
stability with a correlation time, but simulated as ``x += -x dt/Tc + b dt w`` from zero, so
that its stationary deviation is ``b dt / √(1 - (1 - dt/Tc)²)``, about b √(dt Tc / 2), and
depends on the rate; an infinite time gives white noise of deviation b per sample.
"""

from __future__ import annotations

import ast
import math
import warnings

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
from mcsim.dialects.foreign import Term, element_or_refuse, plain_numbers, without_words
from mcsim.dialects.numbers import number
from mcsim.errors import InputError

CONVENTION = (
    "gyro_arw and accel_vrw are two-sided, Allan's N; b_stability (b_drift) with b_corr is called "
    "a stability, but simulated with b dt as the driving noise (source, pathgen.bias_drift)"
)
TERMS = (
    Term("gyro_arw", "gyroscope", "angle_random_walk", "°/√h"),
    Term("gyro_b_stability", "gyroscope", DEVIATION, "°/h"),
    Term("gyro_b_corr", "gyroscope", CORRELATION_TIME, "s"),
    Term("accel_vrw", "accelerometer", "velocity_random_walk", "m/s/√h"),
    Term("accel_b_stability", "accelerometer", DEVIATION, "m/s²"),
    Term("accel_b_corr", "accelerometer", CORRELATION_TIME, "s"),
)
_PREFIX = {"gyroscope": "gyro", "accelerometer": "accel"}
_CHOICES = {
    "deviation": "the deviation of the bias, as the documentation suggests",
    "driving": "what the program simulates with it: driving noise b dt per sample (needs --rate)",
}
_QUESTION = "gnss-ins-sim's b_stability means one thing by its name and another in its code"


def read(text: str, source: str, assumptions: Assumptions) -> Reading:
    """The dictionary, as it stands in a Python file (``np.array`` or lists).

    Raises
    ------
    InputError
        No such dictionary, a missing or odd value, an unanswered question.
    """
    given = _dictionary(text, source)
    elements: dict[str, dict[str, Values]] = {"gyroscope": {}, "accelerometer": {}}
    for term in TERMS:
        name = term.name
        if name not in given and name.replace("b_stability", "b_drift") in given:
            name = name.replace("b_stability", "b_drift")
        if name not in given:
            if term.key == RANDOM_WALK[term.element]:
                raise InputError(f"{source}: {name}: is missing")
            continue
        values = plain_numbers(_finite(given[name]), f"{source}: {name}")
        elements[term.element][term.key] = tuple(value * term.si for value in values)
    notes = []
    for element, quantities in elements.items():
        elements[element] = _bias(quantities, element, source, assumptions)
        if _nonzero(given.get(f"{_PREFIX[element]}_b")):
            notes.append(f"{_PREFIX[element]}_b, a known constant bias, is not carried over")
    return Reading(Description(None, assumptions.rate, elements), tuple(notes))


def _nonzero(value: object) -> bool:
    """Whether a number or a list holds anything but zeros."""
    return any(value) if isinstance(value, list) else bool(value)


def _finite(value: object) -> object:
    """Infinite correlation times are dealt with apart."""
    items = value if isinstance(value, list) else [value]
    finite = [0.0 if item == math.inf else item for item in items]
    return finite if isinstance(value, list) else finite[0]


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
    if assumptions.answer("b_stability", _QUESTION, _CHOICES) == "driving":
        rate = assumptions.required_rate("the driving noise of gnss-ins-sim depends on the rate")
        drift = tuple(b * _gain(tc, rate) for b, tc in zip(three(drift), three(time), strict=True))
        if len(set(drift)) == 1:
            drift = drift[:1]
    return {**quantities, DEVIATION: drift, CORRELATION_TIME: time}


def _gain(correlation_time: float, rate: float) -> float:
    """Stationary deviation of gnss-ins-sim's recursion over its parameter."""
    step = 1.0 / rate
    return step / math.sqrt(1.0 - (1.0 - step / correlation_time) ** 2)


def _dictionary(text: str, source: str) -> dict[str, object]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)
            tree = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        line = getattr(error, "lineno", None)
        raise InputError(f"{source}:{line or 1}: not Python text") from None
    for node in ast.walk(tree):
        if isinstance(node, ast.Dict):
            keys = [key.value for key in node.keys if isinstance(key, ast.Constant)]
            if len(keys) == len(node.keys) and "gyro_arw" in keys:
                items = zip(keys, node.values, strict=True)
                return {str(key): _literal(value, source) for key, value in items}
    raise InputError(f"{source}: no dictionary with a `gyro_arw` in it")


def _literal(node: ast.expr, source: str) -> object:
    if isinstance(node, ast.Call) and node.args:  # np.array([...]), float("inf")
        node = node.args[0]
    if isinstance(node, ast.List | ast.Tuple):
        return [_literal(item, source) for item in node.elts]
    try:
        value = ast.literal_eval(node)
    except (ValueError, TypeError):
        raise InputError(
            f"{source}:{node.lineno}: only plain numbers and np.array are read here"
        ) from None
    return math.inf if value == "inf" else value


def write(sensor: Description, assumptions: Assumptions) -> str:
    """The dictionary for ``imu_model.IMU(accuracy=…)``; absent terms are zero.

    Raises
    ------
    InputError
        An element is missing, or an unanswered question.
    """
    lines = []
    for element in ("gyroscope", "accelerometer"):
        quantities = element_or_refuse(sensor, element, "gnss-ins-sim")
        lines.append(f"    '{_PREFIX[element]}_b': np.array([0.0, 0.0, 0.0]),")
        drift = three(quantities.get(DEVIATION, (0.0,)))
        time = three(quantities.get(CORRELATION_TIME, (100.0,)))
        if any(drift) and assumptions.answer("b_stability", _QUESTION, _CHOICES) == "driving":
            rate = sensor.rate or assumptions.required_rate("the driving noise depends on the rate")
            drift = tuple(b / _gain(tc, rate) for b, tc in zip(drift, time, strict=True))
        held = {
            RANDOM_WALK[element]: three(two_sided(quantities, element) or (0.0,)),
            DEVIATION: drift,
            CORRELATION_TIME: time,
        }
        for term in TERMS:
            if term.element == element:
                texts = ", ".join(number(value / term.si) for value in held[term.key])
                lines.append(f"    '{term.name}': np.array([{texts}]),  # {term.unit}")
    carried = [*RANDOM_WALK.values(), "noise_density", DEVIATION, CORRELATION_TIME]
    head = [*without_words(sensor, carried), "import numpy as np", "", "imu_err = {"]
    return "\n".join([*head, *lines, "}"]) + "\n"
