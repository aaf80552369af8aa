"""Kalibr's ``imu.yaml``.

Its wiki (IMU Noise Model) defines the white noise by ``E[n(t1) n(t2)] = σ² δ(t1 - t2)`` and
simulates it with ``σ / √Δt``: σ is Allan's N, although the parameter is called a noise
density.  The bias is a Wiener process of increments ``σ_b √Δt``: σ_b is Allan's K.
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
from mcsim.dialects.dialect import Dialect
from mcsim.dialects.foreign import (
    element_or_refuse,
    foreign_document,
    one_number,
    plain_numbers,
    required,
    within,
    without_words,
)
from mcsim.dialects.numbers import number
from mcsim.dialects.terms import terms_of
from mcsim.errors import InputError
from mcsim.scenario.document import Document

CONVENTION = (
    "*_noise_density is two-sided, Allan's N, variance σ² / Δt per sample, "
    "a data sheet's density over √2; *_random_walk is Allan's K (Kalibr wiki, IMU Noise Model)"
)
TERMS = terms_of(
    "Kalibr",
    ("accelerometer_noise_density", "accelerometer", "velocity_random_walk", "m/s²/√Hz"),
    ("accelerometer_random_walk", "accelerometer", "acceleration_random_walk", "m/s³/√Hz"),
    ("gyroscope_noise_density", "gyroscope", "angle_random_walk", "rad/s/√Hz"),
    ("gyroscope_random_walk", "gyroscope", "rate_random_walk", "rad/s²/√Hz"),
)
_NAMES = {term.name for term in TERMS}


def recognises(text: str) -> bool:
    """A noise density under its name there, outside of comments."""
    return bool(re.search(r"(?m)^[^#\n]*\b(accelerometer|gyroscope)_noise_density\b", text))


def read(text: str, source: str, assumptions: Assumptions) -> Reading:
    """An ``imu.yaml``, or the one block of a calibration result that holds an IMU.

    Raises
    ------
    InputError
        A parameter is missing or no number, or there are several IMUs.
    """
    document = _block(foreign_document(text, source))
    elements: dict[str, dict[str, Values]] = {"accelerometer": {}, "gyroscope": {}}
    for term in TERMS:
        value, place = required(document, (term.name,))
        values = plain_numbers(value, place)
        if len(values) != 1:
            raise InputError(f"{place}: Kalibr has one number for all axes")
        elements[term.element][term.key] = (values[0] * term.si,)
    rate = document.tree.get("update_rate")
    if rate is None and assumptions.rate is None:
        raise InputError(
            f"{document.place(())}: update_rate: is missing; write it, or give --rate '200 Hz'"
        )
    if rate is not None:
        rate = one_number(*required(document, ("update_rate",)))
    return Reading(Description(None, rate, elements))


def _block(document: Document) -> Document:
    """The file itself, or the block in it, such as ``imu0``, that holds the parameters."""
    blocks = [
        path
        for path, block in (((), document.tree), *(((k,), b) for k, b in document.tree.items()))
        if isinstance(block, dict) and not _NAMES.isdisjoint(block)
    ]
    if len(blocks) > 1:
        names = " and ".join(path[0] if path else "the file itself" for path in blocks)
        raise InputError(f"{document.source}: {names} hold an IMU each; keep one")
    return within(document, blocks[0]) if blocks and blocks[0] else document


def write(sensor: Description, assumptions: Assumptions) -> str:
    """An ``imu.yaml``.

    Raises
    ------
    InputError
        An element, a white noise, a random walk or the rate is missing: Kalibr needs them all.
    """
    rate = sensor.rate or assumptions.required_rate("Kalibr needs the rate of the IMU")
    lines = []
    for term in TERMS:
        quantities = element_or_refuse(sensor, term.element, "Kalibr")
        is_white = term.key == RANDOM_WALK[term.element]
        values = two_sided(quantities, term.element) if is_white else quantities.get(term.key)
        name = "a white noise" if is_white else f"`{BIAS_WALK[term.element]}`, Allan's K,"
        need = f"Kalibr needs {name} above zero for the {term.element}"
        if values is None or not any(values):
            raise InputError(f"{need}; this sensor gives none")
        value = assumptions.one(values, f"{term.element}: {term.key}") / term.si
        if value == 0.0:
            raise InputError(f"{need}; it is zero on axis {assumptions.axis}, choose another one")
        lines.append(f"{term.name}: {number(value)}  # {term.unit}")
    carried = [*RANDOM_WALK.values(), *BIAS_WALK.values(), "noise_density"]
    lines += ['rostopic: "/imu0"', f"update_rate: {number(rate)}"]
    return "\n".join([*without_words(sensor, carried), *lines]) + "\n"


DIALECT = Dialect("kalibr", "Kalibr imu.yaml", CONVENTION, recognises, read, write, terms=TERMS)
