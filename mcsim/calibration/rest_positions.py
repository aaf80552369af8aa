"""Positions at rest from a file: a table of them, or the rests of one continuous log."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.calibration.columns import read_columns
from mcsim.calibration.norm import AXES, RestPositions
from mcsim.errors import InputError
from mcsim.logs import ReadOptions, read_log
from mcsim.logs.model import ACCELEROMETER
from mcsim.units import STANDARD_GRAVITY

Array = NDArray[np.float64]

#: Outputs beyond these are no fractions of g.
_LARGEST_OUTPUT = 3.0
#: Windows that tell rest from motion: seconds, and the fewest samples.
_WINDOW, _FEWEST = 0.5, 8
#: The quietest part of the windows is noise alone; a window at rest is at most so much louder.
_QUIETEST, _LOUDER = 0.1, 2.5
#: The halves of a window at rest, and neighbouring windows, differ by at most so many deviations.
_APART = 5.0
#: Norms of means that cannot be gravity's.
_NO_GRAVITY = (0.5, 1.5)
#: What a log without a rest that is long enough may try.
_ADVICE = "leave the sensor alone for some seconds in each position, or lower --rest"


def read_positions(path: Path, tell: Callable[[str], None] | None = None) -> RestPositions:
    """A table with the columns ``x, y, z`` in g (or their unit), and perhaps ``position``.

    Without ``position`` each row is one; with it neighbouring rows of one name are samples in the
    order of time.

    Raises
    ------
    InputError
        Columns missing, or values that are no fractions of g.
    """
    table = read_columns(path, tuple(AXES), (), ("position",), tell)
    outputs = np.column_stack([table.outputs[axis] for axis in AXES])
    largest = np.abs(outputs).max(axis=1)
    if np.any(largest > _LARGEST_OUTPUT):
        row = int(np.argmax(largest > _LARGEST_OUTPUT))
        raise InputError(
            f"{table.where(row)}: {largest[row]:g} is no fraction of g at rest; write the unit "
            "into the header, such as x [m/s^2], x [mg] or x [16384 counts/g]"
        )
    names = table.texts.get("position", [str(k + 1) for k in range(len(outputs))])
    groups = [list(rows) for _, rows in groupby(range(len(names)), key=lambda row: names[row])]
    positions = RestPositions.of_samples(
        [outputs[g] for g in groups], [names[g[0]] for g in groups]
    )
    _check_gravity(path, positions)
    return positions


def find_rests(
    path: Path,
    shortest: float,
    options: ReadOptions | None = None,
    tell: Callable[[str], None] | None = None,
) -> RestPositions:
    """The rests of at least ``shortest`` s in one log of an accelerometer that is turned about.

    The log is cut into windows of half a second.  The quietest tenth of them tells the noise;
    a window is at rest whose deviation is at most 2.5 times that, and whose halves agree within
    five deviations of their difference.  Neighbouring windows at rest that agree as well are one
    rest, of which the first and the last window are left out.

    Raises
    ------
    InputError
        A log that cannot be read, lacks an axis, or has no such rest.
    """
    log = read_log(path, options, at_rest=False)
    axes = {c.axis: c.samples for c in log.channels if c.element == ACCELEROMETER}
    missing = [axis for axis in AXES if axis not in axes]
    if missing:
        raise InputError(f"{path}: accel_{missing[0]} is missing; three axes are needed")
    outputs = np.column_stack([axes[axis] for axis in AXES]) / STANDARD_GRAVITY
    found = rests(outputs, log.rate, shortest)
    if tell is not None:
        for note in (*log.remarks, *log.notes, _told(found, log.rate, shortest)):
            tell(note)
    if not found:
        raise InputError(f"{path}: no rest of {shortest:g} s or more: {_ADVICE}")
    names = [f"rest at {begin / log.rate:.1f} s" for begin, _ in found]
    positions = RestPositions.of_samples([outputs[slice(*rest)] for rest in found], names)
    _check_gravity(path, positions)
    return positions


def rests(outputs: Array, rate: float, shortest: float) -> list[tuple[int, int]]:
    """First sample, and the one after the last, of every rest in outputs (n, 3)."""
    size = max(_FEWEST, round(_WINDOW * rate))
    count = len(outputs) // size
    if count < 3:
        return []
    windows = outputs[: count * size].reshape(count, size, 3)
    means, variances = windows.mean(axis=1), windows.var(axis=1)
    order = np.argsort(variances.sum(axis=1))[: max(1, int(_QUIETEST * count))]
    noise = variances[order].mean(axis=0) + 1e-30
    quiet = np.all(variances <= _LOUDER**2 * noise, axis=1)
    half = size // 2
    turned = windows[:, :half].mean(axis=1) - windows[:, -half:].mean(axis=1)
    quiet &= np.all(np.abs(turned) <= _APART * np.sqrt(2.0 * noise / half), axis=1)
    same = np.all(np.abs(np.diff(means, axis=0)) <= _APART * np.sqrt(2.0 * noise / size), axis=1)
    return _joined(quiet, same, size, round(shortest * rate))


def _joined(
    quiet: NDArray[np.bool_], same: NDArray[np.bool_], size: int, shortest: int
) -> list[tuple[int, int]]:
    """Runs of quiet windows whose neighbours are the same, without their ends."""
    found, begin = [], 0
    for k in range(1, len(quiet) + 1):
        if k < len(quiet) and quiet[k] and quiet[k - 1] and same[k - 1]:
            continue
        first, last = (begin + 1) * size, (k - 1) * size
        if quiet[begin] and last - first >= max(shortest, size):
            found.append((first, last))
        begin = k
    return found


def _told(found: list[tuple[int, int]], rate: float, shortest: float) -> str:
    lengths = [(end - begin) / rate for begin, end in found] or [0.0]
    return (
        f"{len(found)} rests of {shortest:g} s or more, {min(lengths):.3g} to {max(lengths):.3g} s "
        "long without their first and last half second"
    )


def _check_gravity(path: Path, positions: RestPositions) -> None:
    norms = np.linalg.norm(positions.means, axis=1)
    wrong = (norms < _NO_GRAVITY[0]) | (norms > _NO_GRAVITY[1])
    if np.any(wrong):
        k = int(np.argmax(wrong))
        raise InputError(
            f"{path}: position {positions.names[k]} has the norm {norms[k]:.3g} g, where a sensor "
            "at rest feels 1 g: is its unit right, and does it lie still?"
        )
