"""From a plain tree to a validated model, with messages a user can act on."""

from __future__ import annotations

import types
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from mcsim.errors import InputError, UnitError
from mcsim.registry import suggest
from mcsim.scenario.document import Document, PathKey, get_path
from mcsim.scenario.fields import Quantity
from mcsim.scenario.one_of import one_of
from mcsim.scenario.sensor_block import OneOrThree
from mcsim.units import in_unit, split

#: Messages beyond this number help nobody.
_MOST = 10

Model = TypeVar("Model", bound=BaseModel)
#: From a pydantic location to the field there, and the models that may stand in it.
Field = Callable[[tuple[str | int, ...]], tuple[Any, list[Any]]]


def validate(document: Document, model: type[Model]) -> Model:
    """The validated model of a document's tree.

    Raises
    ------
    InputError
        One line per problem: place, field, what is wrong, what would be right.
    """
    try:
        return model.model_validate(document.tree, context={"folder": document.folder})
    except ValidationError as error:
        raise InputError(describe(error, document, model)) from None


def describe(
    error: ValidationError, document: Document, model: type[BaseModel], prefix: PathKey = ()
) -> str:
    """The problems of a failed validation, one per line."""
    messages: list[str] = []
    problems = error.errors()
    tree = get_path(document.tree, prefix)
    for details in problems:
        if details["type"] == "too_short" and _has_bad_items(details, problems):
            continue  # bad items are not counted; they have lines of their own
        path = (*prefix, *_plain_path(details["loc"], tree))
        line = f"{document.place(path)}: {'.'.join(map(str, path)) or 'scenario'}: "
        line += _explain(details, path, partial(_field, model=model, tree=tree))
        if line not in messages:
            messages.append(line)
    shown = messages[:_MOST]
    if len(messages) > _MOST:
        shown.append(f"… and {len(messages) - _MOST} more")
    return "\n".join(shown)


def _has_bad_items(details: ErrorDetails, problems: list[ErrorDetails]) -> bool:
    loc = details["loc"]
    return any(len(p["loc"]) > len(loc) and p["loc"][: len(loc)] == loc for p in problems)


def _plain_path(loc: tuple[str | int, ...], tree: Any) -> PathKey:
    """The location without the names of union members that pydantic puts into it."""
    path: list[str | int] = []
    for i, key in enumerate(loc):
        is_last = i == len(loc) - 1
        known = isinstance(tree, dict) and key in tree
        in_list = isinstance(tree, list | tuple) and isinstance(key, int)
        if known or in_list:
            path.append(key)
            tree = tree[key] if known or (in_list and int(key) < len(tree)) else None
        elif is_last and isinstance(tree, dict):
            path.append("from" if key == "from_" else key)
    return tuple(path)


def _explain(details: ErrorDetails, path: PathKey, field: Field) -> str:
    kind = details["type"]
    context = details.get("ctx", {})
    given = details["input"]
    name = str(path[-1]) if path else ""
    if kind == "mcsim":
        return str(context["message"])
    if kind == "missing":
        return "is missing" + _example(details, field)
    if kind == "extra_forbidden":
        known = _siblings(details["loc"], field)
        return f'unknown key "{name}"{suggest(name, known)} (known here: {", ".join(known)})'
    if kind == "literal_error":
        choices = str(context["expected"]).replace(" or ", ", ")
        words = [word.strip(" '\"") for word in choices.split(",")]
        return f'"{given}" is not one of {", ".join(words)}{suggest(str(given), words)}'
    bounds = {
        "greater_than": ("greater than", "gt"),
        "greater_than_equal": ("at least", "ge"),
        "less_than": ("less than", "lt"),
        "less_than_equal": ("at most", "le"),
    }
    if kind in bounds:
        words_, key = bounds[kind]
        return f'"{given}" must be {words_} {_bound(details, context[key], field)}'
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return f"a block of `key: value` lines is needed here, not {_show(given)}"
    if kind.startswith("int_"):
        return f"a whole number is needed here, not {_show(given)}"
    if kind.startswith("bool_"):
        return f"true or false is needed here, not {_show(given)}"
    if kind == "string_type":
        return f"text is needed here, not {_show(given)}"
    if kind in ("tuple_type", "list_type"):
        return f"a list is needed here, not {_show(given)}"
    if kind in ("too_short", "too_long"):
        wanted = context.get("min_length", context.get("max_length"))
        least = "at least" if kind == "too_short" else "at most"
        return f"{least} {wanted} items are needed, not {context.get('actual_length')}"
    return details["msg"]


def _show(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "…"


def _field(loc: tuple[str | int, ...], model: Any, tree: Any) -> tuple[Any, list[Any]]:
    """The field at a pydantic location, or None, and the models that may stand in it.

    ``tree`` is what is written: of several blocks it tells which is meant.
    """
    current = _models(model)
    found = None
    for key in loc:
        tree = _below(tree, key)
        for candidate in current:
            if key in candidate.model_fields:
                found = candidate.model_fields[str(key)]
                mark = one_of(found.metadata)
                current = list(mark.block_of(tree)) if mark else _models(found.annotation)
                break
    return found, current


def _models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if get_origin(annotation) is Annotated:
        return _models(get_args(annotation)[0])
    return [model for argument in get_args(annotation) for model in _models(argument)]


def _below(tree: Any, key: str | int) -> Any:
    """What is written at a key, or the tree itself where pydantic names a member of a union."""
    if isinstance(tree, dict) and key in tree:
        return tree[key]
    if isinstance(tree, list) and isinstance(key, int) and key < len(tree):
        return tree[key]
    return tree


def _siblings(loc: tuple[str | int, ...], field: Field) -> list[str]:
    _, current = field(loc[:-1])
    names: list[str] = []
    for candidate in current:
        names += [f.alias or n for n, f in candidate.model_fields.items()]
    if not loc[:-1] and "case" in names:
        names.append("sweep")
    return list(dict.fromkeys(names))


def _quantity(found: Any) -> Quantity | None:
    """The quantity that a field, its only alternative or its items hold."""
    if found is None:
        return None
    own = next((m for m in found.metadata if isinstance(m, Quantity)), None)
    return own or _quantity_within(found.annotation)


def _quantity_within(annotation: Any) -> Quantity | None:
    arguments = get_args(annotation)
    if get_origin(annotation) is Annotated:
        marks = [m for m in arguments[1:] if isinstance(m, Quantity)]
        return marks[0] if marks else _quantity_within(arguments[0])
    if get_origin(annotation) in (tuple, Union, types.UnionType):
        return next((q for q in map(_quantity_within, arguments) if q is not None), None)
    return None


def _example(details: ErrorDetails, field: Field) -> str:
    found, _ = field(details["loc"])
    quantity = _quantity(found)
    if quantity is not None and (_is_scalar(found) or _is_per_axis(found)):
        return f"; write for example `{details['loc'][-1]}: {quantity.details.example}`"
    return ""


def _is_scalar(found: Any) -> bool:
    return get_origin(found.annotation) is not tuple


def _is_per_axis(found: Any) -> bool:
    return any(isinstance(m, OneOrThree) for m in found.metadata)


def _bound(details: ErrorDetails, bound: Any, field: Field) -> str:
    found, _ = field(details["loc"])
    quantity = _quantity(found)
    if quantity is not None and quantity.kind == "ratio":
        return f"{100.0 * bound:g} %"
    if quantity is None or quantity.kind == "confidence":
        return f"{bound:g}" if isinstance(bound, float) else str(bound)
    try:
        # In the unit that the user has written.
        _, unit = split(str(details["input"]))
        return f"{in_unit(bound, unit, quantity.details):.6g} {unit}"
    except UnitError:
        return f"{bound:g} {quantity.details.si_unit}"
