"""The named columns of a test's file, its outputs in fractions of g."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError, UnitError
from mcsim.logs.column_file import ColumnFile, scaled
from mcsim.logs.columns import Column, said
from mcsim.logs.formats import open_log
from mcsim.logs.names import meaning_of
from mcsim.logs.titles import factor_of
from mcsim.units import KINDS, STANDARD_GRAVITY

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Columns:
    """Columns (n,) of a file by name: ``outputs`` in fractions of g, ``texts`` as written."""

    file: ColumnFile
    outputs: dict[str, Array]
    texts: dict[str, list[str]]

    def where(self, row: int) -> str:
        """File and line of a row, for messages."""
        return f"{self.file.path}:{self.file.line(row)}"


def read_columns(
    path: Path,
    outputs: tuple[str, ...],
    texts: tuple[str, ...] = (),
    optional: tuple[str, ...] = (),
    tell: Callable[[str], None] | None = None,
) -> Columns:
    """Read a log whose header names ``outputs`` and ``texts``, perhaps ``optional`` texts.

    Outputs may be in g, mg, m/s² or counts (``16384 counts/g``), stated in brackets; without a
    unit they are fractions of g.  A column of an axis may also be called as in a log (``ax``,
    ``Acceleration x``).  ``tell`` is told which column was used as what.

    Raises
    ------
    InputError
        No such file, columns missing, a unit that is no acceleration's, a cell that is no number,
        or a line with too many cells.
    """
    file = open_log(path)
    places = _places(file)
    wanted = ", ".join((*texts, *outputs))
    missing = [name for name in (*texts, *outputs) if name not in places]
    if missing:
        raise InputError(
            f"{path}:{max(file.header, 1)}: column {', '.join(missing)} is missing; "
            f"the header must name {wanted}"
            + (f" and may name {', '.join(optional)}" if optional else "")
        )
    file.check_widths()
    columns = {name: _column(file, places[name], name) for name in outputs}
    numbers = file.numbers([places[name] for name in outputs])
    count = len(next(iter(numbers.values())))
    if tell is not None:
        for note in _notes(
            file, columns, [places[name] for name in (*texts, *optional) if name in places]
        ):
            tell(note)
    return Columns(
        file,
        {
            name: scaled(numbers[c.place].astype(float), c.factor, path, c.title)
            for name, c in columns.items()
        },
        {name: file.texts(places[name])[:count] for name in (*texts, *optional) if name in places},
    )


def _places(file: ColumnFile) -> dict[str, int]:
    """Places by name in small letters; axes of an accelerometer by their letter too."""
    titles = file.titles or ()
    places: dict[str, int] = {}
    for i, title in enumerate(titles):
        name = title.name.casefold()
        if name in places:
            raise InputError(f'{file.path}:{file.header}: two columns are called "{title.name}"')
        places[name] = i
    named = [(i, meaning_of(title)) for i, title in enumerate(titles)]
    for axis in "xyz":
        found = [i for i, m in named if m is not None and m.name == f"accel_{axis}"]
        if len(found) == 1:
            places.setdefault(axis, found[0])
    return places


def _column(file: ColumnFile, place: int, name: str) -> Column:
    """The column, with the factor to fractions of standard gravity."""
    unit = file.titles[place].unit if file.titles else ""
    try:
        return Column(place, file.title(place), name, _factor(unit) if unit else 1.0, unit or "g")
    except UnitError as error:
        raise InputError(
            f'{file.path}:{file.header}: column "{file.title(place)}": {error}'
        ) from None


def _factor(unit: str) -> float:
    try:
        return factor_of(unit, KINDS["sensor output"])
    except UnitError:
        return factor_of(unit, KINDS["acceleration"]) / STANDARD_GRAVITY


def _notes(file: ColumnFile, columns: dict[str, Column], texts: list[int]) -> list[str]:
    """Which column is what; that of g, where none is stated, is taken for granted and said."""
    unstated = [f'"{c.title}"' for c in columns.values() if not (file.titles or ())[c.place].unit]
    notes = [said(file, list(columns.values()), texts), *file.notes]
    if unstated:
        notes.append(f"{', '.join(unstated)} without a unit: taken as fractions of g")
    return [*notes, *metres_notes(columns.values())]


def metres_notes(columns: Iterable[Column]) -> list[str]:
    """What becomes of m/s², where fractions of g are needed; nothing where no column has them."""
    if not any(_in_metres(c.unit) for c in columns):
        return []
    return [
        f"m/s² are divided by standard gravity, {STANDARD_GRAVITY} m/s²; the local one differs "
        "by up to 0.3 %, and so does the scale factor"
    ]


def _in_metres(unit: str) -> bool:
    try:
        factor_of(unit, KINDS["sensor output"])
    except UnitError:
        return True
    return False
