"""What makes an attitude wrong in ``mcsim table attitude-drift``: tilts, gyroscopes, the earth.

Biases and random walks of the grades are in the ranges of Table 1 of El-Sheimy and Youssef,
"Inertial sensors technologies for navigation applications: state of the art and future trends",
*Satellite Navigation* 1:2 (2020): of tactical ones (1 to 10 °/h) the best, of the others the ends
that it prints; 0.1 °/s of a commercial one is also the miscalibration that the planar paper
supposes.  Noise densities of named gyroscopes are those of the catalogue.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from mcsim import catalogue
from mcsim.errors import InputError, UnitError
from mcsim.papers.application_note import PRINTED
from mcsim.simulation.attitude_drift import (
    ANGLE_RANDOM_WALK,
    EARTH_RATE,
    LEVELLED,
    LEVELLED_AND_TURNED,
    TILT,
    TURN_RATE,
    Source,
)
from mcsim.units import KINDS, STANDARD_GRAVITY, parse

#: One second, and the times of the note (s).
TIMES = (1.0, 10.0, 60.0, 600.0, 3600.0)
#: Tilts of the note that are drawn: its smallest, and what it says of the UM7.
_TILTS = ("0.1 °", "2 °")
#: An accelerometer's offset as the planar paper supposes it.
_OFFSET = "0.01 m/s²"
#: Grades of gyroscopes: bias, and angle random walk where the source gives a number.
_GRADES = {
    "commercial": ("0.1 °/s", None),
    "tactical": ("1 °/h", "0.05 °/√h"),
    "navigation": ("0.01 °/h", "0.002 °/√h"),
}
_NAMED = ("LSM330DL", "CMR3000-D01")
_LATITUDE = 45.0
_GYROSCOPE = "sensors.gyroscope"
_DENSITY = "angular rate noise density"
_NO_NOISE = "0 °/s/√Hz"


def sources(bias: str = "", noise: str = "") -> list[Source]:
    """All of them, and the user's own gyroscope where its bias or its noise is given.

    Raises
    ------
    InputError
        A bias that is no angular rate, or a noise that is no random walk and no density.
    """
    return [*_tilts(), *_levelled(), *_biases(bias), *_walks(noise)]


def _tilts() -> Iterator[Source]:
    for angle in _TILTS:
        values = {"initial.pitch_error": angle}
        size = parse(angle, KINDS["angle"])
        printed = dict(zip(TIMES[1:], PRINTED[angle][2:], strict=True))
        yield Source("tilt", angle, TILT, size, values, printed)


def _levelled() -> Iterator[Source]:
    offset = {"noise_density": "0 µg/√Hz", "turn_on_bias": [_OFFSET, "0 m/s²", "0 m/s²"]}
    values = {"sensors.accelerometer": offset, "initial.levelling": {"duration": "10 s"}}
    tilt = parse(_OFFSET, KINDS["acceleration"]) / STANDARD_GRAVITY
    group = "levelled"
    yield Source(group, f"offset {_OFFSET}", LEVELLED, tilt, values)
    turned = f"offset {_OFFSET}, turned round half-way"
    yield Source(group, turned, LEVELLED_AND_TURNED, tilt, values, turned=True)


def _biases(own: str) -> Iterator[Source]:
    for grade, (bias, _) in _GRADES.items():
        yield _bias(f"{grade}, {bias}", bias)
    if own:
        yield _bias(f"yours, {own}", own)
    rate = EARTH_RATE * math.cos(math.radians(_LATITUDE))
    per_hour = f"{math.degrees(rate) * 3600.0:.12g} °/h"
    yield _bias(f"the earth's rate at {_LATITUDE:g}°, untold", per_hour)


def _bias(name: str, bias: str) -> Source:
    size = _parsed("bias", bias, "angular rate")
    values = {_GYROSCOPE: {"noise_density": _NO_NOISE, "turn_on_bias": bias}}
    return Source("gyroscope bias", name, TURN_RATE, size, values)


def _walks(own: str) -> Iterator[Source]:
    for sensor in _NAMED:
        density = str(catalogue.element(sensor, "gyroscope")["noise_density"])
        yield _noise(f"{sensor}, {density}", density)
    for grade, (_, walk) in _GRADES.items():
        if walk is not None:
            yield _noise(f"{grade}, {walk}", walk)
    if own:
        yield _noise(f"yours, {own}", own)


def _noise(name: str, noise: str) -> Source:
    """An angle random walk (two-sided), or a noise density (one-sided, sqrt 2 larger)."""
    try:
        # A unit that both may have is a data sheet's.
        size, key = parse(noise, KINDS[_DENSITY]) / math.sqrt(2.0), "noise_density"
    except UnitError:
        size, key = _parsed("noise", noise, "angle random walk"), "angle_random_walk"
    if size <= 0.0:
        raise InputError(f'attitude-drift: noise: "{noise}" must be above zero')
    values = {_GYROSCOPE: {key: noise}}
    return Source("angle random walk", name, ANGLE_RANDOM_WALK, size, values)


def _parsed(setting: str, text: str, kind: str) -> float:
    try:
        value = parse(text, KINDS[kind])
    except UnitError as error:
        raise InputError(f"attitude-drift: {setting}: {error}") from None
    if value <= 0.0:
        raise InputError(f'attitude-drift: {setting}: "{text}" must be above zero')
    return value
