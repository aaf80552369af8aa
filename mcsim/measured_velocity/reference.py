"""What the velocity is compared with: another speed, or one or two wheels, averaged."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError, UnitError
from mcsim.logs.column_file import ColumnFile, Numbers, scaled, since_first
from mcsim.logs.columns import Column, time_column, written_column
from mcsim.logs.formats import open_log
from mcsim.logs.titles import factor_of
from mcsim.units import KINDS

Array = NDArray[np.float64]

#: What a reference may be, by the kind of its unit.
_SPEED, _RATE, _ANGLE, _TICKS = "speed", "angular rate", "angle", "ticks"


@dataclass(frozen=True)
class Reference:
    """Columns of the reference, each as `NAME in UNIT`, and what makes speeds of them.

    ``radius`` of the wheels (m) where they turn; ``ticks`` of an encoder per turn, whose columns
    are written `NAME in ticks`; ``uncertainty`` (m/s) and ``relative`` are its standard
    uncertainty, absolute and as a share of the speed.
    """

    columns: tuple[str, ...]
    radius: float | None = None
    ticks: float | None = None
    uncertainty: float = 0.0
    relative: float = 0.0

    def deviation(self, speed: Array) -> Array:
        """Standard uncertainty (…) at given speeds (m/s)."""
        return np.hypot(self.uncertainty, self.relative * speed)


@dataclass(frozen=True)
class _Wheel:
    """A column of the reference, and which kind of quantity it holds."""

    column: Column
    kind: str


def read_reference(
    reference: Reference,
    file: ColumnFile,
    other: Path | None,
    stamps: tuple[Numbers, float],
) -> tuple[Array, list[Column]]:
    """Speed (n,) at the stamps of a run's file (cells and the factor to s), and columns used there.

    Of several columns, left and right, it is the mean.  Angles and ticks become speeds by their
    slope over time; between values of the reference it goes straight, before and after it is nan.

    Raises
    ------
    InputError
        No such column, no unit, one of another kind, or no radius of a wheel that turns.
    """
    source = file if other is None else open_log(other)
    wheels = [_wheel(source, text, reference) for text in reference.columns]
    cells = source.numbers([w.column.place for w in wheels], unknown=True)
    at = scaled(since_first(stamps[0]), stamps[1], file.path, "time")
    own = at if other is None else _stamps(source, stamps)
    speeds = [_speed(source, w, cells[w.column.place], own, reference) for w in wheels]
    found = [np.interp(at, t, v, left=np.nan, right=np.nan) for t, v in speeds]
    return np.mean(found, axis=0), [w.column for w in wheels] if other is None else []


def _wheel(file: ColumnFile, text: str, reference: Reference) -> _Wheel:
    name, separator, unit = text.rpartition(" in ")
    name, unit = (name.strip(), unit.strip()) if separator else (text.strip(), "")
    place = file.place_of(name)
    if place is None:
        held = ", ".join(written_column(file, i) for i in range(file.count))
        raise InputError(f'{file.path}: no column "{name}" for the reference (it has {held})')
    unit = unit or file.unit(place)
    title = file.title(place)
    if not unit:
        raise InputError(
            f"--reference '{text}': has no unit; write '{text} in m/s', in rad/s or in ° of a "
            "wheel, or in ticks of an encoder"
        )
    if unit == _TICKS:
        if reference.ticks is None:
            raise InputError(f"--reference '{text}': ticks need --ticks-per-turn")
        column = Column(place, title, "reference", 2.0 * np.pi / reference.ticks, unit)
        return _turning(_Wheel(column, _TICKS), text, reference)
    for kind in (_SPEED, _RATE, _ANGLE):
        try:
            factor = factor_of(unit, KINDS[kind])
        except UnitError:
            continue
        wheel = _Wheel(Column(place, title, "reference", factor, unit), kind)
        return wheel if kind == _SPEED else _turning(wheel, text, reference)
    raise InputError(
        f"--reference '{text}': \"{unit}\" is no unit of a speed (m/s), of a wheel's rate (rad/s) "
        "or angle (°), nor ticks"
    )


def _turning(wheel: _Wheel, text: str, reference: Reference) -> _Wheel:
    if reference.radius is None:
        raise InputError(f"--reference '{text}': what turns needs --wheel-radius, such as '0.1 m'")
    return wheel


def _stamps(source: ColumnFile, stamps: tuple[Numbers, float]) -> Array:
    """Stamps of the reference's file, from the first stamp of the run's."""
    place = time_column(source) if source.titles is not None else None
    unit = "" if place is None else source.unit(place)
    if place is None or not unit:
        raise InputError(
            f"{source.path}: a reference's own file needs a column of time stamps with its unit, "
            "such as `time [s]`"
        )
    factor = factor_of(unit, KINDS["time"])
    cells, first = source.numbers([place])[place], stamps[0][0]
    # Whole nanoseconds are subtracted before they become floats.
    if cells.dtype.kind == stamps[0].dtype.kind == "i" and factor == stamps[1]:
        return scaled(np.asarray(cells - first, float), factor, source.path, "time")
    seconds = scaled(np.asarray(cells, float), factor, source.path, "time")
    return np.asarray(seconds - float(first) * stamps[1], float)


def _speed(
    file: ColumnFile, wheel: _Wheel, cells: Numbers, time: Array, reference: Reference
) -> tuple[Array, Array]:
    """Stamps and speeds (m/s) of one column, where it holds values."""
    held = np.asarray(cells, float)
    known = np.isfinite(held)
    if np.count_nonzero(known) < 2:
        raise InputError(f'{file.path}: column "{wheel.column.title}" holds no values')
    t, values = time[known], held[known]
    if np.any(np.diff(t) < 0.0):
        order = np.argsort(t, kind="stable")
        t, values = t[order], values[order]
    values = scaled(values, wheel.column.factor, file.path, wheel.column.title)
    if wheel.kind == _SPEED:
        return t, values
    radius = float(reference.radius or 0.0)
    if wheel.kind == _RATE:
        return t, radius * values
    fresh = np.concatenate([[True], np.diff(t) > 0.0])
    return t[fresh], radius * np.gradient(values[fresh], t[fresh])
