"""A recorded velocity: of a vehicle, or of its left and right wheels, from a log of any format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from annotated_types import Le
from pydantic import model_validator

from mcsim.errors import InputError
from mcsim.scenario.block import Block
from mcsim.scenario.fields import NotNegative, Positive, Time, reject
from mcsim.systems.velocity.profiles.points import linear_between
from mcsim.systems.velocity.profiles.profile import (
    LONGEST,
    Array,
    Profile,
    RunBlock,
    VelocityProfile,
)

#: Share of the largest velocity that a standstill may show.
_STILL = 0.01
#: What rounding makes of a time within a record (s).
_ROUNDING = 1e-9


class VelocityColumns(Block):
    """Columns of a recorded velocity, each written as `NAME in UNIT`, or `NAME` if titled so."""

    time: str = "time in s"
    """Time stamps, ascending; the first one is time 0 of the record."""
    velocity: str | None = None
    """Of the vehicle."""
    left: str | None = None
    """Of the left wheel; the vehicle's is the mean of both."""
    right: str | None = None
    """Of the right wheel."""

    @model_validator(mode="after")
    def _of_vehicle_or_wheels(self) -> VelocityColumns:
        given = [name for name in ("velocity", "left", "right") if getattr(self, name) is not None]
        if given not in (["velocity"], ["left", "right"]):
            raise reject(
                "name the column of the vehicle's `velocity`, or those of its `left` and `right` "
                f"wheels, not {' and '.join(given) or 'none of them'}"
            )
        return self


class RecordedRun(RunBlock):
    """A straight run whose velocity was recorded; linear between the rows."""

    shape: Literal["recorded"]
    file: str
    """File of the record, CSV or another format of logs, relative to the scenario file."""
    columns: VelocityColumns
    """Which column holds what, in which unit."""
    start: Annotated[Time, NotNegative] = 0.0
    """Where the run begins, after the first row: the vehicle stands there."""
    duration: Annotated[Time, Positive, Le(LONGEST)]
    """How much of the record is the run."""

    @property
    def files(self) -> tuple[str, ...]:
        return (self.file,)


def _profile(run: RecordedRun, folder: Path) -> Profile:
    path = folder / run.file
    time, velocity, notes = _read(path, run.columns)
    end = run.start + run.duration
    if end > time[-1] + _ROUNDING:
        raise InputError(
            f"{path}: the record lasts {time[-1]:.6g} s; `start` and `duration` ask for "
            f"{end:.6g} s of it"
        )
    inside = (time > run.start + _ROUNDING) & (time < end - _ROUNDING)
    times = np.concatenate([[run.start], time[inside], [end]])
    velocities = np.interp(times, time, velocity)
    _refuse_moving(path, run, velocities)
    times = np.append(times[:-1] - run.start, run.duration)
    return linear_between(times, velocities, notes)


def _read(path: Path, columns: VelocityColumns) -> tuple[Array, Array, tuple[str, ...]]:
    """Times since the first row (n,) in s, the vehicle's velocity (n,) in m/s, and notes."""
    from mcsim.logs import open_log
    from mcsim.logs.column_file import scaled, since_first
    from mcsim.logs.columns import said
    from mcsim.logs.stated_column import stated_column
    from mcsim.units import KINDS

    file = open_log(path)
    specs = {role: spec for role, spec in columns.model_dump().items() if spec is not None}
    chosen = {
        role: stated_column(file, role, spec, KINDS["time" if role == "time" else "speed"])
        for role, spec in specs.items()
    }
    numbers = file.numbers([column.place for column in chosen.values()])
    values = {}
    for role, column in chosen.items():
        cells = numbers[column.place]
        plain = since_first(cells) if role == "time" else cells.astype(float)
        values[role] = scaled(plain, column.factor, path, column.title)
    time = values.pop("time")
    if len(time) < 2:
        raise InputError(f"{path}: {len(time)} rows; at least 2 are needed")
    late = np.flatnonzero(np.diff(time) <= 0.0)
    if len(late):
        row = int(late[0]) + 1
        raise InputError(
            f"{path}:{file.line(row)}: the time stands still or runs backwards here; correct the "
            "stamps, or cut the file"
        )
    notes = (said(file, list(chosen.values())), *file.notes)
    return time, np.mean(list(values.values()), axis=0), notes


def _refuse_moving(path: Path, run: RecordedRun, velocities: Array) -> None:
    top = float(np.max(np.abs(velocities)))
    if top == 0.0:
        raise InputError(f"{path}: the vehicle does not move between `start` and its end")
    if abs(velocities[0]) > _STILL * top:
        raise InputError(
            f"{path}: at `start`, {run.start:g} s, the vehicle moves at {velocities[0]:.3g} m/s; "
            "a run begins from rest: let it start where the vehicle stands"
        )


PROFILE = VelocityProfile("recorded", RecordedRun, _profile)
