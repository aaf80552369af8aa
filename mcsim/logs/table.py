"""Tables of a log: the columns of a CSV file that hold time, accelerations or rates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mcsim.errors import InputError, UnitError
from mcsim.logs.columns import CHANNELS, TIME, assign
from mcsim.logs.csv_file import open_csv
from mcsim.logs.model import Array
from mcsim.units import KINDS, canonical_unit, factor


@dataclass(frozen=True)
class Table:
    """Columns of a file in SI units, by name (``time``, ``accel_x`` …); all (n,).

    ``units`` holds, by element, the unit that was stated and its SI value.
    """

    values: dict[str, Array]
    notes: tuple[str, ...] = ()
    units: Mapping[str, tuple[str, float]] = field(default_factory=dict)


def read_table(path: Path, columns: str | None, units: str | None) -> Table:
    """Read the columns of a CSV file that hold time, accelerations or rates.

    Raises
    ------
    InputError
        The file cannot be read, is empty, or a cell is no finite number.
    """
    file = open_csv(path)
    wanted = assign(file.titles, file.count, columns, units, str(path))
    numbers = file.numbers([column.place for column in wanted])
    notes = []
    ignored = file.count - len(wanted)
    if ignored:
        notes.append(f"{ignored} of {file.count} columns are not used")
    values = {}
    for column in wanted:
        cells = numbers[column.place]
        if column.name == TIME:
            # Whole nanoseconds do not fit into floats: the first one goes before.
            cells = cells - cells[0]
        values[column.name] = cells.astype(float) * column.factor
    stated = {
        CHANNELS[c.name][0]: (canonical_unit(c.unit), c.factor) for c in wanted if c.name != TIME
    }
    return Table(values, tuple(notes), stated)


def read_time(path: Path) -> Array:
    """Time stamps (n,) in s since the first, of a file that holds nothing else.

    Raises
    ------
    InputError
        As for ``read_table``.
    """
    file = open_csv(path)
    if file.count != 1:
        raise InputError(f"{path}: has {file.count} columns, where time alone is expected")
    unit = (file.titles[0].unit if file.titles else "") or "s"
    stamps = file.numbers([0])[0]
    try:
        return (stamps - stamps[0]).astype(float) * factor(unit, KINDS["time"])
    except UnitError as error:
        raise InputError(f"{path}: {error}") from None
