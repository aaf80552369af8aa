"""Densities and Allan curves from tables of two columns, with units and conventions."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError, UnitError
from mcsim.logs.column_file import ColumnFile
from mcsim.logs.csv_file import open_csv
from mcsim.logs.model import ACCELEROMETER, GYROSCOPE, KIND, SHORT
from mcsim.units import KINDS, canonical_unit, factor

Array = NDArray[np.float64]

#: Kind of a root of a density, by element.
_ROOT = {ACCELEROMETER: "acceleration noise density", GYROSCOPE: "angular rate noise density"}
#: ``(m/s²)²/Hz``, ``g^2/Hz``; what people write for the first without brackets.
_SQUARED = re.compile(r"\(?(?P<unit>[^()²^]+(?:[²^]2?)?)\)?(?:²|\^2)/Hz")
_SPELLED = {
    "m²/s⁴/Hz": "(m/s²)²/Hz",
    "m^2/s^4/Hz": "(m/s²)²/Hz",
    "m²/s³": "(m/s²)²/Hz",
    "rad²/s²/Hz": "(rad/s)²/Hz",
    "rad^2/s^2/Hz": "(rad/s)²/Hz",
}
#: Titles, in small letters, of what the tables hold.
_FREQUENCY, _TAU = ("frequency", "freq", "f"), ("tau", "τ", "cluster time", "t")
_DENSITY = re.compile(r"psd|asd|density|spectrum", re.I)
_DEVIATION = re.compile(r"adev|allan|deviation", re.I)
_SIDES = re.compile(r"(one|two|single|double)[-_ ]?sided", re.I)
_CHANNEL = re.compile(r"(accel|gyro)_[xyz]")
_FEWEST = 3


@dataclass(frozen=True)
class DensityTable:
    """``frequency`` (k,) in Hz, ``density`` (k,) two-sided in the SI unit squared per Hz.

    ``name`` is the column or channel, ``notes`` say how it was read.
    """

    element: str
    name: str
    frequency: Array
    density: Array
    notes: tuple[str, ...]


@dataclass(frozen=True)
class CurveTable:
    """``tau`` (k,) in s, ``deviation`` (k,) in SI units, ``spread`` (k,) its relative
    error or None.
    """

    element: str
    name: str
    tau: Array
    deviation: Array
    spread: Array | None


def read_density(
    path: Path, sides: str | None = None, column: str | None = None, channel: str | None = None
) -> DensityTable:
    """A table of frequency and density; ``psd.csv`` of ``mcsim characterise`` is one.

    The header names both, with units: ``frequency [Hz], one-sided density [(m/s²)²/Hz]``; a root
    of a density (``µg/√Hz``) is squared.

    Raises
    ------
    InputError
        No such columns, a unit or convention that nothing says, values that are not above zero or
        frequencies that do not ascend.
    """
    file = open_csv(path)
    at = _place(file, _DENSITY, "a density", column)
    rows, name, element = _rows(file, channel)
    kind, scale, root = _density_unit(file, at, element)
    frequency, first = _first(file, _FREQUENCY, "a frequency", "frequency", rows)
    values = _numbers(file, at)[rows] * scale
    keep = frequency > 0.0
    notes = [] if keep.all() else ["the row at 0 Hz, the mean, is left out"]
    frequency, values, lines = frequency[keep], values[keep], first[keep]
    _refuse(file, lines, frequency, "frequencies must ascend", np.diff(frequency, prepend=0) > 0)
    _refuse(file, lines, values, "a density is above zero", values > 0)
    if len(frequency) < _FEWEST:
        raise InputError(f"{path}: {len(frequency)} frequencies; at least {_FEWEST} are needed")
    density = values**2 if root else values
    one = _is_one_sided(file, at, sides)
    notes.append(
        f"{file.title(at)}: {'one' if one else 'two'}-sided"
        + (", a root, squared" if root else "")
        + ("; halved for Eq. (3.12), which has it two-sided" if one else "")
    )
    return DensityTable(
        kind, name or file.title(at), frequency, 0.5 * density if one else density, tuple(notes)
    )


def read_curve(path: Path, column: str | None = None, channel: str | None = None) -> CurveTable:
    """A table of cluster time and Allan deviation; ``allan.csv`` of ``mcsim characterise`` is one.

    Raises
    ------
    InputError
        As ``read_density``.
    """
    file = open_csv(path)
    at = _place(file, _DEVIATION, "an Allan deviation", column)
    rows, name, element = _rows(file, channel)
    kind, scale = _sample_unit(file, at, element)
    tau, lines = _first(file, _TAU, "a cluster time", "time", rows)
    deviation = _numbers(file, at)[rows] * scale
    _refuse(file, lines, tau, "cluster times must ascend", np.diff(tau, prepend=0.0) > 0.0)
    _refuse(file, lines, deviation, "an Allan deviation is above zero", deviation > 0.0)
    return CurveTable(kind, name or file.title(at), tau, deviation, _spread(file, rows))


def _spread(file: ColumnFile, rows: NDArray[np.int64]) -> Array | None:
    """Relative errors from the interval of ``allan.csv``: a quarter of its width in logarithms."""
    low, high = file.place_of("ci_low"), file.place_of("ci_high")
    if low is None or high is None:
        return None
    return np.asarray(0.25 * np.log(_numbers(file, high)[rows] / _numbers(file, low)[rows]))


def _place(file: ColumnFile, pattern: re.Pattern[str], what: str, column: str | None) -> int:
    if column is not None:
        at = file.place_of(column)
        if at is None:
            raise InputError(f'{file.path}: no column "{column}"')
        return at
    found = [i for i, title in enumerate(file.titles or ()) if pattern.search(title.text)]
    if len(found) == 1:
        return found[0]
    if not found:
        raise InputError(f"{file.path}: no title names {what}; say which with --column")
    names = ", ".join(file.title(i) for i in found)
    raise InputError(f"{file.path}: several columns may be {what} ({names}); give --column")


def _rows(file: ColumnFile, channel: str | None) -> tuple[NDArray[np.int64], str, str | None]:
    """Rows of one channel, its name, and its element where the name says it."""
    at = file.place_of("channel")
    if at is None:
        if channel is not None:
            raise InputError(f'{file.path}: has no column "channel" to choose {channel} from')
        count = len(next(iter(file.numbers([0]).values())))
        return np.arange(count), "", None
    names = np.array(file.texts(at))
    known = list(dict.fromkeys(names.tolist()))
    if channel is None and len(known) > 1:
        raise InputError(f"{file.path}: holds {', '.join(known)}; choose one with --channel")
    chosen = channel or known[0]
    if chosen not in known:
        raise InputError(f'{file.path}: no channel "{chosen}" (it holds {", ".join(known)})')
    element = None
    if _CHANNEL.fullmatch(chosen):
        element = next(e for e, short in SHORT.items() if chosen.startswith(short))
    return np.flatnonzero(names == chosen), chosen, element


def _numbers(file: ColumnFile, place: int) -> Array:
    return np.asarray(file.numbers([place])[place], float)


def _first(
    file: ColumnFile, names: tuple[str, ...], what: str, kind: str, rows: NDArray[np.int64]
) -> tuple[Array, NDArray[np.int64]]:
    """The column of the abscissa in SI units, and the rows of the file."""
    titles = file.titles or ()
    suffix = {"frequency": "_hz", "time": "_s"}[kind]
    for i, title in enumerate(titles):
        name = title.name.casefold()
        bare = name.removesuffix(suffix)
        if bare in names:
            unit = title.unit or ("Hz" if kind == "frequency" else "s") * name.endswith(suffix)
            if not unit:
                raise InputError(
                    f"{file.path}:{file.header}: {title.text} has no unit; write "
                    f"{title.text} [{'Hz' if kind == 'frequency' else 's'}]"
                )
            return _numbers(file, i)[rows] * _factor(file, unit, kind), rows
    raise InputError(f"{file.path}:{max(file.header, 1)}: no column is {what} ({names[0]} [unit])")


def _factor(file: ColumnFile, unit: str, kind: str) -> float:
    try:
        return factor(unit, KINDS[kind])
    except UnitError as error:
        raise InputError(f"{file.path}:{file.header}: {error}") from None


def _density_unit(file: ColumnFile, at: int, element: str | None) -> tuple[str, float, bool]:
    """Element, SI value of one unit, and whether it is a root."""
    unit = file.unit(at)
    if not unit and element is not None:
        return element, 1.0, False
    for kind, name in _ROOT.items():
        if canonical_unit(unit) in KINDS[name].factors:
            return kind, factor(unit, KINDS[name]), True
    squared = _SQUARED.fullmatch(_SPELLED.get(unit.replace(" ", ""), unit.replace(" ", "")))
    for kind, name in KIND.items():
        if squared is not None and canonical_unit(squared["unit"]) in KINDS[name].factors:
            return kind, factor(squared["unit"], KINDS[name]) ** 2, False
    raise InputError(
        f'{file.path}:{max(file.header, 1)}: {file.title(at)}: "{unit}" is no unit of a density; '
        "write for example [(m/s²)²/Hz], [(°/s)²/Hz] or, for its root, [µg/√Hz]"
    )


def _sample_unit(file: ColumnFile, at: int, element: str | None) -> tuple[str, float]:
    unit = file.unit(at)
    if not unit and element is not None:
        return element, 1.0
    for kind, name in KIND.items():
        if canonical_unit(unit) in KINDS[name].factors:
            return kind, factor(unit, KINDS[name])
    raise InputError(
        f'{file.path}:{max(file.header, 1)}: {file.title(at)}: "{unit}" is no unit of an '
        "acceleration or an angular rate; write for example [m/s²] or [°/s]"
    )


def _is_one_sided(file: ColumnFile, at: int, sides: str | None) -> bool:
    stated = _SIDES.search((file.titles or ())[at].text)
    said = None
    if stated is not None:
        said = "one" if stated[1].lower() in ("one", "single") else "two"
    if said is not None and sides is not None and said != sides:
        raise InputError(f"{file.path}: {file.title(at)} says {said}-sided, --sides says {sides}")
    if said is None and sides is None:
        raise InputError(
            f"{file.path}: nothing says whether {file.title(at)} is one- or two-sided; give "
            "--sides one (as data sheets and Welch's estimate have it) or --sides two (as Eq. 3.12 "
            "has it)"
        )
    return (said or sides) == "one"


def _refuse(
    file: ColumnFile,
    rows: NDArray[np.int64],
    values: Array,
    words: str,
    good: NDArray[np.bool_],
) -> None:
    if not good.all():
        bad = int(np.argmin(good))
        raise InputError(f"{file.path}:{file.line(int(rows[bad]))}: {words} (here {values[bad]:g})")
