"""A field that holds the block of one of several parts, such as the shapes of a track."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar, Protocol, get_args

from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationError
from pydantic import ValidationInfo as Info
from pydantic_core import CoreSchema, PydanticKnownError, core_schema

from mcsim.errors import InputError
from mcsim.registry import Registry
from mcsim.scenario.block import Block
from mcsim.scenario.fields import reject


class BlockPart(Protocol):
    """A part that scenarios describe by a block."""

    @property
    def name(self) -> str:
        """What scenarios write after the key that names the part."""

    @property
    def block(self) -> type[Block]:
        """What else they write of it."""


class OneOf:
    """Marks a field that holds the block of one part of a list, named by the block's ``key``.

    The list is looked at when a scenario is read: what is added to it later may be written too.

    Parameters
    ----------
    parts : Registry
        The list; its parts have a ``block``, whose field ``key`` allows the part's name.
    key : str
        What names the part.
    default : str, optional
        The part where a block names none; without it each must name one.

    Raises
    ------
    InputError
        A block that does not allow its part's name, now or when the part is added.
    """

    _made: ClassVar[list[OneOf]] = []

    def __init__(
        self, parts: Registry[Any], key: str = "shape", default: str | None = None
    ) -> None:
        self.parts: Registry[Any] = parts
        self.key = key
        self.default = default
        for part in parts.values():
            self._check(part)
        parts.tell(self._check)
        self._made.append(self)

    @classmethod
    def known(cls) -> tuple[str, ...]:
        """All names that such fields may hold; what is derived from models holds for these."""
        return tuple(name for marker in cls._made for name in marker.parts)

    @property
    def blocks(self) -> tuple[type[Block], ...]:
        """The blocks, in the order of the list; several names may share one."""
        return tuple(dict.fromkeys(part.block for part in self.parts.values()))

    def block_of(self, tree: Any) -> tuple[type[Block], ...]:
        """The block that a tree as written names; all of them where it names none."""
        name = tree.get(self.key, self.default) if isinstance(tree, dict) else None
        if isinstance(name, str) and name in self.parts:
            return (self.parts[name].block,)
        return self.blocks

    def part_of(self, block: Block) -> Any:
        """The part that a block names."""
        return self.parts[getattr(block, self.key)]

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(self._read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        for block in self.blocks:
            block.model_rebuild()
        # As members of a union, blocks become references to definitions.
        union = core_schema.union_schema([b.__pydantic_core_schema__ for b in self.blocks])
        described = handler(union)
        return {"oneOf": described.get("anyOf", [described])}

    def _read(self, value: Any, info: Info) -> BaseModel:
        if isinstance(value, self.blocks):
            return value
        if not isinstance(value, dict):
            raise PydanticKnownError("dict_type")
        if self.key not in value and self.default is None:
            raise self._refused(value, self._missing())
        name = value.get(self.key, self.default)
        if not isinstance(name, str) or name not in self.parts:
            raise self._refused(value, self.parts.unknown(str(name)))
        block: type[Block] = self.parts[name].block
        return block.model_validate(value, context=info.context)

    def _missing(self) -> str:
        names = list(self.parts)
        return (
            f"`{self.key}` is missing; write for example `{self.key}: {names[0]}` "
            f"(known: {', '.join(names)})"
        )

    def _refused(self, value: Any, message: str) -> ValidationError:
        """An error at the key, not at the block."""
        return ValidationError.from_exception_data(
            self.parts.kind, [{"type": reject(message), "loc": (self.key,), "input": value}]
        )

    def _check(self, part: BlockPart) -> None:
        field = part.block.model_fields.get(self.key)
        if field is None or part.name not in get_args(field.annotation):
            raise InputError(
                f"{part.name}: its block {part.block.__name__} must say "
                f'`{self.key}: Literal["{part.name}"]`'
            )


def one_of(metadata: Iterable[Any]) -> OneOf | None:
    """The mark of a field that holds one of several blocks, if it has one."""
    return next((mark for mark in metadata if isinstance(mark, OneOf)), None)
