"""Which column of a table is what, and in which unit."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mcsim.errors import InputError, UnitError
from mcsim.logs.csv_file import Title
from mcsim.logs.model import ACCELEROMETER, AXES, GYROSCOPE, KIND, SHORT
from mcsim.units import KINDS, factor

TIME = "time"
#: Names of channels as ``--columns`` takes them.
CHANNELS = {f"{short}_{axis}": (element, axis) for element, short in SHORT.items() for axis in AXES}
_KIND_OF = {TIME: "time", **KIND}
_EXAMPLES = {TIME: "s", ACCELEROMETER: "m/s^2", GYROSCOPE: "deg/s"}
_SKIPPED = "-"

_TIME_NAME = re.compile(
    r"(time|timestamp|stamp|times|t|sec|secs|seconds|millis)(_.*)?|.*_timestamp"
)
_ACCELERATION_NAME = re.compile(
    r"(?:.*_)?(?:a|acc|accel|acceleration|accelerometer|lin_?acc|linear_acceleration|"
    r"specific_force|a_rs_s)_?(?P<axis>[xyz])"
)
_RATE_NAME = re.compile(
    r"(?:.*_)?(?:g|w|gyr|gyro|gyroscope|omega|angular_velocity|ang_?vel|angular_rate|"
    r"w_rs_s)_?(?P<axis>[xyz])"
)
_TURN_NAMES = {"roll": "x", "pitch": "y", "yaw": "z"}


@dataclass(frozen=True)
class Column:
    """A column of the table: its place, what it holds, and the SI value of its unit."""

    place: int
    title: str
    name: str
    factor: float
    unit: str


def assign(
    titles: Sequence[Title] | None, count: int, columns: str | None, units: str | None, where: str
) -> list[Column]:
    """The columns that matter, of a table with ``count`` columns and perhaps a header.

    ``columns`` names all of them in order (``time,accel_x,-,gyro_z``) or some by their
    title (``accel_x=ax,time=t``); ``units`` gives units in the same order, or by kind
    (``accelerometer=g,gyroscope=deg/s,time=ms``).

    Raises
    ------
    InputError
        Nothing is recognised, something occurs twice, or a unit is missing or wrong.
    """
    names = _names(titles, count, columns, where)
    given = _given_units(units, count, names, where)
    found: dict[str, Column] = {}
    for place, name in names.items():
        if name in found:
            raise InputError(f"{where}: two columns are {name}; name one by --columns")
        kind = TIME if name == TIME else CHANNELS[name][0]
        unit = given.get(place) or (titles[place].unit if titles else "")
        title = titles[place].text if titles else f"column {place + 1}"
        if not unit:
            raise InputError(
                f'{where}: "{title}" ({name}) has no unit; write it in the header, '
                f'"{name} [{_EXAMPLES[kind]}]", or give --units {kind}={_EXAMPLES[kind]}'
            )
        try:
            scale = factor(unit, KINDS[_KIND_OF[kind]])
        except UnitError as error:
            raise InputError(f'{where}: column "{title}": {error}') from None
        found[name] = Column(place, title, name, scale, unit)
    if not set(found) - {TIME}:
        held = ", ".join(f'"{title.text}"' for title in titles) if titles else f"{count} columns"
        raise InputError(
            f"{where}: no accelerometer or gyroscope column is recognised ({held}); "
            f"name them, for example --columns time,{','.join(CHANNELS)} "
            f"(- skips a column) with --units accelerometer=m/s^2,gyroscope=deg/s,time=s"
        )
    return list(found.values())


def channel_of(title: str) -> str | None:
    """``time``, a channel's name, or None, from a column's title without its unit."""
    name = re.sub(r"[^a-z0-9]+", "_", title.lower()).strip("_")
    if _TIME_NAME.fullmatch(name):
        return TIME
    for element, pattern in ((ACCELEROMETER, _ACCELERATION_NAME), (GYROSCOPE, _RATE_NAME)):
        match = pattern.fullmatch(name)
        if match:
            return f"{SHORT[element]}_{match['axis']}"
    turn = re.fullmatch(r"(roll|pitch|yaw)_?rate", name)
    return f"{SHORT[GYROSCOPE]}_{_TURN_NAMES[turn[1]]}" if turn else None


def _names(
    titles: Sequence[Title] | None,
    count: int,
    columns: str | None,
    where: str,
) -> dict[int, str]:
    if columns is None:
        if titles is None:
            raise InputError(
                f"{where}: has no header; name its {count} columns in order, for example "
                "--columns time,accel_x,accel_y,accel_z (- skips a column), and give --units"
            )
        named = {place: channel_of(title.name) for place, title in enumerate(titles)}
        return {place: name for place, name in named.items() if name is not None}
    words = [word.strip() for word in columns.split(",")]
    if "=" in columns:
        return _by_title(words, titles, where)
    if len(words) != count:
        raise InputError(
            f"{where}: has {count} columns, --columns names {len(words)} (- skips a column)"
        )
    return {
        place: _known(word, where) for place, word in enumerate(words) if word not in ("", _SKIPPED)
    }


def _by_title(words: Sequence[str], titles: Sequence[Title] | None, where: str) -> dict[int, str]:
    if titles is None:
        raise InputError(f"{where}: has no header; --columns must name all columns in order")
    names = {}
    for word in words:
        name, _, title = (part.strip() for part in word.partition("="))
        places = [i for i, held in enumerate(titles) if title in (held.text, held.name)]
        if not places:
            held = ", ".join(title.text for title in titles)
            raise InputError(f'{where}: no column "{title}" (columns: {held})')
        names[places[0]] = _known(name, where)
    return names


def _known(word: str, where: str) -> str:
    name = word if word in CHANNELS else channel_of(word)
    if name is None:
        raise InputError(
            f'{where}: --columns: "{word}" is none of {TIME}, {", ".join(CHANNELS)}, {_SKIPPED}'
        )
    return name


def _given_units(
    units: str | None, count: int, names: Mapping[int, str], where: str
) -> dict[int, str]:
    if units is None:
        return {}
    words = [word.strip() for word in units.split(",")]
    if "=" not in units:
        if len(words) != count:
            raise InputError(
                f"{where}: has {count} columns, --units holds {len(words)}; give one for each "
                "column, or by kind: --units accelerometer=g,gyroscope=deg/s,time=s"
            )
        return {place: word for place, word in enumerate(words) if word not in ("", _SKIPPED)}
    given: dict[int, str] = {}
    for word in words:
        key, _, unit = (part.strip() for part in word.partition("="))
        places = [place for place, name in names.items() if _is_meant(key, name)]
        if not places and key not in (*_KIND_OF, *SHORT.values(), *CHANNELS):
            raise InputError(
                f'{where}: --units: "{key}" is none of {", ".join([*_KIND_OF, *CHANNELS])}'
            )
        given.update(dict.fromkeys(places, unit))
    return given


def _is_meant(key: str, name: str) -> bool:
    if key == name:
        return True
    element = CHANNELS[name][0] if name != TIME else None
    return element is not None and key in (element, SHORT[element])
