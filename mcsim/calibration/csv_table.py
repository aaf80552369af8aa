"""Small CSV tables with named columns, read with messages that name file and line."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from pathlib import Path

from mcsim.errors import InputError, UnitError
from mcsim.units import KINDS, factor


@dataclass(frozen=True)
class Row:
    """One line of a table: its number in the file, text by column."""

    line: int
    cells: dict[str, str]


@dataclass(frozen=True)
class CsvTable:
    """Rows of text, and what every number of a column is multiplied by (its header's unit)."""

    path: Path
    rows: tuple[Row, ...]
    factors: dict[str, float]

    def number(self, row: Row, column: str) -> float:
        """A finite number in fractions of g, or of the column's own kind.

        Raises
        ------
        InputError
            Text, nothing, or a number that is not finite.
        """
        text = row.cells[column].strip().replace("\N{MINUS SIGN}", "-")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(
                f'{self.path}, line {row.line}: {column}: "{text}" is not a number; '
                "write for example 0.985"
            )
        return value * self.factors[column]


_HEADER = re.compile(r"\s*(\w+)\s*(?:[\[(]([^\])]*)[\])])?\s*")


def read_table(path: Path, needed: tuple[str, ...], optional: tuple[str, ...] = ()) -> CsvTable:
    """Read a CSV file whose header names the ``needed`` columns, with units in brackets.

    Columns of acceleration may be in g or mg; without a unit they are fractions of g.

    Raises
    ------
    InputError
        No such file, columns missing, a unit that is none of g, or a line too short.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = [(n, cells) for n, cells in enumerate(csv.reader(file), start=1) if any(cells)]
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not a text file"
        raise InputError(f"{path}: cannot be read ({reason})") from None
    lines = [(n, cells) for n, cells in lines if not cells[0].lstrip().startswith("#")]
    wanted = ", ".join(needed)
    if not lines:
        raise InputError(f"{path}: is empty; write a header with the columns {wanted}")
    first, header = lines[0]
    names, factors = [], {}
    for text in header:
        match = _HEADER.fullmatch(text)
        name = match[1].lower() if match else text.strip()
        names.append(name)
        factors[name] = _factor(path, first, name, match[2] if match else None)
    missing = [name for name in needed if name not in names]
    if missing and ";" in ",".join(header):
        raise InputError(f"{path}, line {first}: separate the columns by commas, not semicolons")
    if missing:
        raise InputError(
            f"{path}, line {first}: column {', '.join(missing)} is missing; "
            f"the header must name {wanted}"
            + (f" and may name {', '.join(optional)}" if optional else "")
        )
    rows = []
    for n, cells in lines[1:]:
        if len(cells) < len(names) or any(map(str.strip, cells[len(names) :])):
            raise InputError(
                f"{path}, line {n}: {len(cells)} values, but the header names {len(names)} columns"
            )
        rows.append(Row(n, dict(zip(names, cells, strict=False))))
    return CsvTable(path, tuple(rows), factors)


def _factor(path: Path, line: int, name: str, unit: str | None) -> float:
    if unit is None or not unit.strip():
        return 1.0
    try:
        return factor(unit, KINDS["sensor output"])
    except UnitError as error:
        raise InputError(f"{path}, line {line}: column {name}: {error}") from None
