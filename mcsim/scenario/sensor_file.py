"""Sensor files: what ``mcsim characterise`` and ``mcsim convert`` write, or a user does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, ConfigDict, model_validator

from mcsim import catalogue
from mcsim.catalogue import ELEMENTS, ORIGINS
from mcsim.errors import InputError
from mcsim.scenario.block import Block
from mcsim.scenario.document import SENSOR, Document, parse_document, read_text
from mcsim.scenario.fields import Frequency, Positive, reject
from mcsim.scenario.sensor_block import AccelerometerErrors, GyroscopeErrors, filled, named
from mcsim.scenario.validation import validate

AXES = ("x", "y", "z")
#: What an element's block holds beside its errors.
_BESIDE = ("rate", "axes", *ORIGINS)


def _of_one_axis(block: Any) -> Any:
    """Within ``axes`` every quantity is that of one axis."""
    if not isinstance(block, dict):
        return block
    for key, value in block.items():
        if key in ("model", "spikes"):
            raise reject(f"`{key}` counts for all axes; write it beside `axes`")
        inner = value.values() if isinstance(value, dict) else (value,)
        if any(isinstance(item, list) for item in inner):
            raise reject(f"`{key}`: write one value here; a list [x, y, z] stands beside `axes`")
    return block


_OneAxis = BeforeValidator(_of_one_axis)


class AccelerometerAxes(Block):
    """What each axis has of its own."""

    x: Annotated[AccelerometerErrors, _OneAxis] | None = None
    y: Annotated[AccelerometerErrors, _OneAxis] | None = None
    z: Annotated[AccelerometerErrors, _OneAxis] | None = None


class GyroscopeAxes(Block):
    """What each axis has of its own."""

    x: Annotated[GyroscopeErrors, _OneAxis] | None = None
    y: Annotated[GyroscopeErrors, _OneAxis] | None = None
    z: Annotated[GyroscopeErrors, _OneAxis] | None = None


class AccelerometerOfFile(AccelerometerErrors):
    """An accelerometer, and what a file may say beside its errors."""

    model_config = ConfigDict(use_attribute_docstrings=True)
    rate: Annotated[Frequency, Positive] | None = None
    """Rate of the log or of the parameters."""
    axes: AccelerometerAxes | None = None
    """Values per axis; what all three have takes the place of the value for all."""
    data_sheet: Any = None
    measured: Any = None

    @model_validator(mode="after")
    def _no_axis_alone(self) -> AccelerometerOfFile:
        _refuse_axes_alone(self, self.axes)
        return self


class GyroscopeOfFile(GyroscopeErrors):
    """A gyroscope, and what a file may say beside its errors."""

    model_config = ConfigDict(use_attribute_docstrings=True)
    rate: Annotated[Frequency, Positive] | None = None
    """Rate of the log or of the parameters."""
    axes: GyroscopeAxes | None = None
    """Values per axis; what all three have takes the place of the value for all."""
    data_sheet: Any = None
    measured: Any = None

    @model_validator(mode="after")
    def _no_axis_alone(self) -> GyroscopeOfFile:
        _refuse_axes_alone(self, self.axes)
        return self


def _refuse_axes_alone(block: Block, axes: Block | None) -> None:
    """A quantity of some axes says nothing of the others, unless there is one for all."""
    if axes is None:
        return
    of_axes = {axis: getattr(axes, axis) for axis in AXES}
    for key in type(block).model_fields:
        has = [axis for axis, own in of_axes.items() if getattr(own, key, None) is not None]
        if 0 < len(has) < len(AXES) and getattr(block, key) is None:
            raise reject(
                f"axes: `{key}` is written for {' and '.join(has)} only; write it for x, y and z, "
                "or one value for all beside `axes`"
            )


def _no_further_file(path: Path, _: str) -> Mapping[str, Any]:
    raise InputError(
        f"a sensor file cannot name another one ({path.name}); "
        "write its values here, or a built-in sensor's name"
    )


class SensorFile(Block):
    """A sensor file: one or both elements, and what is said about them."""

    name: str | None = None
    rate: Annotated[Frequency, Positive] | None = None
    """Output rate."""
    description: Any = None
    origin: Any = None
    source: Any = None
    fit: Any = None
    accelerometer: (
        Annotated[AccelerometerOfFile, named("accelerometer", _no_further_file)] | None
    ) = None
    gyroscope: Annotated[GyroscopeOfFile, named("gyroscope", _no_further_file)] | None = None

    @model_validator(mode="after")
    def _something(self) -> SensorFile:
        if self.accelerometer is None and self.gyroscope is None:
            raise reject(
                "describes no sensor: write an `accelerometer:` or a `gyroscope:` block, "
                "or a built-in sensor's name in its place"
            )
        return self


def parse_sensor_file(text: str, source: str) -> Document:
    """A valid sensor file whose elements hold errors only; their axes have become lists.

    Raises
    ------
    InputError
        Not such a file; one line per problem, with the place in the file.
    """
    return _checked(parse_document(text, source, SENSOR))


def _checked(document: Document) -> Document:
    validate(document, SensorFile)
    elements = {e: _errors(document.tree[e], e) for e in ELEMENTS if document.tree.get(e)}
    bare = replace(document, tree={**document.tree, **elements})
    validate(bare, SensorFile)  # what the axes say may contradict what stands beside them
    return bare


def file_element(path: Path, element: str) -> Mapping[str, Any]:
    """The quantities, as text, that a scenario takes from one element of a sensor file.

    Raises
    ------
    InputError
        Not such a file, or no such element in it.
    """
    tree = _tree(read_text(path, SENSOR), str(path))
    if tree.get(element) is None:
        raise InputError(f"{path}: has no {element}")
    quantities: Mapping[str, Any] = tree[element]
    return quantities


def built_in_of_file(path: Path, element: str) -> catalogue.Sensor | None:
    """The built-in sensor that an element of a sensor file is made from, if it says so.

    It is the element's name or `model`, or the `name` of a file that `mcsim convert` wrote.
    """
    named = _written(read_text(path, SENSOR), str(path), element)
    return next((s for s in map(catalogue.known, named) if s and element in s.elements), None)


@lru_cache(64)
def _written(text: str, source: str, element: str) -> tuple[str, ...]:
    """The names that stand in an element's block and above it."""
    tree = parse_document(text, source, SENSOR).tree
    block = tree.get(element)
    own = block.get("model") if isinstance(block, dict) else block
    return tuple(name for name in (own, tree.get("name")) if isinstance(name, str))


@lru_cache(64)  # every point of a sweep reads the file anew
def _tree(text: str, source: str) -> Mapping[str, Any]:
    return parse_sensor_file(text, source).tree


def _errors(block: Any, element: str) -> dict[str, Any]:
    """The errors of an element's block: no names, no remarks, lists in place of axes."""
    written = _spread({"model": block} if isinstance(block, str) else block)
    complete = filled(written, element, Path(), _no_further_file)
    return {key: value for key, value in complete.items() if key != "model"}


def _spread(block: Mapping[str, Any]) -> dict[str, Any]:
    """What all three axes have becomes a list [x, y, z]."""
    axes = block.get("axes") or {}
    of_axes = [axes.get(axis) or {} for axis in AXES]
    keys = dict.fromkeys([*block, *(key for own in of_axes for key in own)])
    spread = {
        key: _per_axis([own.get(key) for own in of_axes], block.get(key))
        for key in keys
        if key not in _BESIDE
    }
    # The value for all may be that of the sensor which the block names.
    return {key: value for key, value in spread.items() if value is not None}


def _per_axis(values: list[Any], whole: Any) -> Any:
    """The axes' values as a list, or ``whole`` where they do not all have one."""
    if any(value is None for value in values):
        return whole
    if all(isinstance(value, dict) for value in values):
        shared = whole if isinstance(whole, dict) else {}
        keys = dict.fromkeys(key for value in values for key in value)
        return {key: _per_axis([v.get(key) for v in values], shared.get(key)) for key in keys}
    return values
