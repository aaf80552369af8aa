"""gnss-ins-sim: a folder with a file for each sensor, of which the first run is read."""

from __future__ import annotations

from pathlib import Path

from mcsim.errors import InputError
from mcsim.logs.column_file import ColumnFile
from mcsim.logs.csv_file import open_csv
from mcsim.logs.formats.log_format import LogFormat
from mcsim.logs.held_columns import columns_of_table
from mcsim.logs.inside import first_inside
from mcsim.logs.model import Array, ReadOptions
from mcsim.logs.names import TIME
from mcsim.logs.table import Table, not_used, read_part, read_time

_SENSORS = ("accel-0.csv", "gyro-0.csv")


def recognises(path: Path) -> bool:
    """Whether it holds a sensor's first run."""
    return path.is_dir() and bool(_parts(path))


def table(folder: Path, options: ReadOptions) -> Table:
    """The channels of the folder's files, and its time.

    Raises
    ------
    InputError
        A file in it is at fault, or they differ in length.
    """
    parts = _parts(folder)
    if not parts:
        raise InputError(f"{folder}: holds neither {' nor '.join(_SENSORS)}")
    values: dict[str, Array] = {}
    notes: list[str] = []
    stated: dict[str, tuple[str, float]] = {}
    matched: list[set[str]] = []
    for part in parts:
        found, unmatched = read_part(open_csv(part), options.columns, options.units)
        matched.append(set(unmatched))
        values |= found.values
        notes += found.notes
        stated |= found.units
    if unmatched_by_all := sorted(set.intersection(*matched)):
        raise InputError(f"{folder}: {not_used(unmatched_by_all)}")
    time = first_inside(folder, ("time.csv",))
    if time is not None:
        values[TIME] = read_time(time)
    lengths = {len(column) for column in values.values()}
    if len(lengths) > 1:
        raise InputError(
            f"{folder}: its files differ in length "
            f"({', '.join(f'{name}: {len(column)}' for name, column in values.items())} rows)"
        )
    runs = len(list(folder.glob("accel-*.csv*")))
    if runs > 1:
        notes.append(f"the first of {runs} runs is used")
    return Table(values, tuple(notes), stated)


def columns(folder: Path, options: ReadOptions) -> ColumnFile:
    """The same as columns in SI units.

    Raises
    ------
    InputError
        As ``table``.
    """
    return columns_of_table(folder, table(folder, options))


def _parts(folder: Path) -> list[Path]:
    found = [first_inside(folder, (name,)) for name in _SENSORS]
    return [file for file in found if file is not None]


FORMAT = LogFormat(
    "gnss-ins-sim",
    "gnss-ins-sim folder",
    recognises,
    columns,
    table,
    folder=f"{' or '.join(_SENSORS)} (gnss-ins-sim)",
)
