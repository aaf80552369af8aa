"""The Gauss-Markov process that a tool wants where a sensor has a bias instability.

A data sheet's bias instability is Allan's B, of flicker noise without a correlation time; some
tools simulate a first-order Gauss-Markov process instead.  No such process is flicker noise, so
that its deviation follows from a convention, and its correlation time from nothing: both are
asked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mcsim.dialects.description import (
    CORRELATION_TIME,
    DEVIATION,
    Assumptions,
    Quantities,
    Values,
    three,
)
from mcsim.units import KINDS

#: Floor of the Allan deviation of flicker noise over B: √(2 ln 2 / π).
FLOOR = math.sqrt(2.0 * math.log(2.0) / math.pi)
#: Largest Allan deviation of a Gauss-Markov process over its deviation, at 1.89 Tc:
#: max of (2/x) (1 - (3 - 4 e^-x + e^-2x) / (2x)), x = τ / Tc, and its root.
PEAK = 0.6173642831444414
_CONVENTIONS = {
    "deviation": "{name} = B, as many take it",
    "peak": "{name} = 1.08 B: the process whose largest Allan deviation is B's floor, 0.664 B",
    "none": "{name} = 0: the bias instability is left out",
}


@dataclass(frozen=True)
class Process:
    """Deviation and correlation time (s) per axis; ``origin`` says where they come from."""

    deviation: Values
    time: Values
    origin: str = ""


def process_of(
    quantities: Quantities, element: str, name: str, assumptions: Assumptions
) -> Process | None:
    """The process of an element, its own or that of its bias instability; None if it has none.

    ``name`` is what the tool calls the deviation.

    Raises
    ------
    InputError
        It has a bias instability alone, and the convention or the time was not stated.
    """
    if any(quantities.get(DEVIATION, ())):
        return Process(three(quantities[DEVIATION]), three(quantities[CORRELATION_TIME]))
    instability = quantities.get("bias_instability", ())
    if not any(instability):
        return None
    question = (
        f"the {element} has a bias instability, Allan's B, and {name} is the deviation of a "
        "Gauss-Markov process"
    )
    choices = {key: words.format(name=name) for key, words in _CONVENTIONS.items()}
    chosen = assumptions.answer("bias", question, choices)
    if chosen == "none":
        return Process((0.0,) * 3, (0.0,) * 3, "bias instability left out as stated")
    time = assumptions.quantity(
        "correlation_time",
        f"{name} needs a correlation time, which a bias instability has not",
        KINDS["time"],
        "1 h",
    )
    scale = FLOOR / PEAK if chosen == "peak" else 1.0
    words = "1.08 B" if chosen == "peak" else "B"
    return Process(
        tuple(scale * value for value in three(instability)),
        (time,) * 3,
        f"{words} of the bias instability, correlation time as stated",
    )
