"""A file of columns with titles and units, whatever its format: what readers of logs ask.

What a column is called and what it means is the business of those who ask; errors name the file
and the line.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.logs.date_times import DATE_AND_TIME
from mcsim.logs.layout import Layout
from mcsim.logs.titles import Title

#: Whole numbers stay whole.
Numbers = NDArray[Any]

#: Characters of a cell, and of a title, that a message shows.
_SHOWN = 40


@dataclass(frozen=True)
class ColumnFile(ABC):
    """Columns of a file, by their places.

    ``layout`` holds their titles, and which are empty, texts or dates.  ``notes`` say what was
    done to read it; they are complete when the numbers are read.
    """

    path: Path
    layout: Layout
    notes: list[str] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Number of columns."""
        return self.layout.count

    @property
    def titles(self) -> tuple[Title, ...] | None:
        """Titles of the columns, in line ``header``; None without a header."""
        return self.layout.titles

    @property
    def header(self) -> int:
        """Line of the header (from 1); 0 without one."""
        return self.layout.header

    def title(self, place: int) -> str:
        """What a column is called in messages."""
        if self.titles is None or not self.titles[place].text:
            return f"column {place + 1}"
        return shown(self.titles[place].text)

    def unit(self, place: int) -> str:
        """What the file says that a column's unit is; '' if nothing."""
        if place in self.layout.dates:
            return DATE_AND_TIME
        return self.titles[place].unit if self.titles else ""

    def place_of(self, name: str) -> int | None:
        """Place of the column with a title or name, or of ``column 3``; None if there is none.

        Raises
        ------
        InputError
            Two columns are called so.
        """
        titles = self.titles or ()
        for of in ("text", "name"):
            places = [i for i, title in enumerate(titles) if getattr(title, of) == name]
            if len(places) > 1:
                raise InputError(
                    f'{self.path}: the column "{shown(name)}" occurs twice; name it '
                    f"column {places[0] + 1} or column {places[1] + 1}"
                )
            if places:
                return places[0]
        word, _, digits = name.partition(" ")
        if word == "column" and digits.isdecimal() and 1 <= int(digits) <= self.count:
            return int(digits) - 1
        return None

    @abstractmethod
    def numbers(self, places: Iterable[int], unknown: bool = False) -> dict[int, Numbers]:
        """Columns (n,) by place; whole numbers stay whole, since nanoseconds do not fit floats.

        With ``unknown``, cells that hold nothing are nan.

        Raises
        ------
        InputError
            The file cannot be read, holds no rows or too many, or a cell holds no finite number.
        """

    @abstractmethod
    def texts(self, place: int) -> list[str]:
        """Cells of a column as they are written; empty ones as ''.

        Raises
        ------
        InputError
            The file cannot be read, or holds no rows.
        """

    @abstractmethod
    def line(self, row: int) -> int:
        """Line of the file (from 1) that holds a row (from 0)."""

    @abstractmethod
    def check_widths(self) -> None:
        """Refuse rows with more cells than titles; for tables of moderate size.

        Raises
        ------
        InputError
            Names the first line at fault.
        """


def since_first(stamps: Numbers) -> NDArray[np.float64]:
    """Differences to the first of whole or real numbers (n,), exact where they are whole.

    Whole nanoseconds since 1970 do not fit into floats: the first one goes before.
    """
    if stamps.dtype.kind == "i" and abs(float(stamps.max()) - float(stamps.min())) < 2.0**62:
        return np.asarray(stamps - stamps[0], float)
    return np.asarray(stamps, float) - float(stamps[0])


def scaled(values: NDArray[np.float64], factor: float, path: Path, title: str) -> Any:
    """Values (n,) in SI units.

    Raises
    ------
    InputError
        A value is beyond what a float holds.
    """
    with np.errstate(over="ignore"):
        result = values * factor
    if not np.all(np.isfinite(result)):
        largest = float(np.abs(values).max())
        raise InputError(f'{path}: column "{title}" reaches {largest:.3g}, beyond any use')
    return result


def shown(text: str) -> str:
    """A title or a cell as messages show it: short, and without control characters."""
    plain = "".join(c if c.isprintable() else "?" for c in text.strip())
    return plain if len(plain) <= _SHOWN else plain[: _SHOWN - 1] + "…"
