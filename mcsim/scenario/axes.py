"""Sweep axes: the values that one path of a scenario takes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, TypeAdapter, ValidationError

from mcsim.errors import InputError, UnitError
from mcsim.registry import suggest
from mcsim.scenario.document import Document, with_value
from mcsim.scenario.paths import (
    NOT_SWEPT,
    Scalar,
    axis_advice,
    find_scalar,
    split_path,
    writable,
)
from mcsim.scenario.run import Range
from mcsim.scenario.validation import describe
from mcsim.units import Kind, factor, in_unit, parse, parse_confidence, split

#: A sweep larger than this is a slip of the pen.
MOST_POINTS = 100_000
_DIGITS = 12

Value = float | int | str | bool


@dataclass(frozen=True)
class Axis:
    """One swept path: its values as written into points and as shown in tables.

    ``values`` are numbers in ``unit`` for quantities, plain values otherwise.
    """

    path: str
    unit: str | None
    kind: Kind | None
    values: tuple[Value, ...]
    log: bool = False

    @property
    def column(self) -> str:
        """Header of the table's column: the path, with the unit if there is one."""
        return f"{self.path} [{self.unit}]" if self.unit else self.path

    @property
    def numeric(self) -> bool:
        """Whether its values are numbers, which may stand along a scale."""
        return all(isinstance(v, int | float) and not isinstance(v, bool) for v in self.values)

    def written(self, value: Value) -> Value:
        """The value as a scenario file would hold it."""
        return f"{value:.{_DIGITS}g} {self.unit}" if self.unit else value

    def identity(self, value: Value) -> str:
        """What tells this coordinate from others, whatever unit it was written in."""
        if self.kind is None or self.unit is None:
            whole = isinstance(value, float) and value.is_integer()
            return f"{self.path}={int(value) if whole else value!r}"
        if self.kind.name == "confidence":
            return f"{self.path}={parse_confidence(str(self.written(value))):.{_DIGITS}g}"
        si = float(value) * factor(self.unit, self.kind)
        return f"{self.path}={si:.{_DIGITS}g}"


def read_axes(document: Document, model: type[BaseModel]) -> tuple[Axis, ...]:
    """The axes of a document's ``sweep`` block, in the order written.

    Raises
    ------
    InputError
        An unknown path, no values, values of the wrong kind, or too many points.
    """
    block = document.tree.get("sweep")
    if block is None:
        return ()
    if not isinstance(block, dict):
        raise InputError(
            f"{document.place(('sweep',))}: sweep: write `path: [value, value]` lines here"
        )
    axes = tuple(_read_axis(document, model, path, block[path]) for path in block)
    points = math.prod(len(axis.values) for axis in axes)
    if points > MOST_POINTS:
        raise InputError(
            f"{document.place(('sweep',))}: sweep: {points:,} points are more than "
            f"{MOST_POINTS:,}; use fewer values per axis"
        )
    for outer in axes:
        for inner in axes:
            if inner.path.startswith(outer.path + "."):
                raise InputError(
                    f"{document.place(('sweep', inner.path))}: sweep: `{outer.path}` and "
                    f"`{inner.path}` overlap; sweep one of them"
                )
    return axes


def _read_axis(document: Document, model: type[BaseModel], path: str, given: Any) -> Axis:
    place = f"{document.place(('sweep', path))}: sweep.{path}"
    advice = axis_advice(model, document.tree, path)
    if advice is not None:
        raise InputError(f"{place}: {advice}")
    scalar = find_scalar(model, path)
    if scalar is None:
        if path.split(".")[0] in NOT_SWEPT:
            raise InputError(f"{place}: `{path}` describes the run and cannot be swept")
        raise InputError(
            f"{place}: the scenario has no scalar of that name{suggest(path, writable(model))}"
        )
    _check_items(document, path, place)
    try:
        values = TypeAdapter(list[str | int | float | bool] | Range).validate_python(given)
    except ValidationError as error:
        if isinstance(given, dict):
            try:
                Range.model_validate(given)
            except ValidationError as inner:
                raise InputError(describe(inner, document, Range, ("sweep", path))) from None
        raise InputError(
            f"{place}: write a list of values, or {{from: …, to: …, points: …, scale: linear}}"
        ) from error
    try:
        if isinstance(values, Range):
            return _range_axis(scalar, path, values)
        return _list_axis(scalar, path, values)
    except (InputError, UnitError) as error:
        raise InputError(f"{place}: {error}") from None


def _check_items(document: Document, path: str, place: str) -> None:
    """The items of lists that a path names must be there."""
    keys = split_path(path)
    try:
        with_value(document.tree, keys, None)
    except InputError as error:
        raise InputError(f"{place}: {error}") from None


def _list_axis(scalar: Scalar, path: str, values: Sequence[Value]) -> Axis:
    if not values:
        raise InputError("the list of values is empty; write at least one value")
    if scalar.kind is None:
        plain: tuple[Value, ...] = tuple(values)
        axis = Axis(path, None, None, plain)
    else:
        unit = _unit_of(values[0], scalar.kind)
        axis = Axis(
            path, unit, scalar.kind, tuple(_number(value, scalar.kind, unit) for value in values)
        )
    if len({axis.identity(value) for value in axis.values}) < len(axis.values):
        raise InputError("a value occurs twice; each point must be distinct")
    return axis


def _range_axis(scalar: Scalar, path: str, given: Range) -> Axis:
    if scalar.kind is None:
        if not isinstance(given.from_, int | float) or not isinstance(given.to, int | float):
            raise InputError("a range needs numbers; write a list of values instead")
        first, last, unit = float(given.from_), float(given.to), None
    else:
        unit = _unit_of(given.from_, scalar.kind)
        first = _number(given.from_, scalar.kind, unit)
        last = _number(given.to, scalar.kind, unit)
    if first == last:
        raise InputError("`from` and `to` are equal; write a list with one value instead")
    steps = given.points - 1
    if given.scale == "log":
        if first <= 0.0 or last <= 0.0:
            raise InputError("a log scale needs `from` and `to` above zero")
        raw = [first * (last / first) ** (i / steps) for i in range(given.points)]
    else:
        raw = [first + (last - first) * i / steps for i in range(given.points)]
    raw[-1] = last
    numbers = tuple(float(f"{value:.{_DIGITS}g}") for value in raw)
    if unit is None and isinstance(given.from_, int) and isinstance(given.to, int):
        numbers = tuple(round(value) for value in numbers)
    if len(set(numbers)) < len(numbers):
        raise InputError("the values of the range coincide; use fewer points")
    return Axis(path, unit, scalar.kind, numbers, log=given.scale == "log")


def _unit_of(value: Value, kind: Kind) -> str:
    if isinstance(value, str):
        _si(value, kind)
        return split(value)[1]
    raise InputError(f'{value} has no unit; write for example "{value} {split(kind.example)[1]}"')


def _si(value: str, kind: Kind) -> float:
    return parse_confidence(value) if kind.name == "confidence" else parse(value, kind)


def _number(value: Value, kind: Kind, unit: str) -> float:
    if not isinstance(value, str):
        raise InputError(f'{value} has no unit; write "{value} {unit}"')
    _si(value, kind)
    number, own_unit = split(value)
    if own_unit == unit:
        return number
    if kind.name == "confidence":
        raise InputError("write all confidences in the same unit")
    return in_unit(parse(value, kind), unit, kind)
