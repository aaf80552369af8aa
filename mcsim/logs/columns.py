"""Which column of a table is what, and in which unit."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from mcsim.errors import InputError, UnitError
from mcsim.logs.column_file import ColumnFile, shown
from mcsim.logs.date_times import EXAMPLE
from mcsim.logs.model import ACCELEROMETER, GYROSCOPE, KIND, SHORT
from mcsim.logs.names import CHANNELS, TIME, Meaning, Rank, channel_of, meaning_of
from mcsim.logs.titles import factor_of, is_unit, shown_unit
from mcsim.units import KINDS

__all__ = [
    "CHANNELS",
    "TIME",
    "Column",
    "assign",
    "said",
    "time_column",
    "unmatched_units",
    "written_column",
]

_KIND_OF = {TIME: "time", **KIND}
_EXAMPLES = {TIME: "s", ACCELEROMETER: "m/s^2", GYROSCOPE: "deg/s"}
_COUNTS = {ACCELEROMETER: "16384 counts/g", GYROSCOPE: "131 counts/(deg/s)", TIME: "1000 ticks/s"}
_SKIPPED = "-"
#: Columns left aside that a remark names.
_NAMED = 8


@dataclass(frozen=True)
class Column:
    """A column of the table: its place, what it holds, and the SI value of its unit."""

    place: int
    title: str
    name: str
    factor: float
    unit: str


def assign(file: ColumnFile, columns: str | None, units: str | None) -> list[Column]:
    """The columns of a file that hold time, accelerations or rates.

    ``columns`` names all of them in order (``time,accel_x,-,gyro_z``) or some by their title or
    number (``accel_x=ax,time=column 1``); without it names and units of the header say what a
    column is, and what is a sensor's own goes before what was made from it.  ``units`` gives
    units in the same order, or by kind (``accelerometer=g,gyroscope=deg/s,time=ms``).

    Raises
    ------
    InputError
        Nothing is recognised, something occurs twice, or a unit is missing or wrong.
    """
    names = _recognised(file) if columns is None else _stated(file, columns)
    given = _given_units(units, file, names)
    _ask_units(file, names, given)
    found = [_column(file, place, name, given.get(place)) for place, name in names.items()]
    if not set(names.values()) - {TIME}:
        raise _nothing(file)
    return found


def unmatched_units(units: str | None, found: Sequence[Column]) -> list[str]:
    """Parts of ``--units`` that are of no column, such as ``gyroscope=deg/s`` without one."""
    if units is None or "=" not in units:
        return []
    return [
        word.strip()
        for word in units.split(",")
        if not any(_is_meant(word.partition("=")[0].strip(), column.name) for column in found)
    ]


def said(file: ColumnFile, found: Sequence[Column], also: Iterable[int] = ()) -> str:
    """A sentence about which column is used as what, in which unit, and which are not.

    ``also`` are places of columns of text that are used.
    """
    used = ", ".join(
        f'"{column.title}" as {column.name} in {shown_unit(column.unit)}' for column in found
    )
    taken = {column.place for column in found} | set(also)
    others = [f'"{file.title(place)}"' for place in range(file.count) if place not in taken]
    if not others:
        return f"columns: {used}"
    more = f" and {len(others) - _NAMED} more" if len(others) > _NAMED else ""
    return f"columns: {used}; not used: {', '.join(others[:_NAMED])}{more}"


def time_column(file: ColumnFile) -> int | None:
    """Place of the time stamps: numbers before text, plain names first, then those with a unit.

    Raises
    ------
    InputError
        Several columns are equally likely.
    """
    meanings = _meanings(file)
    places = [place for place, meaning in meanings.items() if meaning.name == TIME]
    numbers = [place for place in places if place not in file.layout.texts] or places
    plain = [place for place in numbers if meanings[place].rank == Rank.SENSOR] or numbers
    places = [place for place in plain if is_unit(file.unit(place))] or plain
    # A message's header holds the time of its sensor, other stamps that of its arrival.
    places = [p for p in places if "header.stamp" in file.title(p)] or places
    if len(places) > 1:
        raise _twice(file, meanings, TIME, (places[0], places[1]))
    return places[0] if places else None


def _meanings(file: ColumnFile) -> dict[int, Meaning]:
    """What the titles of columns that hold something say."""
    return {
        place: meaning
        for place, title in enumerate(file.titles or ())
        if place not in file.layout.empty and (meaning := meaning_of(title)) is not None
    }


def _ask_units(file: ColumnFile, names: Mapping[int, str], given: Mapping[int, str]) -> None:
    """Refuse columns without a unit; the message has an option for all of them."""
    bare = [place for place in names if not (given.get(place) or file.unit(place))]
    if not bare:
        return
    unread = [place for place in bare if names[place] == TIME and place in file.layout.texts]
    if unread:
        raise InputError(
            f'{file.path}: "{file.title(unread[0])}" holds no numbers, and no dates and times that '
            f"are read (such as {EXAMPLE}, or a time of day): write them so, or leave this column "
            "out by --columns and give --rate"
        )
    kinds = list(dict.fromkeys(_element_of(names[place]) for place in bare))
    title, name, kind = file.title(bare[0]), names[bare[0]], kinds[0]
    option = ",".join(f"{k}={_EXAMPLES[k]}" for k in kinds)
    counts = next((k for k in kinds if k != TIME), kind)
    raise InputError(
        f'{file.path}: "{title}" ({name}) has no unit; write it in the header, '
        f'"{name} [{_EXAMPLES[kind]}]", or give --units {option} with the units that are right '
        f"(counts of the converter: --units '{counts}={_COUNTS[counts]}')"
    )


def _element_of(name: str) -> str:
    return TIME if name == TIME else CHANNELS[name][0]


def _column(file: ColumnFile, place: int, name: str, given: str | None) -> Column:
    kind = _element_of(name)
    unit, title = given or file.unit(place), file.title(place)
    if given and place in file.layout.dates:
        raise InputError(
            f'{file.path}: column "{title}" holds dates and times, in no unit; leave out '
            f"--units of {kind}"
        )
    try:
        return Column(place, title, name, factor_of(unit, KINDS[_KIND_OF[kind]]), unit)
    except UnitError as error:
        raise InputError(
            f'{file.path}: column "{title}": {error}; state it by --units {kind}={_EXAMPLES[kind]}'
        ) from None


def _recognised(file: ColumnFile) -> dict[int, str]:
    """Places and names of the columns that the header says to be a sensor's."""
    if file.titles is None:
        doubt = f" ({file.layout.doubt})" if file.layout.doubt else ""
        raise InputError(
            f"{file.path}: has no header{doubt}; name its {file.count} columns in order, for "
            "example --columns time,accel_x,accel_y,accel_z (- skips a column), and give --units "
            "(accelerometer=m/s^2,gyroscope=deg/s,time=s)"
        )
    meanings = _meanings(file)
    time = time_column(file)
    named: dict[int, str] = {} if time is None else {time: TIME}
    for element in SHORT:
        named |= _of_element(file, meanings, element)
    return dict(sorted(named.items()))


def _of_element(file: ColumnFile, meanings: Mapping[int, Meaning], element: str) -> dict[int, str]:
    """The columns of one sensor: those of the surest rank, if they are of one sensor."""
    of_element = {
        place: meaning
        for place, meaning in meanings.items()
        if meaning.name != TIME and CHANNELS[meaning.name][0] == element
    }
    best = min((m.rank for m in of_element.values()), default=Rank.VIRTUAL)
    if best == Rank.VIRTUAL:
        return {}
    chosen: dict[str, int] = {}
    for place, meaning in of_element.items():
        if meaning.rank != best or place in file.layout.texts:
            continue
        if meaning.name in chosen:
            raise _twice(file, meanings, meaning.name, (chosen[meaning.name], place))
        chosen[meaning.name] = place
    return {place: name for name, place in chosen.items()}


def _twice(
    file: ColumnFile, meanings: Mapping[int, Meaning], name: str, places: tuple[int, int]
) -> InputError:
    """Two columns are the same; a choice that works is shown: the first of each."""
    first: dict[str, int] = {}
    for place, meaning in sorted(meanings.items(), key=lambda item: (item[1].rank, item[0])):
        if meaning.rank < Rank.VIRTUAL:
            first.setdefault(meaning.name, place)
    first[name] = places[0]
    names = [(name_, first[name_]) for name_ in (TIME, *CHANNELS) if name_ in first]
    choice = ",".join(f"{name_}={written_column(file, place)}" for name_, place in names)
    one, other = (file.title(place) for place in places)
    return InputError(
        f'{file.path}: two columns are {name}: "{one}" and "{other}"; name the ones to use, '
        f"for example --columns '{choice}'"
    )


def written_column(file: ColumnFile, place: int) -> str:
    """A column as options take it: its name, or its number where that would not do."""
    titles = file.titles or ()
    name = titles[place].name
    plain = name and not set(name) & set(",='\"") and [t.name for t in titles].count(name) == 1
    return name if plain else f"column {place + 1}"


def _stated(file: ColumnFile, columns: str) -> dict[int, str]:
    words = [word.strip() for word in next(csv.reader([columns], skipinitialspace=True), [])]
    where = str(file.path)
    named: dict[int, str] = {}
    if "=" in columns:
        for word in words:
            name, _, title = (part.strip() for part in word.partition("="))
            place = file.place_of(title)
            if place is None:
                held = ", ".join(file.title(i) for i in range(file.count))
                raise InputError(f'{where}: no column "{title}" (columns: {held})')
            if place in named:
                raise InputError(f'{where}: --columns names the column "{title}" twice')
            named[place] = _known(name, where)
    elif len(words) != file.count:
        raise InputError(
            f"{where}: has {file.count} columns, --columns names {len(words)} (- skips a column)"
        )
    else:
        named = {
            place: _known(word, where)
            for place, word in enumerate(words)
            if word not in ("", _SKIPPED)
        }
    for name in named.values():
        places = [place for place, other in named.items() if other == name]
        if len(places) > 1:
            raise InputError(f"{where}: two columns are {name}: --columns must name one")
    return named


def _known(word: str, where: str) -> str:
    name = word if word in CHANNELS else channel_of(word)
    if name is None:
        raise InputError(
            f'{where}: --columns: "{word}" is none of {TIME}, {", ".join(CHANNELS)}, {_SKIPPED}'
        )
    return name


def _given_units(units: str | None, file: ColumnFile, names: Mapping[int, str]) -> dict[int, str]:
    if units is None:
        return {}
    where, count = file.path, file.count
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
        if key not in (*_KIND_OF, *SHORT.values(), *CHANNELS):
            raise InputError(
                f'{where}: --units: "{key}" is none of {", ".join([*_KIND_OF, *CHANNELS])}'
            )
        given.update({place: unit for place, name in names.items() if _is_meant(key, name)})
    return given


def _is_meant(key: str, name: str) -> bool:
    if key == name:
        return True
    element = CHANNELS[name][0] if name != TIME else None
    return element is not None and key in (element, SHORT[element])


def _nothing(file: ColumnFile) -> InputError:
    titles = file.titles
    held = ", ".join(f'"{shown(t.text)}"' for t in titles[:40]) if titles else ""
    example = f"--columns time,{','.join(CHANNELS)} (- skips a column)"
    if titles:
        places = [i for i in range(file.count) if i not in file.layout.empty | file.layout.texts]
        first = written_column(file, places[-1] if places else 0)
        example = f"--columns 'time=TITLE,accel_x=TITLE' (such as accel_x={first})"
    return InputError(
        f"{file.path}: no accelerometer or gyroscope column is recognised "
        f"({held or f'{file.count} columns'}); name them, for example {example} "
        "with --units accelerometer=m/s^2,gyroscope=deg/s,time=s"
    )
