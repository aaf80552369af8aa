"""The closed table of units: text with a unit in, SI floats out, and back.

General unit libraries misread the notation of inertial sensors (``mg`` as
milligram, ``°/√h`` as ``°/h``), so the units that mcsim knows are listed here,
each with the one meaning that it has in a sensor data sheet.

Noise has two conventions and two kinds of quantity:

* a *noise density* is one-sided, as data sheets print it: one sample at rate fs
  has the variance ``ND^2 fs / 2``;
* a *random walk* coefficient (IEEE Std 952, Allan N) belongs to a two-sided
  density: one sample has the variance ``N^2 fs``; so ``ND = √2 N``.

``density_from_random_walk`` is the only place where one becomes the other.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

from mcsim.errors import UnitError
from mcsim.unit_notation import Powers, plain_quantity, powers

STANDARD_GRAVITY = 9.80665  # m/s^2, CGPM 1901

_DEG = math.pi / 180.0
#: Quantities below (in SI units) are slips of the pen; fourth powers of what is above are numbers.
_SMALLEST = 1e-30


@dataclass(frozen=True)
class Kind:
    """A kind of quantity: its SI unit, the units it may be written in, its largest value.

    ``accepts`` tells values (SI) that one use of it takes, so that no other is advised.
    """

    name: str
    article: str
    si_unit: str
    factors: Mapping[str, float]
    example: str
    largest: float = 1e6
    accepts: Callable[[float], bool] = lambda _: True

    def __str__(self) -> str:
        return f"{self.article} {self.name}"


def _per(factors: Mapping[str, float], divisors: Mapping[str, float]) -> dict[str, float]:
    return {f"{u}/{d}": f / g for u, f in factors.items() for d, g in divisors.items()}


_LENGTH = {"m": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6}
_TIME = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
_ANGLE = {"°": _DEG, "rad": 1.0, "mrad": 1e-3, "µrad": 1e-6}
_FREQUENCY = {"Hz": 1.0, "kHz": 1e3}
_SPEED = {
    "m/s": 1.0,
    "km/h": 1 / 3.6,
    "mm/s": 1e-3,
    "cm/s": 1e-2,
    "mph": 0.44704,
    "kn": 1852 / 3600,
}
_ACCELERATION = {
    "m/s²": 1.0,
    "mm/s²": 1e-3,
    "cm/s²": 1e-2,
    "g": STANDARD_GRAVITY,
    "mg": STANDARD_GRAVITY * 1e-3,
    "µg": STANDARD_GRAVITY * 1e-6,
}
_RATE = {
    "°/s": _DEG,
    "°/min": _DEG / 60.0,
    "°/h": _DEG / 3600.0,
    "rad/s": 1.0,
    "mrad/s": 1e-3,
    "m°/s": _DEG * 1e-3,
}
_GRADIENT = {
    "°/(m/s²)": _DEG,
    "°/g": _DEG / STANDARD_GRAVITY,
    "rad/(m/s²)": 1.0,
    "mrad/(m/s²)": 1e-3,
}
_ROOT_HERTZ = {"√Hz": 1.0}
_ROOT_TIME = {"√s": 1.0, "√h": 60.0}
#: Data sheets write a change per degree Celsius, which is the same.
_KELVIN = {"K": 1.0, "°C": 1.0}
#: Slow drifts: units of biases and their instability that no noise density is written in.
_DRIFT = {"m/s/h": 1.0 / 3600.0, "Gal": 1e-2, "mGal": 1e-5}
#: The same rate of change per square root of time in three notations: ``K`` of IEEE Std 952.
_ACCELERATION_WALK = {
    **_per(_ACCELERATION, _ROOT_TIME),
    "m/s/h^1.5": 1.0 / 216000.0,
    "m/s/h/√h": 1.0 / 216000.0,
    "m/s/s^1.5": 1.0,
    "m/s³/√Hz": 1.0,
}
_RATE_WALK = {
    **_per(_RATE, _ROOT_TIME),
    "°/h^1.5": _DEG / 216000.0,
    "°/s^1.5": _DEG,
    "rad/s^1.5": 1.0,
    "°/s²/√Hz": _DEG,
    "rad/s²/√Hz": 1.0,
}

_KINDS = (
    Kind("length", "a", "m", _LENGTH, "50 m", largest=1e8),
    Kind("time", "a", "s", _TIME, "100 ms", largest=1e8),
    Kind("angle", "an", "rad", _ANGLE, "0.1 °"),
    Kind("frequency", "a", "Hz", _FREQUENCY, "100 Hz"),
    Kind("speed", "a", "m/s", _SPEED, "20 m/s"),
    Kind("acceleration", "an", "m/s²", {**_ACCELERATION, **_DRIFT}, "0.01 m/s²"),
    Kind("angular rate", "an", "rad/s", _RATE, "0.1 °/s"),
    Kind(
        "acceleration noise density",
        "an",
        "m/s²/√Hz",
        _per(_ACCELERATION, _ROOT_HERTZ),
        "220 µg/√Hz",
    ),
    Kind(
        "angular rate noise density",
        "an",
        "rad/s/√Hz",
        _per(_RATE, _ROOT_HERTZ),
        "0.03 °/s/√Hz",
    ),
    Kind(
        "velocity random walk",
        "a",
        "m/s/√s",
        {**_per({"m/s": 1.0}, _ROOT_TIME), **_per(_ACCELERATION, _ROOT_HERTZ)},
        "0.1 m/s/√h",
    ),
    Kind(
        "angle random walk",
        "an",
        "rad/√s",
        {**_per({"°": _DEG, "rad": 1.0}, _ROOT_TIME), **_per(_RATE, _ROOT_HERTZ)},
        "0.2 °/√h",
    ),
    # Raw output as the sensor gives it: fractions of the local gravity, never m/s².
    Kind("sensor output", "a", "g", {"g": 1.0, "mg": 1e-3, "µg": 1e-6}, "3.8e-3 g"),
    Kind("acceleration random walk", "an", "m/s²/√s", _ACCELERATION_WALK, "5 m/s/h^1.5"),
    Kind("rate random walk", "a", "rad/s/√s", _RATE_WALK, "10 °/h^1.5"),
    Kind(
        "g-sensitivity",
        "a",
        "rad/s/(m/s²)",
        {
            "°/s/g": _DEG / STANDARD_GRAVITY,
            "°/h/g": _DEG / 3600.0 / STANDARD_GRAVITY,
            "rad/s/(m/s²)": 1.0,
        },
        "0.1 °/s/g",
    ),
    Kind(
        "acceleration per kelvin",
        "an",
        "m/s²/K",
        _per(_ACCELERATION, _KELVIN),
        "0.5 mg/K",
    ),
    Kind("angular rate per kelvin", "an", "rad/s/K", _per(_RATE, _KELVIN), "0.03 °/s/K"),
    Kind("ratio per kelvin", "a", "1/K", _per({"%": 1e-2, "ppm": 1e-6}, _KELVIN), "0.01 %/K"),
    # A temperature in °C is none: 20 °C may be meant as 293 K.
    Kind("temperature difference", "a", "K", {"K": 1.0, "mK": 1e-3}, "20 K"),
    Kind(
        "temperature rate",
        "a",
        "K/s",
        _per({"K": 1.0}, {"s": 1.0, "min": 60.0, "h": 3600.0}),
        "2 K/min",
    ),
    Kind("jerk", "a", "m/s³", {"m/s³": 1.0, "g/s": STANDARD_GRAVITY}, "1 m/s³"),
    Kind("rotational speed", "a", "Hz", {"rpm": 1.0 / 60.0, "Hz": 1.0}, "800 rpm"),
    Kind("angle gradient", "an", "rad/(m/s²)", _GRADIENT, "0.3 °/(m/s²)"),
    Kind("ratio", "a", "1", {"%": 1e-2, "ppm": 1e-6}, "1 %"),
    Kind("confidence", "a", "σ", {"σ": 1.0, "%": math.nan}, "3 sigma"),
)

KINDS: dict[str, Kind] = {kind.name: kind for kind in _KINDS}

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(.*)", re.S)
#: Regular expression of a number in a quantity, for the JSON schema.
NUMBER_PATTERN = r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"

# What people type for the signs of the table; longer spellings come first.
_SPELLINGS = (
    ("\N{GREEK SMALL LETTER MU}", "µ"),
    ("\N{MASCULINE ORDINAL INDICATOR}", "°"),
    ("\N{RING ABOVE}", "°"),
    ("**", "^"),
    ("degrees", "°"),
    ("degree", "°"),
    ("deg", "°"),
    ("sigma", "σ"),
    ("percent", "%"),
)
_WORDS = {
    "dps": "°/s",
    "mdps": "m°/s",
    "sec": "s",
    "second": "s",
    "seconds": "s",
    "minute": "min",
    "minutes": "min",
    "hr": "h",
    "hrs": "h",
    "hour": "h",
    "hours": "h",
    "kph": "km/h",
    "kmh": "km/h",
    "ug": "µg",
    "us": "µs",
    "um": "µm",
    "urad": "µrad",
    "hz": "Hz",
    "HZ": "Hz",
    "mps": "m/s",
}


@lru_cache(1024)
def canonical_unit(text: str) -> str:
    """The table's spelling of a unit: ``(deg/s)/sqrt(Hz)`` becomes ``°/s/√Hz``.

    A unit that is not in the table comes back as it is, but for its blanks and signs.
    """
    unit = unicodedata.normalize("NFC", text)
    for spelled, sign in _SPELLINGS:
        unit = unit.replace(spelled, sign)
    unit = plain_quantity(unit)
    bare = re.sub(r"\s+", "", unit)
    if bare in _known_units():
        return bare
    return _units_by_powers().get(powers(unit, _WORDS), bare)


@lru_cache(1)
def _known_units() -> frozenset[str]:
    return frozenset(name for kind in _KINDS for name in kind.factors)


@lru_cache(1)
def _units_by_powers() -> dict[Powers | None, str]:
    """The table's units by their notation; of several spellings the first one."""
    found: dict[Powers | None, str] = {}
    for kind in _KINDS:
        for name in kind.factors:
            found.setdefault(powers(name, _WORDS), name)
    found.pop(None, None)
    return found


def split(text: str) -> tuple[float, str]:
    """Number and unit, both as written (the unit stripped of outer blanks).

    Raises
    ------
    UnitError
        The text does not begin with a finite decimal number.
    """
    match = _NUMBER.fullmatch(text.replace("\N{MINUS SIGN}", "-"))
    if match is None:
        if text.lstrip().startswith("±"):
            raise UnitError(f'"{text}": write it without the sign ±')
        if re.match(r"\s*[-+]?\.?(nan|inf)", text, re.I):
            raise UnitError(f'"{text}" is not a finite number')
        raise UnitError(f'"{text}" does not begin with a number')
    rest = match[2].strip()
    if re.match(r",\d", rest):
        raise UnitError(f'"{text}": write a decimal point, not a comma')
    value = float(match[1])
    if not math.isfinite(value):
        raise UnitError(f'"{text}" is too large a number')
    return value, rest


def parse(text: str, kind: Kind) -> float:
    """The SI value of a quantity written with its unit, such as ``20 m/s``.

    Raises
    ------
    UnitError
        No number, no unit, an unknown unit, or a unit of another kind.
    """
    value, unit = split(text)
    if not unit:
        raise UnitError(
            f'"{text}" has no unit; write for example "{_with_unit_of(text, kind)}" '
            f"(units of {kind}: {', '.join(kind.factors)})"
        )
    si = value * factor(unit, kind, text)
    if abs(si) > kind.largest:
        raise UnitError(
            f'"{text}" is beyond any use; '
            f"the largest {kind.name} is {kind.largest:g} {kind.si_unit}"
        )
    if 0.0 < abs(si) < _SMALLEST:
        raise UnitError(
            f'"{text}" is too small for any use; write zero, or at least '
            f"{_SMALLEST:g} {kind.si_unit}"
        )
    return si


def _with_unit_of(number: str, kind: Kind) -> str:
    """The number with the first unit that makes it one to take; else the example."""
    value = split(number)[0]
    for unit in (split(kind.example)[1], *kind.factors):
        if kind.accepts(value * factor(unit, kind)):
            return f"{number.strip()} {unit}"
    return kind.example


def factor(unit: str, kind: Kind, text: str | None = None) -> float:
    """SI value of one ``unit`` of the given kind.

    Raises
    ------
    UnitError
        An unknown unit, or a unit of another kind; ``text`` is quoted in the message.
    """
    name = canonical_unit(unit)
    if name in kind.factors:
        return kind.factors[name]
    quoted = f'"{text}"' if text is not None else f'"{unit}"'
    for other in _KINDS:
        if name in other.factors:
            raise UnitError(
                f'{quoted} is {other}; {kind} is needed here, for example "{kind.example}"'
                + _noise_hint(kind, other)
            )
    raise UnitError(
        f'{quoted}: unknown unit "{unit}"{_hint(unit, kind, text)} '
        f"(units of {kind}: {', '.join(kind.factors)})"
    )


def _hint(unit: str, kind: Kind, text: str | None) -> str:
    """What the unit may be: only what is worth the same, since people take the advice."""
    if re.search(r"(?<![A-Za-z])(lsb|counts?|digits?)(?![A-Za-z])", unit, re.I):
        return _counts_hint(unit, text)
    written = unit.strip()
    alike = [name for name in kind.factors if _letters(name) == _letters(written)]
    # A capital letter may be a prefix: M is not m.
    if len(alike) == 1 and (written[:1] != "M" or alike[0][:1] == "M"):
        return f'; did you mean "{alike[0]}"?'
    return ""


def _letters(unit: str) -> str:
    """A unit without what is lost by copying it: case, roots, blanks, brackets."""
    return re.sub(r"[^a-zµ°%/²³\d]", "", canonical_unit(unit.lower()).lower())


def _counts_hint(unit: str, text: str | None) -> str:
    """What to write for a figure in steps of the converter, whose size is another figure."""
    for pattern, inverse in ((r"(.+)/LSB", False), (r"LSB/(.+)", True)):
        match = re.fullmatch(pattern, re.sub(r"\s+", "", unit), re.I)
        if match is not None and text is not None and split(text)[0] > 0.0:
            value = split(text)[0]
            step = f"{1.0 / value if inverse else value:.6g} {match[1]}"
            return f'; it is the size of a step: as a resolution write "{step}"'
    return "; a step of the converter is no unit: multiply by its size in the unit"


def _noise_hint(wanted: Kind, given: Kind) -> str:
    if wanted.name.endswith("noise density") and given.name.endswith("random walk"):
        return (
            f"; Allan's N belongs to a two-sided density: write it under "
            f'"{given.name.replace(" ", "_")}" and mcsim converts it'
        )
    return ""


def in_unit(value: float, unit: str, kind: Kind) -> float:
    """An SI value expressed in ``unit``, free of the conversion's last-digit noise."""
    return float(f"{value / factor(unit, kind):.15g}")


def degrees(value: float) -> float:
    """Radian to degree, for tables and figures."""
    return value / _DEG


def parse_confidence(text: str) -> float:
    """Confidence as a number of sigma: ``3 sigma`` is 3, ``95 %`` is 1.96.

    Raises
    ------
    UnitError
        Not a confidence, or outside of 0.1 to 6 sigma.
    """
    kind = KINDS["confidence"]
    value, unit = split(text)
    if not unit:
        raise UnitError(f'"{text}" has no unit; write for example "3 sigma" or "95 %"')
    factor(unit, kind, text)
    if canonical_unit(unit) == "%":
        if not 0.0 < value < 100.0:
            raise UnitError(f'"{text}" must lie between 0 % and 100 %')
        from scipy.special import ndtri

        value = float(-ndtri((1.0 - value / 100.0) / 2.0))
    if not 0.1 <= value <= 6.0:
        raise UnitError(f'"{text}" must lie between 0.1 sigma and 6 sigma')
    return value


def density_from_random_walk(coefficient: float) -> float:
    """One-sided noise density of a two-sided random walk coefficient N: ``√2 N``."""
    return math.sqrt(2.0) * coefficient


def sample_deviation(noise_density: float, rate: float) -> float:
    """Standard deviation of one sample of white noise: ``ND √(fs / 2)``, ND one-sided."""
    return noise_density * math.sqrt(rate / 2.0)
