"""Python text: a dictionary literal and the plain arithmetic in it, read without running it."""

from __future__ import annotations

import ast
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from mcsim.dialects.arithmetic import CONSTANTS, NotPlain, Value, call, combine
from mcsim.errors import InputError

_SIGNS: Mapping[type[ast.operator], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Pow: "^",
}
_MODULES = ("np", "numpy", "math")
_DEEPEST = 50
_LONGEST_LIST = 9


@dataclass(frozen=True)
class Entry:
    """An item of a dictionary: where it stands, and its value when asked for."""

    place: str
    node: ast.expr
    names: Mapping[str, ast.expr | None]

    def value(self) -> Value:
        """The value of plain numbers, lists, ``np.array`` and arithmetic with them.

        Raises
        ------
        InputError
            Something else; the message names it.
        """
        try:
            return _array(_evaluate(self.node, self.names, 0))
        except NotPlain as error:
            raise InputError(
                f"{self.place}: only plain numbers, np.array and arithmetic with them are read, "
                f"not {error}"
            ) from None


def dictionary_with(text: str, source: str, key: str) -> dict[str, Entry]:
    """The one dictionary of a Python text that has ``key``, later items of it included.

    Raises
    ------
    InputError
        Not Python, none or several such dictionaries, or one that is put together in a way
        that is not seen from its text.
    """
    tree = _parsed(text, source)
    found = [(node, items) for node in ast.walk(tree) if key in (items := dict(_items(node)))]
    if not found:
        raise InputError(f"{source}: no dictionary with a `{key}` in it")
    if len(found) > 1:
        lines = ", ".join(str(getattr(node, "lineno", 1)) for node, _ in found)
        raise InputError(
            f"{source}: {len(found)} dictionaries with `{key}` (lines {lines}); keep one"
        )
    node, _ = found[0]
    _refuse_unseen(node, source)
    names = _names(tree)
    entries: dict[str, Entry] = {}
    for name, value in [*_items(node), *_later_items(tree, node, source)]:
        if name in entries and value.lineno <= _last_line(node):
            raise InputError(f"{source}:{value.lineno}: {name}: stands twice; keep one")
        entries[name] = Entry(f"{source}:{value.lineno}: {name}", value, names)
    return entries


def _parsed(text: str, source: str) -> ast.Module:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)
            return ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        line = getattr(error, "lineno", None)
        raise InputError(f"{source}:{line or 1}: not Python text") from None


def _items(node: ast.AST) -> Iterator[tuple[str, ast.expr]]:
    """Those of a dictionary, written in braces or as ``dict(…)``, that have plain names."""
    if isinstance(node, ast.Dict):
        for key, value in zip(node.keys, node.values, strict=True):
            if isinstance(key, ast.Constant):
                yield str(key.value), value
    elif isinstance(node, ast.Call) and _is_name(node.func, {"dict"}):
        for keyword in node.keywords:
            if keyword.arg is not None:
                yield keyword.arg, keyword.value


def _refuse_unseen(node: ast.AST, source: str) -> None:
    """Items whose names cannot be read from the text."""
    unseen: list[ast.expr] = []
    if isinstance(node, ast.Dict):
        for key, value in zip(node.keys, node.values, strict=True):
            unseen += [] if isinstance(key, ast.Constant) else [key or value]
    elif isinstance(node, ast.Call):
        unseen += [*node.args, *(k.value for k in node.keywords if k.arg is None)]
    for item in unseen:
        raise InputError(
            f"{source}:{item.lineno}: `{_shown(item)}`: an item without a plain name is not read"
        )


def _last_line(node: ast.AST) -> int:
    return getattr(node, "end_lineno", None) or 0


def _later_items(tree: ast.Module, node: ast.AST, source: str) -> Iterator[tuple[str, ast.expr]]:
    """``name['key'] = value`` in the same block as ``name = {…}``; other changes are refused."""
    home = next((a for a in ast.walk(tree) if isinstance(a, ast.Assign) and a.value is node), None)
    names = {t.id for t in home.targets if isinstance(t, ast.Name)} if home is not None else set()
    plain: dict[ast.AST, ast.Assign] = {
        a.targets[0]: a
        for a in ast.walk(tree)
        if isinstance(a, ast.Assign)
        and len(a.targets) == 1
        and home is not None
        and a.col_offset == home.col_offset
        and a.lineno > _last_line(home)
    }
    changes = [
        n for n in ast.walk(tree) if isinstance(n, ast.expr | ast.stmt) and _changes(n, names)
    ]
    for change in sorted(changes, key=lambda n: (n.lineno, n.col_offset)):
        if (
            change in plain
            and isinstance(change, ast.Subscript)
            and isinstance(change.slice, ast.Constant)
        ):
            yield str(change.slice.value), plain[change].value
        else:
            raise InputError(
                f"{source}:{change.lineno}: `{_shown(change)}`: this change of the dictionary "
                "is not read; write the value into it"
            )


def _changes(node: ast.AST, names: set[str]) -> bool:
    """Whether a node changes a dictionary of one of these names."""
    if isinstance(node, ast.Subscript):
        owner: ast.expr = node.value
        return not isinstance(node.ctx, ast.Load) and _is_name(owner, names)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        return node.func.attr in _CHANGING and _is_name(node.func.value, names)
    return isinstance(node, ast.AugAssign) and _is_name(node.target, names)


_CHANGING = ("update", "pop", "clear", "setdefault", "popitem")


def _is_name(node: ast.expr, names: set[str]) -> bool:
    return isinstance(node, ast.Name) and node.id in names


def _names(tree: ast.Module) -> dict[str, ast.expr | None]:
    """What names stand for; None for those that are set more than once or not by ``=``."""
    once = {
        a.targets[0].id: a.value
        for a in ast.walk(tree)
        if isinstance(a, ast.Assign) and len(a.targets) == 1 and isinstance(a.targets[0], ast.Name)
    }
    stored = [n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and _is_store(n)]
    stored += [n.arg for n in ast.walk(tree) if isinstance(n, ast.arg)]
    return {name: once.get(name) if stored.count(name) == 1 else None for name in set(stored)}


def _is_store(node: ast.Name) -> bool:
    return not isinstance(node.ctx, ast.Load)


def _evaluate(
    node: ast.expr, names: Mapping[str, ast.expr | None], depth: int
) -> Value | list[float]:
    """A list is what Python calls one: it becomes a vector by ``np.array``."""
    if depth > _DEEPEST:
        raise NotPlain("so deep a nesting")
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return _number(node.value)
    if isinstance(node, ast.List | ast.Tuple):
        return [_scalar(_evaluate(item, names, depth + 1)) for item in node.elts]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd | ast.USub):
        value = _vector(_evaluate(node.operand, names, depth + 1))
        return combine("*", -1.0 if isinstance(node.op, ast.USub) else 1.0, value)
    if isinstance(node, ast.BinOp) and type(node.op) in _SIGNS:
        return _combined(node, names, depth + 1)
    if isinstance(node, ast.Call) and not node.keywords:
        return _called(node, names, depth + 1)
    if isinstance(node, ast.Name | ast.Attribute):
        return _named(node, names, depth + 1)
    raise NotPlain(f"`{_shown(node)}`")


def _combined(
    node: ast.BinOp, names: Mapping[str, ast.expr | None], depth: int
) -> Value | list[float]:
    left, right = (_evaluate(side, names, depth) for side in (node.left, node.right))
    for items, count in ((left, node.right), (right, node.left)):
        if isinstance(items, list) and isinstance(node.op, ast.Mult):
            # A list times a whole number repeats it.
            if isinstance(count, ast.Constant) and type(count.value) is int:
                if not 1 <= len(items) * count.value <= _LONGEST_LIST:
                    raise NotPlain("so long a list")
                return items * count.value
            if isinstance(_evaluate(count, names, depth), tuple):
                continue
    if isinstance(left, tuple) or isinstance(right, tuple):
        left, right = _array(left), _array(right)
    return combine(_SIGNS[type(node.op)], _vector(left), _vector(right))


def _called(
    node: ast.Call, names: Mapping[str, ast.expr | None], depth: int
) -> Value | list[float]:
    name = _function(node.func)
    if name == "float" and len(node.args) == 1 and isinstance(node.args[0], ast.Constant):
        return _number(node.args[0].value)
    arguments = [_evaluate(item, names, depth) for item in node.args]
    if name in ("array", "asarray") and len(arguments) == 1:
        return _array(arguments[0])
    return call(name, [_array(item) for item in arguments])


def _function(node: ast.expr) -> str:
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute) and _is_name(node.value, set(_MODULES)):
        return node.attr
    raise NotPlain(f"`{_shown(node)}`")


def _named(
    node: ast.Name | ast.Attribute, names: Mapping[str, ast.expr | None], depth: int
) -> Value | list[float]:
    name = _function(node)
    if isinstance(node, ast.Name) and name in names:
        value = names[name]
        if value is None:
            raise NotPlain(f"`{name}`, which is not set once by a plain `{name} = …`")
        return _evaluate(value, names, depth)
    if name not in CONSTANTS:
        raise NotPlain(f"`{_shown(node)}`, which is not set in this file")
    return CONSTANTS[name]


def _number(value: object) -> float:
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise NotPlain(f"{str(value)[:20]!r}") from None


def _scalar(value: Value | list[float]) -> float:
    if not isinstance(value, float):
        raise NotPlain("a list within a list")
    return value


def _vector(value: Value | list[float]) -> Value:
    if isinstance(value, list):
        raise NotPlain("arithmetic with a list; write np.array([…])")
    return value


def _array(value: Value | list[float]) -> Value:
    return tuple(value) if isinstance(value, list) else value


def _shown(node: ast.AST) -> str:
    try:
        text = ast.unparse(node)
    except (ValueError, RecursionError):
        text = "…"
    return text if len(text) < 60 else text[:57] + "…"
