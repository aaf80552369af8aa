"""A recorded drive's file: its columns in SI units, in the order of time, and what is unknown."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.logs.clock import mend_clock
from mcsim.logs.column_file import ColumnFile, Numbers, since_first
from mcsim.logs.columns import Column, said
from mcsim.logs.formats import open_log
from mcsim.logs.stated_column import stated_column
from mcsim.logs.timing import unusable
from mcsim.tracks.recorded.block import Columns
from mcsim.tracks.recorded.plausible import refuse_digits_of_a_clock, refuse_jumps
from mcsim.trajectory.curves import Array
from mcsim.trajectory.geodesy import local_position
from mcsim.units import KINDS

_KIND_OF = {
    "time": "time",
    "x": "length",
    "y": "length",
    "latitude": "angle",
    "longitude": "angle",
    "speed": "speed",
    "course": "angle",
    "heading": "angle",
    "roll": "angle",
    "pitch": "angle",
}
#: Fewer rows are no drive.
FEWEST_ROWS = 8
#: What is unknown for longer (s) is not bridged.
_LONGEST_UNKNOWN = 5.0
#: More rows than this part that are earlier than one before them: the clock is no use.
_MOST_LATE = 0.05
#: No time (Unix time in s), position or angle is larger (SI).
_LARGEST_CELL = 1e11
#: Below this speed the direction of movement says nothing (m/s).
STANDSTILL = 0.1


@dataclass(frozen=True)
class Record:
    """Columns of the file in SI units; absent ones are None. All arrays have n rows.

    What is unknown is nan; ``notes`` say how the file was read.
    """

    time: Array
    x: Array | None
    y: Array | None
    velocity_x: Array | None
    velocity_y: Array | None
    heading: Array | None
    roll: Array | None = None
    pitch: Array | None = None
    notes: tuple[str, ...] = ()

    def columns(self) -> dict[str, Array]:
        """The columns that are there, by name."""
        return {
            part.name: value
            for part in fields(self)
            if isinstance(value := getattr(self, part.name), np.ndarray)
        }

    def cut(self, keep: NDArray[np.bool_]) -> Record:
        """The rows to keep, (n,)."""
        kept: dict[str, Any] = {name: value[keep] for name, value in self.columns().items()}
        return replace(self, **kept)


def read_record(
    path: Path,
    columns: Columns,
    compass: bool,
    nose_up: bool = False,
    unknown: float | None = None,
) -> Record:
    """Read and convert the columns of a log.

    ``unknown`` stands, as written in the file, for a value that is not known; so does an empty
    cell, and a speed or course of -1 where no other is negative.  Such values are nan.

    Raises
    ------
    InputError
        The file cannot be read, lacks a column, holds text, runs backwards, or is too short.
    """
    file = open_log(path)
    specs = {role: spec for role, spec in columns.model_dump().items() if spec is not None}
    chosen = {
        role: stated_column(file, role, spec, KINDS[_KIND_OF[role]]) for role, spec in specs.items()
    }
    cells = file.numbers([column.place for column in chosen.values()], unknown=True)
    values, notes = {}, [said(file, list(chosen.values())), *file.notes]
    for role, column in chosen.items():
        values[role], note = _values(file, role, column, cells[column.place], unknown)
        notes += [note] if note else []
    time = values["time"]
    if len(time) < FEWEST_ROWS:
        raise InputError(f"{path}: {len(time)} rows; at least {FEWEST_ROWS} are needed")
    time, values, told = _in_order(file, time, values)
    notes += told
    x, y = _position(values)

    def turn(angle: Array) -> Array:
        return np.pi / 2.0 - angle if compass else angle

    velocity_x = velocity_y = None
    if "course" in values:
        # Without motion there is no course, and the velocity is known all the same.
        still = np.isnan(values["course"]) & (np.abs(values["speed"]) < STANDSTILL)
        course = turn(np.where(still, 0.0, values["course"]))
        speed = np.where(still, 0.0, values["speed"])
        velocity_x, velocity_y = speed * np.cos(course), speed * np.sin(course)
    heading = turn(values["heading"]) if "heading" in values else None
    pitch = values.get("pitch")
    if pitch is not None and nose_up:
        pitch = -pitch
    return Record(
        time, x, y, velocity_x, velocity_y, heading, values.get("roll"), pitch, tuple(notes)
    )


def _values(
    file: ColumnFile, role: str, column: Column, cells: Numbers, unknown: float | None
) -> tuple[Array, str]:
    """Values (n,) of a role in SI units, nan where they are unknown, and what to say of those."""
    held = since_first(cells) if role == "time" else np.asarray(cells, float)
    missing = np.isnan(held)
    said_so = f"{unknown:g}" if unknown is not None else "-1"
    if role != "time" and unknown is not None:
        missing |= held == unknown
    elif role in ("speed", "course", "heading"):
        # Receivers and phones write -1; of speeds and compass angles no other is negative.
        negative = held < 0.0
        if np.all(held[negative] == -1.0):
            missing |= negative
    known = np.where(missing, 0.0, held)
    limit = math.pi / 2.0 if role == "latitude" else _LARGEST_CELL
    with np.errstate(over="ignore"):
        values = known * column.factor
    bad = ~(np.abs(values) <= limit * (1.0 + 1e-12))
    needed = "a finite number"
    if role == "latitude":
        needed = "an angle within ±90 ° (degrees and minutes in one number, ddmm.mmmm, are none)"
    if role == "speed" and not np.any(bad):
        bad = values < 0.0
        needed = "a speed that is not negative (or the scenario's `unknown: -1`)"
    if role == "time" and not np.any(bad):
        bad = missing
    if np.any(bad):
        row = int(np.argmax(bad))
        cell = "nothing" if missing[row] else f'"{float(cells[row]):.6g}"'
        raise InputError(
            f'{file.path}:{file.line(row)}: column "{column.title}" holds {cell}, where {needed} '
            "is needed"
        )
    if role == "time":
        refuse_digits_of_a_clock(file, column, np.asarray(cells, float))
    else:
        refuse_jumps(file, role, column, np.where(missing, np.nan, values), cells)
    count = int(np.count_nonzero(missing))
    note = (
        f"{role}: {count} of {len(held)} values are unknown (empty or {said_so})" if count else ""
    )
    return np.where(missing, np.nan, values), note


def known_rows(path: Path, record: Record) -> tuple[Record, tuple[str, ...]]:
    """The rows of which everything is known, and what to say of the others.

    Raises
    ------
    InputError
        Too few are left, or what is unknown lasts too long to be bridged.
    """
    known = np.logical_and.reduce([np.isfinite(column) for column in record.columns().values()])
    missing = int(np.count_nonzero(~known))
    if not missing:
        return record, ()
    start = record.time[0]
    where = np.flatnonzero(known)
    told = f"{missing} of {len(known)} rows hold no value in a column that is used"
    way_out = "cut the drive by `start` and `duration`, or use other columns"
    if len(where) < FEWEST_ROWS:
        raise InputError(f"{path}: {told}; {len(where)} are left; {way_out}")
    gaps = np.diff(record.time[where])
    bridged = np.diff(where) > 1
    longest = float(np.max(gaps, where=bridged, initial=0.0))
    if longest > _LONGEST_UNKNOWN:
        at = record.time[where[int(np.argmax(np.where(bridged, gaps, 0.0)))]] - start
        raise InputError(
            f"{path}: {told}, for {longest:.3g} s from {at:.6g} s on: too long to be bridged "
            f"({_LONGEST_UNKNOWN:g} s are); {way_out}"
        )
    note = f"{told}: left out"
    if where[0] > 0:
        note += f"; the drive begins {record.time[where[0]] - start:.3g} s later"
    if longest:
        note += f"; up to {longest:.3g} s are bridged"
    return record.cut(known), (note,)


def _in_order(
    file: ColumnFile, time: Array, values: dict[str, Array]
) -> tuple[Array, dict[str, Array], list[str]]:
    """Rows in the order of their time stamps, and what was mended; the time keeps varying.

    Rows that say the same twice are dropped; stamps that repeat the one before, with new values,
    are spread between their neighbours, and a clock that begins anew or was set back goes on.
    """
    columns = np.array([column for role, column in values.items() if role != "time"])
    unchanged = (np.diff(columns) == 0.0) | (np.isnan(columns[:, 1:]) & np.isnan(columns[:, :-1]))
    same = np.concatenate([[False], np.all(unchanged, axis=0)])
    clock = mend_clock(time, same)
    stamps = clock.stamps
    # A stamp is fresh when it is later than all before it.
    fresh = np.concatenate([[True], stamps[1:] > np.maximum.accumulate(stamps)[:-1]])
    late = np.flatnonzero(np.diff(stamps) < 0.0) + 1
    if unusable(clock) or np.count_nonzero(~fresh[late]) > _MOST_LATE * len(stamps):
        row = int(clock.rows[late[0]]) if len(late) else int(np.argmin(fresh))
        raise InputError(
            f"{file.path}:{file.line(row)}: the time runs backwards or stands still here, and "
            "does not go forward again; correct the stamps, or cut the file"
        )
    places = np.flatnonzero(fresh)
    rows = np.arange(len(stamps))
    spread = np.interp(rows, places, stamps[places])
    kept = rows <= places[-1]
    notes = [*clock.notes]
    stale = int(np.count_nonzero(~fresh))
    if stale:
        notes.append(
            f"{stale} of {len(fresh)} time stamps are no later than one before them: "
            "spread between their neighbours"
        )
    return (
        time[clock.rows[0]] + spread[kept],
        {role: column[clock.rows][kept] for role, column in values.items()},
        notes,
    )


def _position(values: dict[str, Array]) -> tuple[Array | None, Array | None]:
    if "x" in values:
        return values["x"], values["y"]
    if "latitude" in values:
        longitude = values["longitude"].copy()
        known = np.isfinite(longitude)
        longitude[known] = np.unwrap(longitude[known])
        return local_position(values["latitude"], longitude)
    return None, None
