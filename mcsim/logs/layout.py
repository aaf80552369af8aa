"""Where a table stands in a text file: delimiter, decimal sign, header, units, first row.

Looked for in the first lines: the delimiter is the one that leaves most cells numbers, the header
the last line before them that has as many cells and no number.  Preambles, comments, a second
row of units, columns without any value and columns of text are all part of what loggers write.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcsim.logs.cells import Notation, holds_nothing, notation_of, number
from mcsim.logs.date_times import are_dates
from mcsim.logs.titles import Title, is_unit, split_titles

#: In the order of preference; blanks come last, since other tables hold them too.
DELIMITERS = (",", ";", "\t", "|", r"\s+")
#: A line that begins so is a comment; # also ends a row.
COMMENTS = ("#", "//", "%")
#: What Arduino's serial monitor writes before each line.
_MONITOR = r"^\d\d:\d\d:\d\d\.\d{3} -> "
_COMMENT = re.compile(rf'[ \t]*#[^\n"]*$|^[ \t]*(?://|%)[^\n]*|{_MONITOR}', re.MULTILINE)
#: A row of the table has at least this part of the columns' numbers.
_MOSTLY = 0.5
#: The title at the end of LabVIEW's headers, under which rows mostly have no cell.
_REMARK = "Comment"


@dataclass(frozen=True)
class Layout:
    """``skipped`` lines stand before the first row; ``header`` is its line (from 1), or 0.

    ``titles`` are None without a header.  ``notation`` is that of the cells looked at, and
    ``certain`` if one of them shows it; ``empty`` and ``texts`` are the places of columns that
    hold no value, or no number, in the lines looked at.
    """

    skipped: int
    delimiter: str
    count: int
    titles: tuple[Title, ...] | None
    header: int
    notation: Notation = Notation.POINT
    certain: bool = False
    empty: frozenset[int] = frozenset()
    texts: frozenset[int] = frozenset()
    dates: frozenset[int] = frozenset()
    """Those of the texts that are dates and times."""
    doubt: str = ""
    """Why a line that looks like a header is none."""
    row_length: float = 1.0
    """Characters of a row, its line end included, on average of the lines looked at."""


@dataclass(frozen=True)
class _Split:
    """Lines split by one delimiter; ``count`` cells are usual, ``score`` says how well it fits."""

    delimiter: str
    rows: list[list[str]]
    count: int
    notation: Notation
    certain: bool
    ambiguous: str
    score: tuple[bool, int]


class LayoutError(ValueError):
    """The first lines hold no table; the text says why."""


def without_comments(text: str) -> str:
    """Text without its comments, and a serial monitor's; the lines stay where they are."""
    if any(sign in text for sign in (*COMMENTS, " -> ")):
        return _COMMENT.sub("", text)
    return text


def cells_of(line: str, delimiter: str) -> list[str]:
    """Cells of a line, without the quotes around them."""
    text = line.strip("\n\r ") if delimiter == "\t" else line.strip()
    if delimiter == r"\s+":
        return [a or b for a, b in re.findall(r'"([^"]*)"|(\S+)', text)]
    try:
        row = next(csv.reader([text], delimiter=delimiter, skipinitialspace=True), [])
    except csv.Error:
        row = text.split(delimiter)
    return [cell.strip().strip('"') for cell in row]


def find_layout(lines: Sequence[str]) -> Layout:
    """The table in the first lines of a file.

    Raises
    ------
    LayoutError
        No line holds more than comments, or a number's notation cannot be told.
    """
    bare = without_comments("\n".join(lines)).split("\n")
    held = [i for i, line in enumerate(bare) if line.strip()]
    if not held:
        raise LayoutError("is empty" if not any(map(str.strip, lines)) else "holds no rows")
    splits = [split for d in DELIMITERS if (split := _split(bare, held, d)) is not None]
    if not splits:
        return _of_text(bare, held)
    best = max(splits, key=lambda split: split.score)
    if best.ambiguous:
        raise LayoutError(
            f'"{best.ambiguous}" could be a decimal comma or a group of thousands; write numbers '
            "with a decimal point and without groups"
        )
    return _placed(lines, best, held)


def _split(bare: list[str], held: list[int], delimiter: str) -> _Split | None:
    rows = [cells_of(line, delimiter) if line.strip() else [] for line in bare]
    seen = notation_of(cell for row in rows for cell in row)
    numbers = [sum(number(cell, seen.notation) is not None for cell in row) for row in rows]
    counts = Counter(len(rows[i]) for i in held if numbers[i])
    if not counts:
        return None
    count = max(counts, key=lambda n: (counts[n], n))
    usual = [i for i in held if numbers[i] and len(rows[i]) == count]
    value = sum(numbers[i] for i in usual)
    other = sum(
        not holds_nothing(cell) and number(cell, seen.notation) is None
        for i in usual
        for cell in rows[i]
    )
    either = next((c for i in usual for c in rows[i] if "," in c), "") if seen.open else ""
    score = (count > 1, value - other)
    return _Split(delimiter, rows, count, seen.notation, seen.certain, either, score)


def _placed(lines: Sequence[str], split: _Split, held: list[int]) -> Layout:
    """Header, units and first row around the rows that are numbers."""
    rows, count, notation = split.rows, split.count, split.notation
    usual = [i for i in held if len(rows[i]) == count and _holds_number(rows[i], notation)]
    numeric, empty = _columns([rows[i] for i in usual], count, notation)
    whole = [i for i in usual if _is_row(rows[i], numeric, notation, len(numeric))]
    some = (i for i in usual if _is_row(rows[i], numeric, notation, _MOSTLY * len(numeric)))
    first = whole[0] if whole else next(some)
    texts = frozenset(range(count)) - numeric - empty
    dates = frozenset(place for place in texts if are_dates([rows[i][place] for i in usual]))
    header = _headers(lines, split, first, count - 1 in empty)
    # A delimiter at the end of each row makes no column.
    if count - 1 in empty and (header is None or not header.titles[-1].text):
        count, empty = count - 1, empty - {count - 1}
    titles = None if header is None else header.titles[:count]
    start = first if header is None else next(i for i in held if i > header.last)
    line = 0 if header is None else header.line + 1
    return Layout(
        start,
        split.delimiter,
        count,
        titles,
        line,
        notation,
        split.certain,
        empty,
        texts,
        dates,
        _doubt(lines, split, first) if header is None else "",
        float(np.mean([len(lines[i]) + 1 for i in usual])),
    )


@dataclass(frozen=True)
class _Header:
    """Line (from 0) of the titles, and the last line that belongs to them."""

    line: int
    titles: tuple[Title, ...]
    last: int


def _headers(lines: Sequence[str], split: _Split, first: int, ends_empty: bool) -> _Header | None:
    """The header above line ``first``, with what stands above it or a row of units below."""
    found: list[tuple[int, list[str]]] = []
    for i in range(first - 1, -1, -1):
        cells = _title_cells(lines[i], split.delimiter, split.count, ends_empty)
        if cells is None or not any(cells) or _holds_number(cells, split.notation):
            continue
        found.append((i, cells))
        if len(found) == 2:
            break
    if not found:
        return None
    last, cells = found[0]
    if len(found) == 2:
        line, above = found[1]
        if _are_units(cells):
            return _Header(line, split_titles(above, cells), last)
        twice = len(set(filter(None, cells))) < sum(map(bool, cells))
        if twice or ("" in above and {c.lower() for c in cells} & {"x", "y", "z"}):
            return _Header(last, split_titles(_under_groups(above, cells)), last)
    return _Header(last, split_titles(cells), last)


def _doubt(lines: Sequence[str], split: _Split, first: int) -> str:
    """What to say of a line above the rows that has fewer or more titles than they have cells."""
    if first == 0:
        return ""
    titles = cells_of(lines[first - 1].lstrip("".join(COMMENTS)), split.delimiter)
    if len(titles) < 2 or _holds_number(titles, split.notation):
        return ""
    said = f"line {first} has {len(titles)} titles, the rows have {split.count} cells"
    if split.delimiter == "," and split.count >= 2 * len(titles) - 1:
        said += (
            "; decimal commas between commas cannot be told apart: export with decimal points, or "
            "with ; between the cells"
        )
    return said


def _are_units(cells: list[str]) -> bool:
    held = [cell.strip("[]() ") for cell in cells if cell.strip("[]()- ")]
    known = sum(is_unit(cell) or cell in ("°C", "C", "V", "%", "uT", "µT", "hPa") for cell in held)
    return known > 0 and 2 * known > len(held)


def _under_groups(groups: list[str], cells: list[str]) -> list[str]:
    """Titles under a row that names their groups: Accelerometer,,,Gyroscope,,, over X,Y,Z,X,Y,Z."""
    named, group = [], ""
    for above, cell in zip(groups, cells, strict=True):
        group = above or group
        named.append(f"{group} {cell}".strip())
    return named


def _columns(
    rows: list[list[str]], count: int, notation: Notation
) -> tuple[frozenset[int], frozenset[int]]:
    """Places of columns that are mostly numbers, and of those that are empty."""
    numeric, empty = set(), set()
    for place in range(count):
        cells = [row[place] for row in rows]
        held = [cell for cell in cells if not holds_nothing(cell)]
        if not any(cell.strip() for cell in cells):
            empty.add(place)
        elif sum(number(cell, notation) is not None for cell in held) >= _MOSTLY * len(held):
            numeric.add(place)
    return frozenset(numeric), frozenset(empty)


def _is_row(cells: list[str], numeric: frozenset[int], notation: Notation, least: float) -> bool:
    """Whether at least so many columns of numbers hold one, or nothing."""
    fitting = sum(
        number(cells[place], notation) is not None or holds_nothing(cells[place])
        for place in numeric
    )
    return fitting >= least


def _holds_number(cells: list[str], notation: Notation) -> bool:
    return any(number(cell, notation) is not None for cell in cells)


def _title_cells(line: str, delimiter: str, count: int, ends_empty: bool) -> list[str] | None:
    for text in (line, without_comments(line)):
        text = re.sub(_MONITOR, "", text).strip("\n\r ").lstrip("".join(COMMENTS)).strip(" ")
        cells = cells_of(text, delimiter)
        if delimiter == r"\s+":
            wide = re.split(r"\s{2,}|\t|(?<=[\])])\s+", text.strip())
            cells = wide if len(wide) == count or wide[count:] == [_REMARK] else cells
        if len(cells) == count + 1 and cells[-1] in ("", _REMARK):
            cells.pop()
        if len(cells) == count - 1 and ends_empty:
            cells.append("")
        if len(cells) == count:
            return cells
    return None


def _of_text(bare: list[str], held: list[int]) -> Layout:
    """A table in which no cell is a number: its first line is the header."""
    first = held[0]
    if first == held[-1]:
        raise LayoutError("holds a header and no rows of values")
    delimiter = next((d for d in DELIMITERS[:4] if d in bare[first]), ",")
    titles = split_titles(cells_of(bare[first], delimiter))
    return Layout(first + 1, delimiter, len(titles), titles, first + 1)
