"""Recorded runs: raw output of a tri-axial accelerometer over its own time stamps.

One file holds one run, several that a column tells apart, or several with rests between them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.calibration.columns import metres_notes
from mcsim.errors import InputError
from mcsim.logs.clock import mend_clock
from mcsim.logs.column_file import ColumnFile, Numbers, scaled, since_first
from mcsim.logs.columns import Column, assign, said, unmatched_units, written_column
from mcsim.logs.formats import open_log
from mcsim.logs.model import ReadOptions
from mcsim.logs.names import TIME
from mcsim.logs.timing import unusable
from mcsim.measured_velocity.reference import Reference, read_reference
from mcsim.measured_velocity.restarts import refuse_restarts
from mcsim.units import STANDARD_GRAVITY

Array = NDArray[np.float64]

_AXES = ("accel_x", "accel_y", "accel_z")
#: The column that tells runs apart, where none is named.
RUN_COLUMN = "run"
#: Fewer rows are no rest with a motion behind it.
FEWEST_ROWS = 20
#: No working sensor's output (fractions of g) is larger.
_LARGEST_OUTPUT = 1000.0


@dataclass(frozen=True)
class RecordedRuns:
    """One stretch of a log: a run with its rest, or several with rests between them.

    ``time`` (n,) in s from its first row, ``raw`` (n, 3) in fractions of g, ``reference`` (n,) the
    velocity that something else has measured (m/s), if there is one.  Stamps are told apart to
    ``resolution`` (s).
    """

    name: str
    time: Array
    raw: Array
    reference: Array | None
    resolution: float = 0.0


@dataclass(frozen=True)
class Layout:
    """What the files do not say: columns and units as `mcsim characterise` takes them."""

    columns: str | None = None
    units: str | None = None
    run_column: str | None = None
    reference: Reference | None = None


def read_runs(
    path: Path, layout: Layout, other: Path | None = None, tell: Callable[[str], None] | None = None
) -> tuple[list[RecordedRuns], bool]:
    """The stretches of a log, and whether a column tells its runs apart.

    ``other`` is the reference's own file, with stamps of the same clock.

    Raises
    ------
    InputError
        Columns, units or time stamps are missing, wrong, or doubtful; several runs that no column
        tells apart.
    """
    file = open_log(path, ReadOptions())
    found = assign(file, layout.columns, layout.units)
    _check(file, found, layout.units)
    by_name = {column.name: column for column in found}
    cells = file.numbers([c.place for c in found])
    axes = [by_name[axis] for axis in _AXES]
    raw = np.column_stack([_outputs(file, column, cells) for column in axes])
    stamps = cells[by_name[TIME].place]
    label = _run_place(file, layout.run_column)
    reference = None
    also: list[Column] = []
    if layout.reference is not None:
        reference, also = read_reference(
            layout.reference, file, other, (stamps, by_name[TIME].factor)
        )
    notes = [said(file, [*found, *also], [] if label is None else [label]), *file.notes]
    notes += [f"{n}; right if the calibration is from m/s² as well" for n in metres_notes(axes)]
    labels = None if label is None else file.texts(label)[: len(raw)]
    time = scaled(since_first(stamps), by_name[TIME].factor, path, by_name[TIME].title)
    if label is None:
        refuse_restarts(file, time, {c.place for c in [*found, *also]})
    resolution = _resolution(stamps, by_name[TIME].factor)
    whole = RecordedRuns(str(path), time, raw, reference, resolution)
    stretches = []
    for name, rows in _stretches(path, labels):
        stretch, told = _in_order(path, name, _cut(whole, rows))
        if stretch.reference is None and layout.reference is not None:
            raise InputError(f"{name}: the reference holds no values while this run was recorded")
        stretches.append(stretch)
        notes += told
    for note in notes if tell is not None else ():
        tell(note)  # type: ignore[misc]
    return stretches, label is not None


def _check(file: ColumnFile, found: list[Column], units: str | None) -> None:
    names = {column.name for column in found}
    missing = [axis for axis in _AXES if axis not in names]
    if missing:
        raise InputError(
            f"{file.path}: no column of {', '.join(missing)}; the velocity follows from all three "
            "axes of an accelerometer: name them, --columns time=…,accel_x=…,accel_y=…,accel_z=…"
        )
    if TIME not in names:
        raise InputError(
            f"{file.path}: no column of time stamps; the integration runs over measured intervals: "
            "name it, --columns time=…,accel_x=…,accel_y=…,accel_z=…"
        )
    unused = unmatched_units(units, found)
    if unused:
        raise InputError(f"--units {unused[0]}: {file.path} has no such column")


def _outputs(file: ColumnFile, column: Column, cells: dict[int, Numbers]) -> Array:
    """Raw output (n,) in fractions of g; m/s² are divided by standard gravity."""
    values = np.asarray(cells[column.place], float)
    outputs = scaled(values, column.factor / STANDARD_GRAVITY, file.path, column.title)
    far = np.abs(outputs) > _LARGEST_OUTPUT
    if far.any():
        row = int(np.argmax(far))
        raise InputError(
            f'{file.path}:{file.line(row)}: column "{column.title}" holds {values[row]:g}, '
            f"{outputs[row]:.3g} g: beyond any sensor; is its unit right?"
        )
    return np.asarray(outputs, float)


def _resolution(stamps: Numbers, factor: float) -> float:
    """How finely (s) floating numbers tell stamps apart: coarse for seconds since 1970."""
    if stamps.dtype.kind != "f":
        return 0.0
    return abs(factor) * float(np.spacing(np.max(np.abs(stamps))))


def _run_place(file: ColumnFile, named: str | None) -> int | None:
    """Place of the column that tells runs apart."""
    if named is not None:
        place = file.place_of(named)
        if place is None:
            held = ", ".join(written_column(file, i) for i in range(file.count))
            raise InputError(f'{file.path}: no column "{named}" of runs (it has {held})')
        return place
    titles = file.titles or ()
    places = [i for i, title in enumerate(titles) if title.name.casefold() == RUN_COLUMN]
    if len(places) > 1:
        raise InputError(f'{file.path}: two columns are called "run"; name one by --run-column')
    return places[0] if places else None


def _stretches(path: Path, labels: list[str] | None) -> list[tuple[str, slice]]:
    """Name and rows of each run that the labels (n,) tell."""
    if labels is None:
        return [(str(path), slice(None))]
    texts = np.array(labels)
    edges = np.flatnonzero(texts[1:] != texts[:-1]) + 1
    starts, ends = np.append(0, edges), np.append(edges, len(texts))
    found = [str(texts[start]) for start in starts]
    for again in found:
        if found.count(again) > 1:
            raise InputError(
                f"{path}: the rows of run {again} do not stand together; sort them by runs"
            )
    return [
        (f"{path}, run {label}", slice(int(start), int(end)))
        for label, start, end in zip(found, starts, ends, strict=True)
    ]


def _cut(whole: RecordedRuns, rows: slice) -> RecordedRuns:
    reference = whole.reference
    if reference is not None:
        reference = reference[rows] if np.isfinite(reference[rows]).any() else None
    return replace(whole, time=whole.time[rows], raw=whole.raw[rows], reference=reference)


def _in_order(path: Path, name: str, run: RecordedRuns) -> tuple[RecordedRuns, list[str]]:
    """A stretch in the order of its time stamps, which are mended and keep varying."""
    n = len(run.time)
    if n < FEWEST_ROWS:
        raise InputError(f"{name}: {n} rows; a rest and a motion need {FEWEST_ROWS} at least")
    same = np.concatenate([[False], np.all(np.diff(run.raw, axis=0) == 0.0, axis=1)])
    clock = mend_clock(run.time, same)
    reason = unusable(clock)
    if not reason and np.any(np.diff(clock.stamps) < 0.0):
        row = int(clock.rows[int(np.argmax(np.diff(clock.stamps) < 0.0)) + 1])
        reason = f"the time stamps step back at {run.time[row]:.6g} s"
    if reason:
        raise InputError(f"{name}: {reason}; correct the stamps, or cut the file")
    reference = None if run.reference is None else _filled(clock.stamps, run.reference[clock.rows])
    ordered = replace(
        run, name=name, time=clock.stamps, raw=run.raw[clock.rows], reference=reference
    )
    where = "" if name == str(path) else f"{name}: "
    return ordered, [f"{where}{note}" for note in clock.notes]


def _filled(time: Array, values: Array) -> Array:
    """Values at all stamps: between those that are known they go straight."""
    known = np.isfinite(values)
    return np.interp(time, time[known], values[known])
