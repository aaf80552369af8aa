"""One noise figure, such as ``0.2 °/√h``, in all units and dialects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from mcsim.dialects.bias import FLOOR
from mcsim.dialects.description import BIAS_WALK, RANDOM_WALK
from mcsim.dialects.numbers import tidy
from mcsim.dialects.registry import DIALECTS
from mcsim.dialects.terms import kind_of
from mcsim.errors import InputError, UnitError
from mcsim.units import (
    KINDS,
    canonical_unit,
    density_from_random_walk,
    factor,
    parse,
    sample_deviation,
    split,
)

#: Role of a figure by the kind of its unit, where the unit leaves no doubt.
_SURE = {
    "acceleration noise density": ("accelerometer", "noise_density"),
    "angular rate noise density": ("gyroscope", "noise_density"),
    "velocity random walk": ("accelerometer", "velocity_random_walk"),
    "angle random walk": ("gyroscope", "angle_random_walk"),
    "acceleration random walk": ("accelerometer", "acceleration_random_walk"),
    "rate random walk": ("gyroscope", "rate_random_walk"),
}
_OPEN = {"acceleration": "accelerometer", "angular rate": "gyroscope"}
#: Answers to what a plain acceleration or rate stands for.
BIAS_ROLES = ("bias_instability", "allan_minimum")
_DENSITY_UNITS = {
    "accelerometer": ("µg/√Hz", "mg/√Hz", "m/s²/√Hz"),
    "gyroscope": ("°/s/√Hz", "m°/s/√Hz", "°/h/√Hz", "rad/s/√Hz"),
}
_WALK_UNITS = {
    "accelerometer": ("m/s/√h", "m/s/√s", "µg/√Hz"),
    "gyroscope": ("°/√h", "°/√s", "rad/√s"),
}
_BIAS_UNITS = {
    "accelerometer": ("m/s/h", "µg", "mg", "m/s²", "mGal"),
    "gyroscope": ("°/h", "°/s", "rad/s"),
}
_SAMPLE_UNITS = {"accelerometer": ("m/s²", "mg"), "gyroscope": ("°/s", "rad/s")}
_BIAS_WALK_UNITS = {
    "accelerometer": ("m/s/h^1.5", "m/s²/√s", "µg/√s"),
    "gyroscope": ("°/h^1.5", "°/s/√s", "rad/s/√s"),
}


@dataclass(frozen=True)
class Row:
    """A line of the answer: what, its values, the convention behind them, whose dialects."""

    what: str
    values: str
    remark: str = ""
    dialects: tuple[str, ...] = ()


@dataclass(frozen=True)
class Conversion:
    """A figure in all its forms.

    Attributes
    ----------
    meaning : str
        What it was taken for.
    rows : tuple of Row
        Its forms, each with the dialects that write it so.
    """

    meaning: str
    rows: tuple[Row, ...]

    def only(self, dialect: str) -> Conversion:
        """What one dialect holds of it.

        Raises
        ------
        InputError
            The dialect has no place for the figure.
        """
        rows = tuple(row for row in self.rows if dialect in row.dialects)
        if not rows:
            others = dict.fromkeys(name for row in self.rows for name in row.dialects)
            raise InputError(
                f"{self.meaning}: {dialect} has no place for it; {', '.join(others)} have"
            )
        return Conversion(self.meaning, rows)


def convert_quantity(text: str, role: str | None = None, rate: float | None = None) -> Conversion:
    """A noise figure with its unit, in every unit and dialect that it can be written in.

    Parameters
    ----------
    text : str
        Number and unit.
    role : str, optional
        Key that the figure belongs to, where the unit leaves it open or is overruled.
    rate : float, optional
        Sampling rate (Hz), for the deviation of one sample.

    Raises
    ------
    InputError
        No such unit, or a figure whose unit does not say what it is.
    """
    element, key = _role(text, role)
    if key in ("noise_density", RANDOM_WALK[element]):
        return _white(text, element, key, rate)
    if key == BIAS_WALK[element]:
        kind = "acceleration random walk" if element == "accelerometer" else "rate random walk"
        return _single(text, element, key, parse(text, KINDS[kind]), _BIAS_WALK_UNITS)
    kind = "acceleration" if element == "accelerometer" else "angular rate"
    value = parse(text, KINDS[kind])
    return _single(text, element, key, value / (FLOOR if key == "allan_minimum" else 1.0))


def _role(text: str, role: str | None) -> tuple[str, str]:
    value, unit = split(text)
    if value < 0.0:
        raise UnitError(f'"{text}": a noise figure is zero or above')
    name = canonical_unit(unit)
    fitting = [kind for kind in (*_SURE, *_OPEN) if name in KINDS[kind].factors]
    if not unit or not fitting:
        examples = ", ".join(KINDS[kind].example for kind in _SURE)
        raise UnitError(f'"{text}" has no unit of noise; write for example {examples}')
    if fitting[0] in _OPEN:
        element = _OPEN[fitting[0]]
        if role in BIAS_ROLES:
            return element, role
        raise InputError(
            f'"{text}" may be a bias instability or something else; say which:\n'
            "--as bias_instability: Allan's B\n"
            "--as allan_minimum: the floor of the Allan deviation, 0.664 B"
        )
    roles = {_SURE[kind][1]: _SURE[kind] for kind in fitting}
    if role is None:
        return _SURE[fitting[0]]
    if role not in roles:
        raise InputError(f'--as {role}: "{text}" can only be {" or ".join(roles)}')
    return roles[role]


def _white(text: str, element: str, key: str, rate: float | None) -> Conversion:
    value = parse(text, KINDS[kind_of(key, element)])
    walk = value if key != "noise_density" else value / math.sqrt(2.0)
    density = density_from_random_walk(walk) if key != "noise_density" else value
    meanings = {
        "noise_density": "one-sided noise density, as data sheets print it "
        f"(if it is Allan's N: --as {RANDOM_WALK[element]})",
        RANDOM_WALK[element]: "Allan's N, a two-sided density",
    }
    rows = [
        Row(
            "noise density",
            _in(density, element, "noise_density", _DENSITY_UNITS),
            "one-sided",
            ("mcsim", "datasheet"),
        ),
        Row(
            f"{RANDOM_WALK[element].replace('_', ' ')} N",
            _in(walk, element, RANDOM_WALK[element], _WALK_UNITS),
            "two-sided, N = ND / √2",
            ("mcsim", "allan"),
        ),
        *_tools(element, {RANDOM_WALK[element]: walk, "noise_density": density}),
    ]
    if rate is not None:
        deviation = sample_deviation(density, rate)
        units = _in(deviation, element, "resolution", _SAMPLE_UNITS)
        rows.append(Row(f"one sample at {rate:g} Hz", units, "ND √(fs/2) = N √fs"))
    return Conversion(f"{text}: {meanings[key]}", tuple(rows))


def _single(
    text: str,
    element: str,
    key: str,
    value: float,
    units: Mapping[str, tuple[str, ...]] = _BIAS_UNITS,
) -> Conversion:
    if key in BIAS_ROLES:
        rows = [
            Row(
                "bias instability B",
                _in(value, element, "bias_instability", units),
                "flicker",
                ("mcsim", "datasheet", "allan"),
            ),
            Row(
                "least Allan deviation",
                _in(value * FLOOR, element, "bias_instability", units),
                "0.664 B, what imu_utils calls w",
            ),
        ]
        held = {"bias_instability": value}
        what = {"bias_instability": "Allan's B", "allan_minimum": "floor of the Allan deviation"}
        meaning = what[key]
    else:
        name = key.replace("_", " ")
        rows = [
            Row(
                f"{name} K",
                _in(value, element, key, units),
                "Allan variance K² τ / 3",
                ("mcsim", "datasheet", "allan"),
            )
        ]
        held = {key: value}
        meaning = f"Allan's K, {name}"
    rows += _tools(element, held)
    return Conversion(f"{text}: {meaning}", tuple(rows))


def _tools(element: str, held: Mapping[str, float]) -> list[Row]:
    """What the tools that hold one of these quantities write for it."""
    return [
        Row(term.tool, f"{term.name} {_show(held[term.key] / term.si)}", term.remark, (name,))
        for name, dialect in DIALECTS.items()
        for term in dialect.terms
        if term.element == element and term.key in held
    ]


def _in(value: float, element: str, key: str, units: Mapping[str, tuple[str, ...]]) -> str:
    kind = KINDS[kind_of(key, element)]
    return ", ".join(f"{_show(value / factor(unit, kind))} {unit}" for unit in units[element])


def _show(value: float) -> str:
    """Six digits: more than any noise figure is known to."""
    return f"{tidy(value):.6g}"
