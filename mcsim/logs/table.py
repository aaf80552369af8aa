"""Tables as text: CSV of many dialects, plain or compressed."""

from __future__ import annotations

import bz2
import gzip
import lzma
import re
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from mcsim.errors import InputError
from mcsim.logs.columns import CHANNELS, TIME, Column, assign
from mcsim.logs.model import Array
from mcsim.units import canonical_unit

if TYPE_CHECKING:
    import pandas as pd

_OPENERS: dict[str, Callable[..., Any]] = {".gz": gzip.open, ".xz": lzma.open, ".bz2": bz2.open}
#: Lines that are looked at to find header and delimiter.
_LOOKED_AT = 50
_DELIMITERS = (",", ";", "\t", r"\s+")


@dataclass(frozen=True)
class Table:
    """Columns of a file in SI units, by name (``time``, ``accel_x`` …); all (n,).

    ``units`` holds, by element, the unit that was stated and its SI value.
    """

    values: dict[str, Array]
    notes: tuple[str, ...] = ()
    units: Mapping[str, tuple[str, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class _Layout:
    """Lines before the first row of numbers, delimiter, titles if there are any."""

    skipped: int
    delimiter: str
    titles: list[str] | None
    count: int


def read_table(path: Path, columns: str | None, units: str | None) -> Table:
    """Read the columns of a CSV file that hold time, accelerations or rates.

    Raises
    ------
    InputError
        The file cannot be read, is empty, or a cell is no finite number.
    """
    layout = _layout(path)
    wanted = assign(layout.titles, layout.count, columns, units, str(path))
    table = _numbers(path, layout, wanted)
    notes = []
    ignored = layout.count - len(wanted)
    if ignored:
        notes.append(f"{ignored} of {layout.count} columns are not used")
    values = {}
    for column in wanted:
        raw = table[column.place]
        _refuse_text(path, layout, column, raw)
        numbers = raw.to_numpy()
        if column.name == TIME:
            # Whole nanoseconds do not fit into floats: the first one goes before.
            numbers = numbers - numbers[0]
        values[column.name] = numbers.astype(float) * column.factor
    stated = {
        CHANNELS[c.name][0]: (canonical_unit(c.unit), c.factor) for c in wanted if c.name != TIME
    }
    return Table(values, tuple(notes), stated)


def _layout(path: Path) -> _Layout:
    lines = _first_lines(path)
    rows = [i for i, line in enumerate(lines) if line.strip()]
    if not rows:
        raise InputError(f"{path}: is empty")
    for i in rows:
        for delimiter in _DELIMITERS:
            cells = _cells(lines[i], delimiter)
            if len(cells) > 1 and all(_is_number(cell) for cell in cells):
                return _Layout(i, delimiter, _titles(lines, i, delimiter, len(cells)), len(cells))
    # A single column, or rows that hold text.
    first = rows[0]
    if _is_number(lines[first]):
        return _Layout(first, ",", None, 1)
    delimiter = next((d for d in _DELIMITERS[:3] if d in lines[first]), ",")
    titles = _cells(lines[first].lstrip("#"), delimiter)
    if len(rows) == 1:
        raise InputError(f"{path}: holds a header and no samples")
    return _Layout(first + 1, delimiter, titles, len(titles))


def _titles(lines: list[str], first: int, delimiter: str, count: int) -> list[str] | None:
    """The last line before the numbers that has as many cells."""
    for line in reversed(lines[:first]):
        parted = delimiter if delimiter != r"\s+" else r"\s{2,}|\t|(?<=[\])])\s+"
        cells = [cell.strip() for cell in re.split(parted, line.strip().lstrip("#").strip())]
        if len(cells) == count:
            return cells
        plain = line.strip().lstrip("#").split()
        if delimiter == r"\s+" and len(plain) == count:
            return plain
    return None


def _cells(line: str, delimiter: str) -> list[str]:
    text = line.strip()
    if delimiter != r"\s+" and text.endswith(delimiter):
        text = text[: -len(delimiter)]
    return [cell.strip() for cell in re.split(delimiter, text)]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _first_lines(path: Path) -> list[str]:
    with _readable(path), _open(path) as file:
        lines = []
        for line in file:
            lines.append(line.rstrip("\r\n"))
            if len(lines) == _LOOKED_AT:
                break
        return lines


def _open(path: Path) -> IO[str]:
    opener = _OPENERS.get(path.suffix.lower(), open)
    return opener(path, "rt", encoding="utf-8-sig")


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Turns what opening and unpacking raise into one message about the file."""
    try:
        yield
    except UnicodeDecodeError:
        raise InputError(f"{path}: not UTF-8 text") from None
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, EOFError, lzma.LZMAError, zlib.error) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{path}: cannot be read ({reason})") from None


def _numbers(path: Path, layout: _Layout, wanted: list[Column]) -> pd.DataFrame:
    import pandas as pd

    try:
        with _readable(path):
            return pd.read_csv(
                path,
                sep=layout.delimiter,
                header=None,
                skiprows=layout.skipped,
                names=list(range(layout.count)),
                usecols=[column.place for column in wanted],
                skipinitialspace=True,
                index_col=False,
                encoding="utf-8-sig",
                na_values=["#N/A", "-"],
                engine="c",
                low_memory=False,
            )
    except ValueError as error:
        first = str(error).strip().split("\n")[0]
        raise InputError(f"{path}: not a table of numbers ({first})") from None


def _refuse_text(path: Path, layout: _Layout, column: Column, raw: pd.Series[Any]) -> None:
    import pandas as pd

    if not len(raw):
        raise InputError(f"{path}: holds no samples")
    numbers = raw if raw.dtype.kind in "iuf" else pd.to_numeric(raw, errors="coerce")
    bad = ~np.isfinite(numbers.to_numpy(float))
    if not np.any(bad):
        if raw.dtype.kind not in "iuf":
            raise InputError(f'{path}: column "{column.title}" does not hold plain numbers')
        return
    row = int(np.argmax(bad))
    cell = raw.iloc[row]
    held = "nothing (or nan)" if pd.isna(cell) else f'"{cell}"'
    more = int(np.count_nonzero(bad)) - 1
    also = f", and so in {more} more rows" if more else ""
    raise InputError(
        f'{path}:{layout.skipped + row + 1}: column "{column.title}" holds {held}, '
        f"where a finite number is needed{also}"
    )
