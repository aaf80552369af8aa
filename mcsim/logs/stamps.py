"""The time stamps of a log alone, as they are written: what its samples were integrated by."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError, UnitError
from mcsim.logs.clock import mend_clock
from mcsim.logs.column_file import ColumnFile, scaled, shown, since_first
from mcsim.logs.columns import time_column, written_column
from mcsim.logs.formats import open_log
from mcsim.logs.model import Array
from mcsim.logs.timing import judge, unusable
from mcsim.logs.titles import factor_of
from mcsim.units import KINDS

#: Fewer rows tell no interval.
_FEWEST = 3


def read_stamps(path: Path, column: str | None, key: str) -> Array:
    """Time stamps (n,) in s from the first row, in the order of the rows.

    ``column`` is written as ``NAME in UNIT``, or the name alone where the header has the unit; the
    column whose name says time if it is None.  ``key`` is what messages call it.

    Raises
    ------
    InputError
        No such file or column, no unit, cells that are no numbers, too few rows, or a time that
        runs backwards: names the line.
    """
    file = open_log(path)
    place, factor = _column(file, column, key)
    if place in file.layout.texts:
        raise InputError(f'{path}: "{file.title(place)}" holds no numbers: it is no time')
    cells = file.numbers([place])[place]
    if len(cells) < _FEWEST:
        raise InputError(f"{path}: {len(cells)} rows; at least {_FEWEST} are needed")
    stamps = np.asarray(scaled(since_first(cells), factor, path, file.title(place)), float)
    back = np.flatnonzero(np.diff(stamps) < 0.0)
    if len(back):
        row = int(back[0]) + 1
        raise InputError(
            f"{path}:{file.line(row)}: the time runs backwards here, by "
            f"{stamps[row - 1] - stamps[row]:.4g} s: no interval is negative; sort the rows, or "
            "cut the file"
        )
    return stamps


def even_instants(stamps: Array, where: str) -> tuple[Array, NDArray[np.int64]]:
    """When a sensor that samples evenly took the samples with these stamps (n,).

    Returns
    -------
    (ndarray, ndarray)
        Instants (m,) in s from the first, by count (see ``counting``) and the line through the
        stamps, and the rows (m,) that they belong to: rows that repeat another are left out.

    Raises
    ------
    InputError
        The stamps know no rate.
    """
    clock = mend_clock(stamps)
    if reason := unusable(clock):
        raise InputError(f"{where}: {reason}: no even instants follow from it")
    index = judge(clock).index.astype(float)
    interval = np.polynomial.Polynomial.fit(index, stamps[clock.rows], 1).convert().coef[1]
    return interval * (index - index[0]), clock.rows


def _column(file: ColumnFile, column: str | None, key: str) -> tuple[int, float]:
    """Place of the stamps, and the SI value of their unit."""
    name, _, unit = (part.strip() for part in (column or "").partition(" in "))
    place = file.place_of(name) if column is not None else time_column(file)
    if place is None:
        held = ", ".join(written_column(file, i) for i in range(file.count))
        what = f'no column "{shown(name)}"' if column is not None else "no column of time"
        raise InputError(f"{file.path}: {what} (columns: {held}); correct `{key}`")
    unit = unit or file.unit(place)
    if not unit:
        title = written_column(file, place)
        raise InputError(f'{key}: "{title}" has no unit; write for example "{title} in s"')
    try:
        return place, factor_of(unit, KINDS["time"])
    except UnitError as error:
        raise InputError(f"{key}: {error}") from None
