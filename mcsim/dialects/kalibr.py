"""Kalibr's ``imu.yaml``.

Its wiki (IMU Noise Model) defines the white noise by ``E[n(t1) n(t2)] = σ² δ(t1 - t2)`` and
simulates it with ``σ / √Δt``: σ is Allan's N, although the parameter is called a noise
density.  The bias is a Wiener process of increments ``σ_b √Δt``: σ_b is Allan's K.
"""

from __future__ import annotations

import math

from mcsim.dialects.description import (
    BIAS_WALK,
    RANDOM_WALK,
    Assumptions,
    Description,
    Reading,
    Values,
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
    "*_noise_density is two-sided, Allan's N, variance σ² / Δt per sample, "
    "a data sheet's density over √2; *_random_walk is Allan's K (Kalibr wiki, IMU Noise Model)"
)
TERMS = (
    Term("accelerometer_noise_density", "accelerometer", "velocity_random_walk", "m/s²/√Hz"),
    Term("accelerometer_random_walk", "accelerometer", "acceleration_random_walk", "m/s³/√Hz"),
    Term("gyroscope_noise_density", "gyroscope", "angle_random_walk", "rad/s/√Hz"),
    Term("gyroscope_random_walk", "gyroscope", "rate_random_walk", "rad/s²/√Hz"),
)


def read(text: str, source: str, _: Assumptions) -> Reading:
    """An ``imu.yaml``, or the ``imu0`` block of a calibration result.

    Raises
    ------
    InputError
        A parameter is missing or no number.
    """
    document = parse_document(text, source)
    prefix = ("imu0",) if "imu0" in document.tree else ()
    elements: dict[str, dict[str, Values]] = {"accelerometer": {}, "gyroscope": {}}
    for term in TERMS:
        value, place = required(document, (*prefix, term.name))
        values = plain_numbers(value, place)
        if len(values) != 1:
            raise InputError(f"{place}: Kalibr has one number for all axes")
        elements[term.element][term.key] = (values[0] * term.si,)
    rate, place = required(document, (*prefix, "update_rate"))
    return Reading(Description(None, plain_numbers(rate, place)[0], elements))


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
        if values is None or not all(values):
            name = "a white noise" if is_white else f"`{BIAS_WALK[term.element]}`, Allan's K,"
            raise InputError(
                f"Kalibr needs {name} above zero for the {term.element}; this sensor gives none"
            )
        value = assumptions.one(values, f"{term.element}: {term.key}") / term.si
        assert math.isfinite(value)
        lines.append(f"{term.name}: {number(value)}  # {term.unit}")
    carried = [*RANDOM_WALK.values(), *BIAS_WALK.values(), "noise_density"]
    return (
        "\n".join(
            [
                *without_words(sensor, carried),
                *lines,
                'rostopic: "/imu0"',
                f"update_rate: {number(rate)}",
            ]
        )
        + "\n"
    )
