"""CSV files of many dialects, plain or compressed: header, delimiter, cells.

One reader for logs and for the tables of a test bench.  What a column is called and what it
means is the business of those who ask; errors name the file and the line.
"""

from __future__ import annotations

import bz2
import gzip
import lzma
import re
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

Numbers = NDArray[np.float64] | NDArray[np.int64]

_OPENERS: dict[str, Callable[..., Any]] = {".gz": gzip.open, ".xz": lzma.open, ".bz2": bz2.open}
#: Lines that are looked at to find header and delimiter.
_LOOKED_AT = 50
_DELIMITERS = (",", ";", "\t", r"\s+")
_COMMENT = "#"
#: Characters of a cell that a message shows.
_SHOWN = 40
_WITH_UNIT = re.compile(r"(?P<name>[^\[(]*)[\[(](?P<unit>[^\])]*(?:\([^)]*\))?[^\])]*)[\])]\s*")
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d+,\d+\s*")


@dataclass(frozen=True)
class Title:
    """A column's title as written, and its two parts: ``az [m/s²]``; ``unit`` may be empty."""

    text: str
    name: str
    unit: str


@dataclass(frozen=True)
class CsvFile:
    """Where the cells of a file are.

    ``skipped`` lines stand before the first row of cells; ``titles`` are None without a header,
    which else is in line ``header`` (from 1).  Empty lines and what follows a # are passed over.
    """

    path: Path
    skipped: int
    delimiter: str
    count: int
    titles: tuple[Title, ...] | None
    header: int

    def title(self, place: int) -> str:
        """What a column is called in messages."""
        return self.titles[place].text if self.titles else f"column {place + 1}"

    def numbers(self, places: Iterable[int]) -> dict[int, Numbers]:
        """Columns (n,) by place; whole numbers stay whole, since nanoseconds do not fit floats.

        Raises
        ------
        InputError
            The file cannot be read, holds no rows, or a cell holds no finite number.
        """
        table = self._read(list(places))
        return {place: self._finite(place, column) for place, column in table.items()}

    def texts(self, place: int) -> list[str]:
        """Cells of a column as they are written; empty ones as ''.

        Raises
        ------
        InputError
            The file cannot be read, or holds no rows.
        """
        return [str(cell).strip() for cell in self._read([place], str)[place].fillna("")]

    def line(self, row: int) -> int:
        """Line of the file (from 1) that holds a row (from 0)."""
        seen = -1
        with _readable(self.path), _open(self.path) as file:
            for number, line in enumerate(file, start=1):
                text = line.strip()
                seen += number > self.skipped and bool(text) and not text.startswith(_COMMENT)
                if seen == row:
                    return number
        raise IndexError(row)

    def check_widths(self) -> None:
        """Refuse rows with more cells than the header; for tables of moderate size.

        Raises
        ------
        InputError
            Names the first line at fault.
        """
        with _readable(self.path), _open(self.path) as file:
            for number, line in enumerate(file, start=1):
                text = line.partition(_COMMENT)[0].strip()
                if number > self.skipped and any(_cells(text, self.delimiter)[self.count :]):
                    raise InputError(
                        f"{self.path}:{number}: has more cells than the header, which has "
                        f"{self.count}"
                    )

    def _read(self, places: list[int], kind: type | None = None) -> dict[int, pd.Series[Any]]:
        import pandas as pd

        try:
            with _readable(self.path):
                table = pd.read_csv(
                    self.path,
                    sep=self.delimiter,
                    header=None,
                    skiprows=self.skipped,
                    names=list(range(self.count)),
                    usecols=places,
                    dtype=kind,
                    skipinitialspace=True,
                    index_col=False,
                    comment=_COMMENT,
                    encoding="utf-8-sig",
                    na_values=["-"],
                    engine="c",
                    low_memory=False,
                )
        except ValueError as error:
            first = str(error).strip().split("\n")[0]
            raise InputError(f"{self.path}: not a table of numbers ({first})") from None
        if not len(table):
            raise InputError(f"{self.path}: holds a header and no rows of values")
        return {place: table[place] for place in places}

    def _finite(self, place: int, column: pd.Series[Any]) -> Numbers:
        import pandas as pd

        numbers = column.to_numpy()
        if numbers.dtype.kind not in "iuf":
            # A real minus sign, as word processors write it.
            plain = column.astype(str).str.replace("\N{MINUS SIGN}", "-")
            numbers = pd.to_numeric(plain, errors="coerce").to_numpy(float)
        bad = ~np.isfinite(numbers)
        if not np.any(bad):
            return np.asarray(numbers)
        row = int(np.argmax(bad))
        cell = column.iloc[row]
        held = "nothing (or nan)" if pd.isna(cell) else f'"{str(cell).strip()[:_SHOWN]}"'
        more = int(np.count_nonzero(bad)) - 1
        also = f", and so in {more} more rows" if more else ""
        if _DECIMAL_COMMA.fullmatch(str(cell)):
            also += "; write a decimal point, not a comma"
        raise InputError(
            f'{self.path}:{self.line(row)}: column "{self.title(place)}" holds {held}, '
            f"where a finite number is needed{also}"
        )


def open_csv(path: Path) -> CsvFile:
    """Find header, delimiter and first row of a file.

    The header is the last line before the numbers that has as many cells; where no row is made
    of numbers alone, the first line that is no comment.

    Raises
    ------
    InputError
        The file cannot be read, is no text, or holds no rows.
    """
    lines = _first_lines(path)
    rows = [i for i, line in enumerate(lines) if line.strip()]
    if not rows:
        raise InputError(f"{path}: is empty")
    for i in rows:
        for delimiter in _DELIMITERS:
            cells = _cells(lines[i], delimiter)
            if len(cells) > 1 and all(_is_number(cell) for cell in cells):
                return _under_header(path, lines, i, delimiter, len(cells))
    # A single column, or rows that hold text.
    first = next((i for i in rows if not lines[i].lstrip().startswith(_COMMENT)), rows[-1])
    if _is_number(lines[first]):
        return CsvFile(path, first, ",", 1, None, 0)
    delimiter = next((d for d in _DELIMITERS[:3] if d in lines[first]), ",")
    titles = _cells(lines[first].lstrip(_COMMENT), delimiter)
    if first == rows[-1]:
        raise InputError(f"{path}: holds a header and no rows of values")
    return CsvFile(path, first + 1, delimiter, len(titles), _split(titles), first + 1)


def split_title(text: str) -> Title:
    """Name and unit of a title such as ``az [m/s²]`` or ``gyro_x (deg/s)``."""
    match = _WITH_UNIT.fullmatch(text)
    if match is None:
        return Title(text, text.strip(), "")
    return Title(text, match["name"].strip(), match["unit"].strip())


def _split(titles: Iterable[str]) -> tuple[Title, ...]:
    return tuple(map(split_title, titles))


def _under_header(path: Path, lines: list[str], first: int, delimiter: str, count: int) -> CsvFile:
    """The file whose line ``first`` (from 0) is made of numbers."""
    for i in range(first - 1, -1, -1):
        titles = _title_cells(lines[i], delimiter, count)
        # A row of cells with a text among them is none, and its line is to be named.
        if titles is not None and not any(map(_is_number, titles)):
            rows = range(i + 1, first)
            held = (j for j in rows if any(map(_is_number, _cells(lines[j], delimiter))))
            return CsvFile(path, next(held, first), delimiter, count, _split(titles), i + 1)
    return CsvFile(path, first, delimiter, count, None, 0)


def _title_cells(line: str, delimiter: str, count: int) -> list[str] | None:
    text = line.strip().lstrip(_COMMENT).strip()
    parted = delimiter if delimiter != r"\s+" else r"\s{2,}|\t|(?<=[\])])\s+"
    cells = [cell.strip() for cell in re.split(parted, text)]
    if len(cells) == count + 1 and not cells[-1]:
        cells.pop()
    if len(cells) != count and delimiter == r"\s+":
        cells = text.split()
    return cells if len(cells) == count else None


def _cells(line: str, delimiter: str) -> list[str]:
    text = line.strip()
    if delimiter != r"\s+" and text.endswith(delimiter):
        text = text[: -len(delimiter)]
    return [cell.strip().strip('"') for cell in re.split(delimiter, text)]


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace("\N{MINUS SIGN}", "-"))
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
    file: IO[str] = opener(path, "rt", encoding="utf-8-sig")
    return file


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
