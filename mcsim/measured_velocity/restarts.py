"""Several runs in one file whose clock starts again for each of them, with no column named."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.logs.clock import known_period
from mcsim.logs.column_file import ColumnFile
from mcsim.logs.columns import written_column
from mcsim.logs.counting import usual_interval

Array = NDArray[np.float64]

#: A clock that goes back to this part of the time since its last start, has started again.
_BEGINNING = 0.1
#: Fewer rows are no run: late stamps may go back as far.
_FEWEST_ROWS = 20


def refuse_restarts(file: ColumnFile, time: Array, taken: set[int]) -> None:
    """Refuse stamps (n,) in s from the first row that start again: no clock does so in one drive.

    A clock that wraps around at a usual period goes on, unless a column says otherwise; ``taken``
    are the places of columns that are something else.

    Raises
    ------
    InputError
        The clock starts again; the message names the column that changes where it does.
    """
    rows = _restarts(time)
    if not rows:
        return
    column = _telling(file, rows, len(time), taken)
    if column is None and _wraps(time, rows):
        return
    lines = ", ".join(str(file.line(row)) for row in rows[:3]) + " …" * (len(rows) > 3)
    where = f"{file.path}: the clock starts again at line {lines}: {len(rows) + 1} runs"
    if column is None:
        raise InputError(
            f"{where}, and no column tells them apart; number the runs in a column and name it, "
            "--run-column NAME, or give each run its own file"
        )
    raise InputError(
        f'{where}, as the column "{file.title(column)}" tells: give --run-column '
        f"{_quoted(written_column(file, column))}"
    )


def _restarts(time: Array) -> list[int]:
    """Rows at which the clock has started again."""
    rows, start = [], 0
    for row in (np.flatnonzero(np.diff(time) < 0.0) + 1).tolist():
        since = time[row - 1] - time[start]
        if row - start >= _FEWEST_ROWS and time[row] - time[start] <= _BEGINNING * since:
            rows.append(row)
            start = row
    return rows


def _wraps(time: Array, rows: list[int]) -> bool:
    interval = usual_interval(time)
    backs = [float(time[row - 1] - time[row]) + interval for row in rows]
    return interval > 0.0 and all(known_period(back, interval) is not None for back in backs)


def _telling(file: ColumnFile, rows: list[int], count: int, taken: set[int]) -> int | None:
    """Place of the column that changes at these rows and nowhere else."""
    for place in range(file.count):
        if place not in taken:
            texts = np.array(file.texts(place)[:count])
            if (np.flatnonzero(texts[1:] != texts[:-1]) + 1).tolist() == rows:
                return place
    return None


def _quoted(name: str) -> str:
    return f"'{name}'" if " " in name else name
