"""Titles of columns: a name, and a unit as headers spell it.

``factor_of`` is the way from a header's or an option's unit to its SI value: the closed table of
``mcsim.units``, what headers write for it (``G``, ``m/sec^2``, ``DPS``, ``milliseconds``), and
counts of a converter (``16384 counts/g``, ``0.061 mg/LSB``).
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

from mcsim.errors import UnitError
from mcsim.logs.date_times import DATE_AND_TIME, NANOSECOND
from mcsim.units import KINDS, Kind, canonical_unit, factor

#: Kinds of quantity that columns hold.
_KINDS = tuple(
    KINDS[name] for name in ("time", "acceleration", "angular rate", "speed", "length", "angle")
)
_BRACKETED = re.compile(r"[\[(]([^\[\]()]*(?:\([^()]*\))?[^\[\]()]*)[\])]")
#: Longer titles (characters) hold no unit: patterns of brackets take the square of the length.
_LONGEST = 400
#: What stands in brackets and is no unit: an index or an axis.
_INDEX = re.compile(r"\d|[xyzXYZ]|")
#: A unit without brackets: "Time in ms", "Zeit / s" (DIN 461), "Accel_X  m/(s^2)", "time, s".
_LOOSE = re.compile(r"(?P<name>.*?\S)(?:\s+in\s+|\s+/\s+|\s*[,:]\s*|\s+)(?P<unit>\S+)")
#: A unit at the end of a name that a program made.
_SUFFIX = re.compile(
    r"(?P<name>.*[a-zA-Z\d])_(?P<unit>ms|us|ns|sec|secs|msec|usec|nsec|millis|micros|seconds|"
    r"g|mg|m_s2|m_s_2|mps2|dps|mdps|deg_s|rad_s|degs|rads|mps|kmh|kph|mph|knots)",
    re.IGNORECASE,
)
_SUFFIXES = {
    "m_s2": "m/s²", "m_s_2": "m/s²", "mps2": "m/s²", "deg_s": "°/s", "rad_s": "rad/s",
    "degs": "°/s", "rads": "rad/s",
}  # fmt: skip
#: Names of time that say their unit: millis, seconds_elapsed, time_s, TimeUS.
_TIME = re.compile(
    r"(?i:(?P<first>millis|micros|nanos)|(?P<whole>(?:milli|micro|nano)?seconds|secs?|msecs?|usecs?|"
    r"nsecs?))(?:[_ ]?elapsed.*|[_ ]?since.*)?|(?i:t|time|timestamp|elapsed)(?:_?(?P<last>[mun]s|"
    r"US|MS|NS|Us|Ms|Ns)|_(?P<second>[sS]))"
)
#: Spellings of headers, in small letters without blanks; longer ones come first.
_SPELLINGS = (
    (r"[\N{RING ABOVE}\N{RING OPERATOR}]|degrees?|degs?", "°"),
    (r"[\N{GREEK SMALL LETTER MU}]", "µ"),
    (r"-?squared|\*\*2|\^2|\^\(2\)", "²"),
    (r"milli-?(?=seconds?|secs?|g)", "m"),
    (r"micro-?(?=seconds?|secs?|g)", "µ"),
    (r"nano-?(?=seconds?|secs?)", "n"),
    (r"millis$", "ms"),
    (r"micros$", "µs"),
    (r"nanos$", "ns"),
    (r"kilomet(?:re|er)s?", "km"),
    (r"met(?:re|er)s?", "m"),
    (r"radians?", "rad"),
    (r"seconds?|secs?", "s"),
    (r"minutes?|mins", "min"),
    (r"hours?|hrs?", "h"),
    (r"miles?/h|mi/h", "mph"),
    (r"knots?|kts?|kn", "kn"),
    (r"km/?h|kmph|kph", "km/h"),
    (r"g-?force|gees?|g_?[0n](?![a-z])", "g"),
    (r"per", "/"),
    (r"(?<=s)2\b", "²"),
    (r"/\((s²|s\*s|s·s)\)|/s/s|/ss\b", "/s²"),
    (r"[·.*]?s(?:\^|\^\()?[-\N{MINUS SIGN}⁻](?:2|²)\)?", "/s²"),
    (r"[·.*]?s(?:\^|\^\()?[-\N{MINUS SIGN}⁻](?:1|¹)\)?", "/s"),
)
_WORDS = {"us": "µs", "ug": "µg"}
_COUNT = r"(?:counts?|cts?|lsbs?|digits?|bits?|ticks?|adc)"
#: What sensitivities are stated for.
_PER_COUNTS = {"acceleration": "g", "angular rate": "(°/s)"}
_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_PER_UNIT = re.compile(rf"({_NUMBER})?\s*{_COUNT}\s*(?:/|per)\s*(.+)", re.IGNORECASE)
_PER_COUNT = re.compile(rf"({_NUMBER})?\s*(.+?)\s*(?:/|per)\s*{_COUNT}", re.IGNORECASE)
_SCALED = re.compile(rf"({_NUMBER})\s*(\D.*)")


@dataclass(frozen=True)
class Title:
    """A column's title as written, and its two parts: ``az [m/s²]``; ``unit`` may be empty."""

    text: str
    name: str
    unit: str


def split_title(text: str) -> Title:
    """Name and unit of a title such as ``az [m/s²]``, ``Time in ms`` or ``gyro_x_dps``."""
    text = " ".join(text.split())
    if len(text) > _LONGEST:
        return Title(text, text, "")
    brackets = [m for m in _BRACKETED.finditer(text) if not _INDEX.fullmatch(m[1].strip())]
    for match in [m for m in brackets if is_unit(m[1])][-1:]:
        return _of_bracket(text, match)
    plain = re.sub(r"\[\d\]$", "", text)
    loose, suffix, time = (p.fullmatch(plain) for p in (_LOOSE, _SUFFIX, _TIME))
    if (
        loose is not None
        and is_unit(loose["unit"])
        and (len(loose["unit"]) > 1 or loose["unit"] in "sg")
    ):
        return Title(text, loose["name"], loose["unit"])
    if suffix is not None:
        return Title(text, text, _SUFFIXES.get(suffix["unit"].lower(), suffix["unit"]))
    if time is not None:
        return Title(text, text, next(filter(None, time.groups())).lower())
    for match in brackets[-1:]:
        return _of_bracket(text, match)
    return Title(text, text, "")


def _of_bracket(text: str, match: re.Match[str]) -> Title:
    name = " ".join(f"{text[: match.start()]} {text[match.end() :]}".split())
    return Title(text, name, match[1].strip())


def split_titles(texts: Iterable[str], units: Iterable[str] = ()) -> tuple[Title, ...]:
    """Titles of a header, and of a second row that holds their units."""
    titles = tuple(map(split_title, texts))
    of_row = [unit.strip().strip("[]").strip() for unit in units]
    of_row = [unit[1:-1] if re.fullmatch(r"\([^()]*\)", unit) else unit for unit in of_row]
    return tuple(
        Title(title.text, title.name, title.unit or ("" if unit == "-" else unit))
        for title, unit in zip(titles, of_row or [""] * len(titles), strict=True)
    )


def is_unit(text: str) -> bool:
    """Whether a text is a unit of something that a column may hold."""
    return kind_of(text) is not None


@lru_cache(1024)
def kind_of(unit: str) -> Kind | None:
    """The kind of quantity that a header's unit belongs to, or None."""
    for kind in _KINDS:
        try:
            factor_of(unit, kind)
        except UnitError:
            continue
        return kind
    return None


def factor_of(unit: str, kind: Kind) -> float:
    """SI value of a unit as headers and options spell it; of a count where a scale says it.

    Raises
    ------
    UnitError
        An unknown unit, a unit of another kind, or counts without their scale.
    """
    text = unit.strip()
    if text == DATE_AND_TIME and kind.name == "time":
        return NANOSECOND
    per_unit, per_count, scaled = (
        pattern.fullmatch(text) for pattern in (_PER_UNIT, _PER_COUNT, _SCALED)
    )
    if per_unit is not None and per_unit[1] is not None:
        return _plain_factor(_without_brackets(per_unit[2]), kind, unit) / _positive(per_unit[1])
    if re.fullmatch(_COUNT, text, re.IGNORECASE) or per_unit is not None:
        of = per_unit[2] if per_unit else _PER_COUNTS.get(kind.name, kind.example.split()[1])
        raise UnitError(
            f'"{unit}": say how many counts make one unit, for example "16384 counts/{of}" '
            "(the data sheet's sensitivity)"
        )
    if per_count is not None:
        scale = _positive(per_count[1] or "1")
        return scale * _plain_factor(_without_brackets(per_count[2]), kind, unit)
    if scaled is not None:
        return _positive(scaled[1]) * _plain_factor(scaled[2], kind, unit)
    return _plain_factor(text, kind, unit)


def shown_unit(unit: str) -> str:
    """A unit as messages show it: the table's spelling where it has one."""
    for spelling in (canonical_unit(unit), _spelled(unit)):
        if any(spelling in kind.factors for kind in _KINDS):
            return spelling
    return unit.strip()


def _plain_factor(text: str, kind: Kind, whole: str) -> float:
    try:
        return factor(text, kind)
    except UnitError as error:
        for spelling in (_spelled(text), _spelled(text.casefold())):
            if spelling in kind.factors:
                return kind.factors[spelling]
            for other in _KINDS:
                if spelling in other.factors:
                    raise UnitError(
                        f'"{whole}" is {other}; {kind} is needed here, for example '
                        f'"{kind.example.split()[1]}"'
                    ) from None
        raise error


@lru_cache(1024)
def _spelled(text: str) -> str:
    """The table's spelling of what headers write."""
    unit = re.sub(r"\s+", "", text.casefold())
    for pattern, sign in _SPELLINGS:
        unit = re.sub(pattern, sign, unit)
    return canonical_unit(_WORDS.get(unit, unit))


def _positive(text: str) -> float:
    value = float(text)
    if not 0.0 < value < float("inf"):
        raise UnitError(f'"{text}": a scale must be above zero')
    return value


def _without_brackets(text: str) -> str:
    inner = re.fullmatch(r"[\[(](.*)[\])]", text.strip())
    return inner[1] if inner else text
