"""CSV files of many dialects, plain or compressed: rows of cells made into numbers.

One reader for logs, recorded drives and the tables of a test bench.  What a column is called
and what it means is the business of those who ask; errors name the file and the line.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.files import likely_size, open_bytes, open_lines
from mcsim.logs.cells import WRITTEN, Notation, holds_nothing, notation_of, number
from mcsim.logs.column_file import ColumnFile, Numbers, shown
from mcsim.logs.date_times import EXAMPLE, nanoseconds
from mcsim.logs.layout import LayoutError, cells_of, find_layout, without_comments

if TYPE_CHECKING:
    import pandas as pd

#: Lines, and characters, that are looked at to find header and delimiter.
_LOOKED_AT, _LONGEST_HEAD = 300, 1 << 20
#: Rows that are read at a time, and the most of all: a day of 300 Hz.
_CHUNK, _MOST_ROWS = 1 << 17, 30_000_000
_TABLE = "table"
_ENCODINGS = {
    "cp1252": "Windows-1252 (Latin-1)",
    "utf-16-le": "UTF-16",
    "utf-16-be": "UTF-16",
    "utf-32-le": "UTF-32",
    "utf-32-be": "UTF-32",
}


class CsvFile(ColumnFile):
    """Where the cells of a file are.

    Empty lines and comments are passed over.
    """

    def numbers(self, places: Iterable[int], unknown: bool = False) -> dict[int, Numbers]:
        """Columns (n,) by place; whole numbers stay whole, since nanoseconds do not fit floats.

        Dates and times are whole numbers of nanoseconds.

        A last row that was cut off is left out.  With ``unknown``, cells that hold nothing are
        nan.

        Raises
        ------
        InputError
            The file cannot be read, holds no rows or too many, or a cell holds no finite number.
        """
        wanted = list(places)
        columns = self._read(wanted)
        last = len(columns[wanted[0]]) - 1
        whole = all(np.isfinite(column[last]) for column in columns.values())
        if last > 0 and not whole and self._is_cut():
            self.notes.append("the last line is cut off: left out")
            # Anew, since whole numbers beside a missing one have become floats.
            columns = self._read(wanted, last)
        for place, column in columns.items():
            self._refuse(place, np.isinf(column) if unknown else ~np.isfinite(column))
        return columns

    def texts(self, place: int) -> list[str]:
        """Cells of a column as they are written; empty ones as ''.

        Raises
        ------
        InputError
            The file cannot be read, or holds no rows.
        """
        chunks = self._chunks([place], kind=str)
        return [str(c).strip() for chunk in chunks for c in chunk[place].fillna("")]

    def line(self, row: int) -> int:
        """Line of the file (from 1) that holds a row (from 0)."""
        return next((n for i, (n, _) in enumerate(self._rows()) if i == row), 0)

    def check_widths(self) -> None:
        """Refuse rows with more cells than the header; for tables of moderate size.

        Raises
        ------
        InputError
            Names the first line at fault.
        """
        for number_, text in self._rows():
            if any(cells_of(text, self.layout.delimiter)[self.count :]):
                raise InputError(
                    f"{self.path}:{number_}: has more cells than the header, which has {self.count}"
                )

    def _rows(self) -> Iterator[tuple[int, str]]:
        """Line number and text of each row, as pandas counts them."""
        blanks = _blanks(self.layout.delimiter)
        with open_lines(self.path, what=_TABLE) as (text, _):
            for place, line in enumerate(text, start=1):
                row = without_comments(line.rstrip("\n"))
                if place > self.layout.skipped and row.strip(blanks):
                    yield place, row

    def _is_cut(self) -> bool:
        """Whether the last row lacks cells, its line end, or holds null bytes."""
        last = ""
        with open_lines(self.path, what=_TABLE) as (text, _):
            for line in text:
                last = line if line.strip() else last
        cells = cells_of(last, self.layout.delimiter)
        return len(cells) < self.count or not last.endswith("\n") or "\0" in last

    def _read(self, places: list[int], count: int | None = None) -> dict[int, Numbers]:
        """Columns by place: nan where a cell holds nothing, inf where it holds no number."""
        self._refuse_many()
        parts: dict[int, list[Numbers]] = {place: [] for place in places}
        rows = 0
        for chunk in self._chunks(places, count=count):
            rows += len(chunk)
            if rows > _MOST_ROWS:
                raise _too_many(self.path)
            for place, held in parts.items():
                held.append(
                    _stamps(chunk[place])
                    if place in self.layout.dates
                    else self._converted(chunk[place])
                )
        if not rows:
            raise InputError(f"{self.path}: holds a header and no rows of values")
        return {place: np.concatenate(held) for place, held in parts.items()}

    def _refuse_many(self) -> None:
        """Count rows before memory is asked for them, where there may be too many."""
        if likely_size(self.path) / self.layout.row_length <= _MOST_ROWS:
            return
        rows = 0
        with open_bytes(self.path, what=_TABLE) as file:
            while block := file.read(1 << 20):
                rows += block.count(b"\n")
                if rows > _MOST_ROWS:
                    raise _too_many(self.path)

    def _chunks(
        self, places: list[int], *, count: int | None = None, kind: type | None = None
    ) -> Iterator[pd.DataFrame]:
        import pandas as pd

        layout = self.layout
        # Quoted cells may hold the delimiter as their decimal sign.
        decimal = layout.notation.value if layout.notation.value != layout.delimiter else "."
        with open_lines(self.path, what=_TABLE) as (text, _):
            for _ in range(layout.skipped):
                text.readline()
            try:
                reader = pd.read_csv(
                    _Rows(text, layout.delimiter),
                    sep=layout.delimiter,
                    header=None,
                    names=list(range(layout.count)),
                    usecols=places,
                    dtype=kind,
                    skipinitialspace=True,
                    index_col=False,
                    na_values=["-", *WRITTEN],
                    decimal=decimal,
                    engine="c",
                    low_memory=False,
                    chunksize=_CHUNK,
                    nrows=count,
                )
            except pd.errors.EmptyDataError:
                raise InputError(f"{self.path}: holds a header and no rows of values") from None
            with reader:
                yield from reader

    def _converted(self, column: pd.Series[Any]) -> Numbers:
        import pandas as pd

        held = column.to_numpy()
        if held.dtype.kind in "if":
            return np.asarray(held)
        texts = column.astype("object").where(column.notna(), None)
        try:
            numbers = pd.to_numeric(texts, errors="coerce").to_numpy(float, copy=True)
        except OverflowError:  # whole numbers of hundreds of digits
            numbers = np.full(len(texts), np.nan)
        strange = np.isnan(numbers) & column.notna().to_numpy()
        if np.any(strange):
            cells = [str(cell) for cell in texts[strange]]
            seen = notation_of(cells)
            # 1,234 alone says neither; what other cells of the table show counts.
            sure = self.layout.certain or seen.certain or not seen.open
            found = [number(cell, self.layout.notation) for cell in cells]
            numbers[strange] = [np.inf if x is None or not sure else x for x in found]
        return numbers

    def _refuse(self, place: int, bad: NDArray[np.bool_]) -> None:
        if not np.any(bad):
            return
        row = int(np.argmax(bad))
        line, text = next((r for i, r in enumerate(self._rows()) if i == row), (0, ""))
        cells = cells_of(text, self.layout.delimiter)
        cell = cells[place] if place < len(cells) else ""
        held = f'"{shown(cell)}"'
        if holds_nothing(cell) and "inf" not in cell.lower():
            held = "nothing (or nan)"
        more = int(np.count_nonzero(bad)) - 1
        also = f", and so in {more} more rows" if more else ""
        needed = "a finite number"
        if place in self.layout.dates:
            needed = f"a date and time like the others ({EXAMPLE})"
        elif "," in cell:
            sign = "comma" if self.layout.notation is Notation.COMMA else "point"
            also += f"; the table's numbers are read with a decimal {sign}"
        raise InputError(
            f'{self.path}:{line}: column "{self.title(place)}" holds {held}, '
            f"where {needed} is needed{also}"
        )


def _stamps(column: pd.Series[Any]) -> Numbers:
    """Dates and times in ns; nan where a cell holds nothing, inf where it holds no time."""
    stamps, bad = nanoseconds(column.astype("object").where(column.notna(), None).tolist())
    if not np.any(bad):
        return stamps
    return np.where(column.isna(), np.nan, np.where(bad, np.inf, stamps.astype(float)))


class _Rows(io.TextIOBase):
    """Text in pieces of whole lines, without comments and rows of nothing: what pandas reads."""

    def __init__(self, text: IO[str], delimiter: str) -> None:
        self._text = text
        self._blanks = _blanks(delimiter)
        self._blank = re.compile(f"^[{self._blanks}]+$", re.MULTILINE)

    def readable(self) -> bool:
        return True

    def read(self, size: int | None = -1, /) -> str:
        piece = self._text.read(-1 if size is None else size)
        if piece and not piece.endswith("\n"):
            piece += self._text.readline(_LONGEST_HEAD)
        piece = without_comments(piece)
        if any(f"\n{blank}" in piece or piece.startswith(blank) for blank in self._blanks):
            piece = self._blank.sub("", piece)
        return piece


def _blanks(delimiter: str) -> str:
    """What a line without any value consists of; spreadsheets end in rows of delimiters."""
    return " \t" + (delimiter if len(delimiter) == 1 else "")


def open_csv(path: Path) -> CsvFile:
    """Find encoding, header, delimiter and first row of a file.

    Raises
    ------
    InputError
        The file cannot be read, is no text, or holds no rows.
    """
    with open_lines(path, what=_TABLE) as (text, encoding):
        content, more = "", True
        while more and content.count("\n") < _LOOKED_AT and len(content) < _LONGEST_HEAD:
            piece = text.read(1 << 16)
            content, more = content + piece, bool(piece)
    if "\0" in content.rstrip("\0\n"):
        raise InputError(f"{path}: cannot be read: it is no text (it holds null bytes)")
    lines = content.split("\n")
    if more:
        lines.pop()
    if not lines:
        raise InputError(
            f"{path}: no line ends in the first {_LONGEST_HEAD >> 20} MiB; not a table"
        )
    try:
        layout = find_layout(lines[:_LOOKED_AT])
    except LayoutError as error:
        raise InputError(f"{path}: {error}") from None
    notes = [] if encoding == "utf-8" else [f"the text is no UTF-8: read as {_ENCODINGS[encoding]}"]
    return CsvFile(path, layout, notes)


def _too_many(path: Path) -> InputError:
    return InputError(
        f"{path}: holds more than {_MOST_ROWS // 1_000_000} million rows; cut it into parts, or "
        "keep every second row (after a low-pass)"
    )
