"""The base of all blocks of a scenario."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from pydantic import BaseModel, BeforeValidator, ConfigDict
from pydantic.fields import FieldInfo

from mcsim.scenario.fields import reject


class Block(BaseModel):
    """Base of all blocks (a pydantic model): unknown keys are errors, values never change.

    Fields are annotated with the types of ``mcsim.fields``: text with a unit outside, an SI float
    inside.  The string below a field is its description in the schema.
    """

    # Models are built when first used: a run uses those of one case.
    model_config = ConfigDict(
        extra="forbid", frozen=True, use_attribute_docstrings=True, defer_build=True
    )


_heard: list[Callable[[], object]] = []


def when_keys_change(hears: Callable[[], object]) -> None:
    """Call ``hears`` whenever a block gets further keys: for what remembers what blocks hold."""
    _heard.append(hears)


def add_keys(block: type[Block], keys: Mapping[str, tuple[Any, Any]]) -> None:
    """Give a block, and those that are made from it, further keys.

    ``keys`` are annotations and fields by name, as ``pydantic.create_model`` takes them.  Where
    blocks may be in use already, ``rebuild`` follows.
    """
    for model in _with_descendants(block):
        for name, (annotation, field) in keys.items():
            # What a subclass inherits it reads off the annotations.
            model.__annotations__[name] = annotation
            model.__pydantic_fields__[name] = FieldInfo.from_annotated_attribute(annotation, field)


def rebuild() -> None:
    """Build all models anew that have been built, after blocks have got further keys."""
    built = [model for model in _with_descendants(Block) if model.__pydantic_complete__]
    for model in built:
        # A model takes what its blocks have been built to.
        del model.__pydantic_core_schema__
    for model in built:
        model.model_rebuild(force=True)
    for hears in _heard:
        hears()


def _with_descendants(block: type[Block]) -> Iterator[type[Block]]:
    yield block
    for child in block.__subclasses__():
        yield from _with_descendants(child)


def _no_boolean(value: Any) -> Any:
    if isinstance(value, bool):
        raise reject(f"a whole number is needed here, not {str(value).lower()}")
    return value


Whole = BeforeValidator(_no_boolean)
