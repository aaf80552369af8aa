"""The named columns of a test's CSV file, its outputs in fractions of g."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError, UnitError
from mcsim.logs.csv_file import CsvFile, open_csv
from mcsim.units import KINDS, factor

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Columns:
    """Columns (n,) of a file by name: ``outputs`` in fractions of g, ``texts`` as written."""

    file: CsvFile
    outputs: dict[str, Array]
    texts: dict[str, list[str]]

    def where(self, row: int) -> str:
        """File and line of a row, for messages."""
        return f"{self.file.path}:{self.file.line(row)}"


def read_columns(
    path: Path,
    outputs: tuple[str, ...],
    texts: tuple[str, ...] = (),
    optional: tuple[str, ...] = (),
) -> Columns:
    """Read a CSV file whose header names ``outputs`` and ``texts``, perhaps ``optional`` texts.

    Outputs may be in g or mg, stated in brackets; without a unit they are fractions of g.

    Raises
    ------
    InputError
        No such file, columns missing, a unit that is none of g, a cell that is no number, or a
        line with too many cells.
    """
    file = open_csv(path)
    places = {title.name.casefold(): i for i, title in enumerate(file.titles or ())}
    wanted = ", ".join((*texts, *outputs))
    missing = [name for name in (*texts, *outputs) if name not in places]
    if missing:
        raise InputError(
            f"{path}:{max(file.header, 1)}: column {', '.join(missing)} is missing; "
            f"the header must name {wanted}"
            + (f" and may name {', '.join(optional)}" if optional else "")
        )
    file.check_widths()
    factors = {name: _factor(file, places[name]) for name in outputs}
    numbers = file.numbers([places[name] for name in outputs])
    return Columns(
        file,
        {name: numbers[places[name]].astype(float) * factors[name] for name in outputs},
        {name: file.texts(places[name]) for name in (*texts, *optional) if name in places},
    )


def _factor(file: CsvFile, place: int) -> float:
    unit = file.titles[place].unit if file.titles else ""
    try:
        return factor(unit, KINDS["sensor output"]) if unit else 1.0
    except UnitError as error:
        raise InputError(
            f'{file.path}:{file.header}: column "{file.title(place)}": {error}'
        ) from None
