"""A recorded drive from a CSV file, smoothed into a truth that is consistent in itself.

Positions (or velocities) and headings carry measurement noise and repeat between
fixes; a truth must be smooth.  Cubic smoothing splines over time make it so: the
accelerations and yaw rate of the truth are the splines' own derivatives, so that
the undisturbed reconstruction returns to the smoothed track, not to the raw fixes.
"""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_smoothing_spline

from mcsim.errors import InputError, UnitError
from mcsim.logs.clock import mend_clock
from mcsim.logs.columns import Column, said, written_column
from mcsim.logs.csv_file import CsvFile, Numbers, open_csv, shown, since_first
from mcsim.logs.timing import unusable
from mcsim.logs.titles import factor_of, kind_of
from mcsim.scenario.tracks import Columns, Recorded
from mcsim.trajectory.curves import Array
from mcsim.trajectory.drive import Motion
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
_FEWEST_ROWS = 8
#: What is unknown for longer (s) is not bridged.
_LONGEST_UNKNOWN = 5.0
#: More rows than this part that are earlier than one before them: the clock is no use.
_MOST_LATE = 0.05
#: No time (Unix time in s), position or angle is larger (SI).
_LARGEST_CELL = 1e11
#: What rounding makes of a difference of time stamps, as a share of the largest one.
_STAMP_ROUNDING = 4 * float(np.finfo(float).eps)
#: Points at which the course is looked at, at most.
_MOST_COURSES = 200_000
#: Fixes that repeat the last position are dropped, but one is kept this often (s).
_REPEATED_FIX = 0.5
#: Below this speed the direction of movement says nothing (m/s).
_STANDSTILL = 0.1
#: Below this speed the course is bridged; above the second one it is fully trusted (m/s).
_MOVING, _SURE_COURSE = 1.0, 5.0


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


class RecordedManoeuvre:
    """The smoothed drive, turned so that ``along`` is the initial direction of movement."""

    jumps: tuple[float, ...] = ()
    #: How the file was read.
    notes: tuple[str, ...] = ()

    def __init__(self, record: Record, smoothing: float) -> None:
        self.duration = float(record.time[-1])
        if record.x is not None and record.y is not None:
            keep = fresh_fixes(record.time, record.x, record.y)
            fixes = record.time[keep]
            x = _smooth(fixes, record.x[keep], smoothing)
            y = _smooth(fixes, record.y[keep], smoothing)
            self._velocity = x.derivative(), y.derivative()
            self._position = x, y
        else:
            assert record.velocity_x is not None
            assert record.velocity_y is not None
            self._velocity = (
                _smooth(record.time, record.velocity_x, smoothing),
                _smooth(record.time, record.velocity_y, smoothing),
            )
            self._position = tuple(v.antiderivative() for v in self._velocity)
        self._acceleration = tuple(v.derivative() for v in self._velocity)
        self._heading = self._heading_spline(record, smoothing)
        self._yaw_rate = self._heading.derivative()
        #: Splines of roll and pitch, if the record holds them.
        self.attitude = None
        if record.roll is not None and record.pitch is not None:
            self.attitude = tuple(
                _smooth(record.time, np.unwrap(angle), smoothing)
                for angle in (record.roll, record.pitch)
            )
        self._set_frame()
        ends = np.array([self.duration])
        vx, vy = (float(v(ends)[0]) for v in self._velocity)
        self.stops = math.hypot(vx, vy) < _STANDSTILL

    def _heading_spline(self, record: Record, smoothing: float):  # type: ignore[no-untyped-def]
        if record.heading is not None:
            return _smooth(record.time, np.unwrap(record.heading), smoothing)
        # The course, trusted where the vehicle moves and bridged where it stands.
        step = min(smoothing / 4.0, self.duration / 16.0)
        step = max(step, self.duration / _MOST_COURSES)
        t = np.linspace(0.0, self.duration, math.ceil(self.duration / step) + 1)
        vx, vy = (v(t) for v in self._velocity)
        speed = np.hypot(vx, vy)
        # The noise of a course goes with 1 / speed, so its weight with speed squared.
        weight = np.clip(speed / _SURE_COURSE, 1e-2, 1.0) ** 2
        course = np.arctan2(vy, vx)
        moving = speed > min(_MOVING, 0.5 * float(speed.max()))
        if speed.max() < _STANDSTILL:
            raise InputError("trajectory.file: the vehicle never moves in this record")
        unwrapped = np.interp(t, t[moving], np.unwrap(course[moving]))
        return _smooth(t, unwrapped, smoothing / 2.0, weight)

    def _set_frame(self) -> None:
        """Origin and direction of the road frame: where and whither the drive begins."""
        t = np.linspace(0.0, self.duration, 4096)
        vx, vy = (v(t) for v in self._velocity)
        first = int(np.argmax(np.hypot(vx, vy) > _STANDSTILL))
        self._turn = math.atan2(float(vy[first]), float(vx[first]))
        zero = np.array([0.0])
        self._origin = tuple(float(p(zero)[0]) for p in self._position)

    def motion(self, t: Array) -> Motion:
        c, s = math.cos(self._turn), math.sin(self._turn)
        x, y = (p(t) - o for p, o in zip(self._position, self._origin, strict=True))
        vx, vy = (v(t) for v in self._velocity)
        ax, ay = (a(t) for a in self._acceleration)
        heading = self._heading(t)
        ch, sh = np.cos(heading), np.sin(heading)
        return Motion(
            along=c * x + s * y,
            across=c * y - s * x,
            velocity_along=c * vx + s * vy,
            velocity_across=c * vy - s * vx,
            heading=heading - self._turn,
            forward=ch * ax + sh * ay,
            left=ch * ay - sh * ax,
            yaw_rate=self._yaw_rate(t),
        )


def load_drive(shape: Recorded, folder: Path) -> RecordedManoeuvre:
    """The manoeuvre of a recorded track.

    Raises
    ------
    InputError
        The file cannot be read, lacks a column, holds text, runs backwards, or is too short.
    """
    path = folder / shape.file
    compass, nose_up = shape.angles == "compass", shape.pitch_positive == "nose_up"
    record = read_record(path, shape.columns, compass, nose_up, shape.unknown)
    t = record.time - record.time[0]
    # Differences of stamps carry the rounding of the stamps: a row on an end is inside.
    rounding = _STAMP_ROUNDING * max(1.0, float(np.max(np.abs(record.time))))
    keep = t >= shape.start - rounding
    if shape.duration is not None:
        keep &= t <= shape.start + shape.duration + rounding
    if np.count_nonzero(keep) < _FEWEST_ROWS:
        raise InputError(
            f"{path}: {np.count_nonzero(keep)} rows between `start` and the end of `duration`; "
            f"at least {_FEWEST_ROWS} are needed (the record lasts {t[-1]:.6g} s)"
        )
    cut, unknown = _known(path, record.cut(keep))
    manoeuvre = RecordedManoeuvre(replace(cut, time=cut.time - cut.time[0]), shape.smoothing)
    manoeuvre.notes = (*record.notes, *unknown)
    return manoeuvre


def _known(path: Path, record: Record) -> tuple[Record, tuple[str, ...]]:
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
    if len(where) < _FEWEST_ROWS:
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


def read_record(
    path: Path,
    columns: Columns,
    compass: bool,
    nose_up: bool = False,
    unknown: float | None = None,
) -> Record:
    """Read and convert the columns of a CSV file.

    ``unknown`` stands, as written in the file, for a value that is not known; so does an empty
    cell, and a speed or course of -1 where no other is negative.  Such values are nan.

    Raises
    ------
    InputError
        See ``load_drive``.
    """
    file = open_csv(path)
    specs = {role: spec for role, spec in columns.model_dump().items() if spec is not None}
    chosen = {role: _column(file, role, spec) for role, spec in specs.items()}
    cells = file.numbers([column.place for column in chosen.values()], unknown=True)
    values, notes = {}, [said(file, list(chosen.values())), *file.notes]
    for role, column in chosen.items():
        values[role], note = _values(file, role, column, cells[column.place], unknown)
        notes += [note] if note else []
    time = values["time"]
    if len(time) < _FEWEST_ROWS:
        raise InputError(f"{path}: {len(time)} rows; at least {_FEWEST_ROWS} are needed")
    time, values = _in_order(file, time, values)
    x, y = _position(values)

    def turn(angle: Array) -> Array:
        return np.pi / 2.0 - angle if compass else angle

    velocity_x = velocity_y = None
    if "course" in values:
        # Without motion there is no course, and the velocity is known all the same.
        still = np.isnan(values["course"]) & (np.abs(values["speed"]) < _STANDSTILL)
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


def _column(file: CsvFile, role: str, spec: str) -> Column:
    """The column of a role, its unit from the scenario or from the header."""
    name, separator, unit = spec.rpartition(" in ")
    name = name.strip() if separator else spec.strip()
    kind = KINDS[_KIND_OF[role]]
    place = file.place_of(name)
    if place is None:
        held = [written_column(file, i) for i in range(file.count)]
        close = difflib.get_close_matches(name, held, n=1)
        hint = f'; did you mean "{close[0]}"?' if close else ""
        raise InputError(
            f'{file.path}: no column "{shown(name)}" for {role}{hint} (columns: {", ".join(held)})'
        )
    own = file.unit(place)
    if not (unit.strip() if separator else own):
        example = kind.example.split()[1]
        raise InputError(
            f'trajectory.columns.{role}: "{spec}" has no unit; '
            f'write for example "{spec} in {example}"'
        )
    try:
        scale = factor_of(unit if separator else own, kind)
    except UnitError as error:
        raise InputError(f"trajectory.columns.{role}: {error}") from None
    stated = kind_of(own) if own else None
    if separator and stated is kind and not math.isclose(factor_of(own, kind), scale):
        raise InputError(
            f'trajectory.columns.{role}: "{spec}", but the header of {file.path} says '
            f'"{file.title(place)}"; correct one'
        )
    return Column(place, file.title(place), role, scale, unit.strip() if separator else own)


def _values(
    file: CsvFile, role: str, column: Column, cells: Numbers, unknown: float | None
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
    needed = "an angle within ±90 °" if role == "latitude" else "a finite number"
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
    count = int(np.count_nonzero(missing))
    note = (
        f"{role}: {count} of {len(held)} values are unknown (empty or {said_so})" if count else ""
    )
    return np.where(missing, np.nan, values), note


def fresh_fixes(time: Array, x: Array, y: Array) -> NDArray[np.bool_]:
    """Rows whose position is news: a receiver repeats its last fix between updates."""
    keep = np.zeros(len(time), bool)
    last = -1
    for i in range(len(time)):
        moved = last < 0 or x[i] != x[last] or y[i] != y[last]
        if moved or time[i] - time[last] >= _REPEATED_FIX:
            keep[i] = True
            last = i
    keep[-1] = True
    return keep


def _in_order(
    file: CsvFile, time: Array, values: dict[str, Array]
) -> tuple[Array, dict[str, Array]]:
    """Rows in the order of their time stamps; the time keeps varying.

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
    return (
        time[clock.rows[0]] + spread[kept],
        {role: column[clock.rows][kept] for role, column in values.items()},
    )


def _position(values: dict[str, Array]) -> tuple[Array | None, Array | None]:
    if "x" in values:
        return values["x"], values["y"]
    if "latitude" in values:
        return local_position(values["latitude"], np.unwrap(values["longitude"]))
    return None, None


def _smooth(t: Array, y: Array, time_constant: float, weight: Array | None = None):  # type: ignore[no-untyped-def]
    """Smoothing spline whose transfer function is 1 / (1 + (omega tau)^4).

    Minimises ``rho integral (y - f)^2 + lam integral f''^2`` with rho rows per
    second, so ``lam = rho tau^4``.
    """
    density = (len(t) - 1) / (t[-1] - t[0])
    if len(t) < 5:
        raise InputError("trajectory.file: fewer than 5 distinct positions; too few for a track")
    return make_smoothing_spline(t, y, w=weight, lam=density * time_constant**4)
