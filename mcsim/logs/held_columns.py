"""Columns that a reader holds as arrays: of formats that are no tables of text."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mcsim.errors import InputError
from mcsim.logs.column_file import ColumnFile, Numbers, shown
from mcsim.logs.layout import Layout
from mcsim.logs.model import KIND
from mcsim.logs.names import CHANNELS, TIME
from mcsim.logs.table import Table
from mcsim.logs.titles import split_titles
from mcsim.units import KINDS


@dataclass(frozen=True)
class HeldColumns(ColumnFile):
    """Columns in memory, ``values`` (n,) by place; a row's line is its number from 1."""

    values: tuple[NDArray[Any], ...] = ()

    def numbers(self, places: Iterable[int], unknown: bool = False) -> dict[int, Numbers]:
        """Columns (n,) by place; nan where nothing is known, if ``unknown``.

        Raises
        ------
        InputError
            A column holds texts, or a number that is not finite.
        """
        return {place: self._number(place, unknown) for place in places}

    def texts(self, place: int) -> list[str]:
        """Cells of a column as text."""
        return [str(cell).strip() for cell in self.values[place]]

    def line(self, row: int) -> int:
        """Number of a row (from 0), from 1."""
        return row + 1

    def check_widths(self) -> None:
        """Nothing to refuse: arrays have as many rows as each other."""

    def _number(self, place: int, unknown: bool) -> Numbers:
        column = self.values[place]
        if not _is_number(column):
            raise InputError(
                f'{self.path}: column "{self.title(place)}" holds text, where numbers are needed'
            )
        bad = np.isinf(column) if unknown else ~np.isfinite(column)
        if np.any(bad):
            row = int(np.argmax(bad))
            more = int(np.count_nonzero(bad)) - 1
            also = f", and so in {more} more rows" if more else ""
            raise InputError(
                f'{self.path}:{self.line(row)}: column "{self.title(place)}" holds {column[row]}, '
                f"where a finite number is needed{also}"
            )
        return column


def log_columns(
    path: Path, columns: Mapping[str, ArrayLike], notes: Iterable[str] = ()
) -> ColumnFile:
    """The columns of a log from arrays: what a ``LogFormat`` of one's own returns.

    Parameters
    ----------
    path : Path
        The file, for messages.
    columns : mapping
        Arrays (n,) by title, with its unit in brackets: ``"time [s]"``, ``"ax [m/s²]"``.  Nan is
        a value that is not known; whole numbers stay whole.
    notes : iterable of str
        What was done to read it.

    Returns
    -------
    ColumnFile

    Raises
    ------
    InputError
        No column, no row, or columns of different lengths.
    """
    held = tuple(np.asarray(values) for values in columns.values())
    _check_shapes(path, dict(zip(columns, held, strict=True)))
    layout = Layout(
        skipped=0,
        delimiter="",
        count=len(held),
        titles=split_titles(columns),
        header=1,
        empty=_places(held, lambda c: _is_number(c) and bool(np.all(np.isnan(c)))),
        texts=_places(held, lambda c: not _is_number(c)),
    )
    return HeldColumns(path, layout, list(notes), held)


def columns_of_table(path: Path, table: Table) -> ColumnFile:
    """The columns of a table, titled with their names and SI units."""
    return log_columns(path, {_title(n): v for n, v in table.values.items()}, table.notes)


def _title(name: str) -> str:
    kind = "time" if name == TIME else KIND[CHANNELS[name][0]]
    return f"{name} [{KINDS[kind].si_unit}]"


def _check_shapes(path: Path, columns: Mapping[str, NDArray[Any]]) -> None:
    for title, values in columns.items():
        if values.ndim != 1:
            raise InputError(
                f'{path}: column "{shown(title)}" has {values.ndim} dimensions, where one is needed'
            )
    lengths = {title: len(values) for title, values in columns.items()}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{shown(title)}: {length}" for title, length in lengths.items())
        raise InputError(f"{path}: its columns differ in length ({told} rows)")
    if not any(lengths.values()):
        raise InputError(f"{path}: holds no rows of values")


def _is_number(column: NDArray[Any]) -> bool:
    return column.dtype.kind in "iuf"


def _places(
    columns: tuple[NDArray[Any], ...], holds: Callable[[NDArray[Any]], bool]
) -> frozenset[int]:
    return frozenset(place for place, column in enumerate(columns) if holds(column))
