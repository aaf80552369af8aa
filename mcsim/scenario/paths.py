"""The dotted paths that a scenario has, with the kind of quantity at each."""

from __future__ import annotations

import types
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel

from mcsim.scenario.block import when_keys_change
from mcsim.scenario.document import PathKey, get_path
from mcsim.scenario.fields import Quantity
from mcsim.scenario.one_of import OneOf, one_of
from mcsim.scenario.sensor_block import N_AXES, OneOrThree
from mcsim.units import Kind

#: Blocks and keys that describe the run, not the simulated system.
NOT_SWEPT = ("case", "title", "outputs", "figure", "sweep")
#: Blocks that may be swept as a whole, by the names of sensors.
SENSORS = ("sensors.accelerometer", "sensors.gyroscope", "sensor.accelerometer")


@dataclass(frozen=True)
class Scalar:
    """A scalar of a scenario: its kind if it is a quantity, its choices if it has some."""

    path: str
    kind: Kind | None
    choices: tuple[Any, ...] = ()


def split_path(path: str) -> PathKey:
    """``trajectory.points.1.0`` to keys; digits index lists."""
    return tuple(
        int(key) if key.isascii() and key.isdigit() and str(int(key)) == key else key
        for key in path.split(".")
    )


def scalars(model: type[BaseModel]) -> dict[str, Scalar]:
    """All scalar paths of a model; list indices are written ``*``."""
    return _scalars(model, OneOf.known())


@cache
def _scalars(model: type[BaseModel], _: tuple[str, ...]) -> dict[str, Scalar]:
    """The paths, as long as the parts that blocks belong to are these."""
    return {scalar.path: scalar for scalar in _walk(model, "")}


when_keys_change(_scalars.cache_clear)


def find_scalar(model: type[BaseModel], path: str) -> Scalar | None:
    """The scalar at a path as a user writes it."""
    pattern = ".".join("*" if isinstance(key, int) else key for key in split_path(path))
    return scalars(model).get(pattern)


def writable(model: type[BaseModel]) -> list[str]:
    """The scalar paths as a user may write them, for suggestions."""
    known = scalars(model)
    # A quantity of all axes is offered as a whole.
    return [p.replace("*", "0") for p in known if p.removesuffix(".*") not in known or p[-1] != "*"]


def axis_advice(model: type[BaseModel], tree: Any, path: str) -> str | None:
    """What to write instead of a path below a quantity of all axes, if it is wrong.

    ``turn_on_bias.0`` to ``.2`` exist where the tree has a list [x, y, z]; nothing else does.
    """
    known = scalars(model)
    whole, _, last = path.rpartition(".")
    if whole not in known or f"{whole}.*" not in known:
        return None
    axes = [str(axis) for axis in range(N_AXES)]
    given = get_path(tree, split_path(whole))
    has_list = isinstance(given, list) and len(given) == N_AXES
    if last in axes and has_list:
        return None
    key = whole.rpartition(".")[2]
    by_axis = f"`{whole}.0` to `.2` for x, y and z"
    if not has_list:
        by_axis += f", after writing a list `{key}: [x, y, z]` in the scenario"
    return f"there is no `{path}`: write `{whole}` for all axes, or {by_axis}"


def _walk(annotation: Any, path: str, metadata: tuple[Any, ...] = ()) -> Iterator[Scalar]:
    origin = get_origin(annotation)
    if origin is Annotated:
        inner, *extra = get_args(annotation)
        yield from _walk(inner, path, (*extra, *metadata))
    elif (mark := one_of(metadata)) is not None:
        for block in mark.blocks:
            yield from _walk(block, path)
    elif origin in (Union, types.UnionType):
        # `X | None` is an optional X.
        for member in get_args(annotation):
            if member is not type(None):
                yield from _walk(member, path, metadata)
    elif origin is tuple:
        if any(isinstance(m, OneOrThree) for m in metadata):
            # One quantity may stand for all axes.
            yield from _walk(get_args(annotation)[0], path)
        yield from _walk(get_args(annotation)[0], f"{path}.*")
    elif origin is Literal:
        yield Scalar(path, None, get_args(annotation))
    elif isinstance(annotation, type) and issubclass(annotation, BaseModel):
        if path in SENSORS:
            yield Scalar(path, None)
        for name, field in annotation.model_fields.items():
            if path == "" and name in NOT_SWEPT:
                continue
            below = f"{path}.{name}" if path else name
            yield from _walk(field.annotation, below, tuple(field.metadata))
    else:
        quantity = next((m for m in metadata if isinstance(m, Quantity)), None)
        yield Scalar(path, quantity.details if quantity else None)
