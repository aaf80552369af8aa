"""Tables of a log: the columns of a file that hold time, accelerations or rates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mcsim.errors import InputError, UnitError
from mcsim.logs.column_file import ColumnFile, scaled, since_first
from mcsim.logs.columns import assign, said, unmatched_units
from mcsim.logs.csv_file import open_csv
from mcsim.logs.model import Array
from mcsim.logs.names import CHANNELS, TIME
from mcsim.logs.titles import factor_of, shown_unit
from mcsim.units import KINDS


@dataclass(frozen=True)
class Table:
    """Columns of a file in SI units, by name (``time``, ``accel_x`` …); all (n,).

    ``units`` holds, by element, the unit that was stated and its SI value.
    """

    values: dict[str, Array]
    notes: tuple[str, ...] = ()
    units: Mapping[str, tuple[str, float]] = field(default_factory=dict)


def table_of(file: ColumnFile, columns: str | None, units: str | None) -> Table:
    """The columns of a file that hold time, accelerations or rates.

    Raises
    ------
    InputError
        Nothing is recognised, a cell is no finite number, or a stated unit is of no column.
    """
    table, unmatched = read_part(file, columns, units)
    if unmatched:
        raise InputError(f"{file.path}: {not_used(unmatched)} ({table.notes[0]})")
    return table


def not_used(unmatched: Sequence[str]) -> str:
    """What to say of units that were stated and are of no column."""
    return f"--units {','.join(unmatched)}: no column is one; leave it out, or name it by --columns"


def read_part(file: ColumnFile, columns: str | None, units: str | None) -> tuple[Table, list[str]]:
    """As ``table_of``, of a file that may lack columns; with the units that are of none.

    Raises
    ------
    InputError
        As for ``table_of``.
    """
    wanted = assign(file, columns, units)
    numbers = file.numbers([column.place for column in wanted])
    values = {}
    for column in wanted:
        cells = numbers[column.place]
        plain = since_first(cells) if column.name == TIME else cells.astype(float)
        values[column.name] = scaled(plain, column.factor, file.path, column.title)
    stated = {CHANNELS[c.name][0]: (shown_unit(c.unit), c.factor) for c in wanted if c.name != TIME}
    table = Table(values, (said(file, wanted), *file.notes), stated)
    return table, unmatched_units(units, wanted)


def read_time(path: Path) -> Array:
    """Time stamps (n,) in s since the first, of a file that holds nothing else.

    Raises
    ------
    InputError
        As for ``table_of``.
    """
    file = open_csv(path)
    if file.count != 1:
        raise InputError(f"{path}: has {file.count} columns, where time alone is expected")
    unit = (file.titles[0].unit if file.titles else "") or "s"
    stamps = since_first(file.numbers([0])[0])
    try:
        return scaled(stamps, factor_of(unit, KINDS["time"]), path, file.title(0))
    except UnitError as error:
        raise InputError(f"{path}: {error}") from None
