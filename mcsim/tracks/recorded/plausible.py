"""Values of a recorded drive that no vehicle has: what stands for something else is not driven.

Receivers write 999.9, 655.35 or a latitude of 0 for what they do not know, and 100059.8 for ten
o'clock and almost a minute.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.logs.column_file import ColumnFile, Numbers
from mcsim.logs.columns import Column
from mcsim.trajectory.curves import Array

#: Changes (SI) from one row to the next that no vehicle makes: 50 m/s, some ten kilometres.
_JUMPS = {"speed": 50.0, "x": 10_000.0, "y": 10_000.0, "latitude": 2e-3, "longitude": 0.02}
_TURN = 2.0 * np.pi
#: Digits hhmmss of a clock leave out 40 s at each minute.
_MINUTE, _LEFT_OUT = 60.0, 40.0


def refuse_jumps(
    file: ColumnFile, role: str, column: Column, values: Array, cells: Numbers
) -> None:
    """Refuse values (n,) of a role in SI units, nan where unknown, that leave and come back.

    Raises
    ------
    InputError
        Names the first row, and what to write if it stands for an unknown value.
    """
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < 3:
        return
    held = values[known]
    steps = np.abs(np.diff(held))
    if role == "longitude":
        steps = np.minimum(steps, np.abs(_TURN - steps))
    if role in ("course", "heading"):
        # A turn that goes on beyond 360 degrees has no steps, one that wraps no such values.
        beyond = np.abs(held) > _TURN * (1.0 + 1e-9)
        bad = _beside(steps > 0.5 * _TURN) & beyond
    elif role in _JUMPS:
        # Of the two sides of a jump the one far from the usual values is at fault.
        far = np.abs(held - float(np.median(held))) > _JUMPS[role]
        bad = _beside(steps > _JUMPS[role]) & far
    else:
        return
    if not np.any(bad):
        return
    row = int(known[int(np.argmax(bad))])
    cell = f"{float(cells[row]):.10g}"
    raise InputError(
        f'{file.path}:{file.line(row)}: column "{column.title}" holds {cell}, a jump that no '
        f"vehicle makes; if this stands for an unknown value, write `unknown: {cell}` into the "
        "track, else correct the row"
    )


def _beside(jumps: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Rows (n,) on either side of a jump, of which there are n - 1 places."""
    padded = np.concatenate([[False], jumps, [False]])
    rows: NDArray[np.bool_] = padded[:-1] | padded[1:]
    return rows


def refuse_digits_of_a_clock(file: ColumnFile, column: Column, cells: Array) -> None:
    """Refuse time stamps (n,) as written that are hhmmss, such as NMEA's.

    Raises
    ------
    InputError
        They leave out 40 s whenever a minute is full, and nowhere else.
    """
    if (
        len(cells) < 3
        or np.any(cells < 0.0)
        or np.any(cells >= 240_000.0)
        or np.any(cells % 100.0 >= _MINUTE)
    ):
        return
    steps = np.diff(cells)
    full = np.diff(np.floor(cells / 100.0)) == 1.0
    usual = float(np.median(steps))
    if np.any(full) and np.all(
        np.abs(steps[full] % 100.0 - _LEFT_OUT - usual) < 2.0 * usual + 1e-6
    ):
        raise InputError(
            f'{file.path}: column "{column.title}" holds times as digits, hhmmss '
            f"({cells[0]:.10g}), no seconds: write 10:00:59.8 for 100059.8, or seconds"
        )
