"""Reading a scenario's text: YAML 1.2 into a plain tree that knows its line numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from io import StringIO
from numbers import Integral
from pathlib import Path
from typing import Any

from mcsim.errors import InputError
from mcsim.files import read_text as read_bounded_text

PathKey = tuple[str | int, ...]

LARGEST_FILE = 1 << 18
LARGEST_TREE = 100_000
DEEPEST_TREE = 50
MOST_BRACKETS = 200
_MOST_DIGITS_READ = 4000
_ENDLESS = re.compile(rf"\d{{{_MOST_DIGITS_READ + 1}}}")
_BRACKETS = re.compile(r"[\[\]{}]")
#: A whole number of more digits is a slip, and one of thousands Python will not even print.
_MOST_DIGITS = 40


@dataclass(frozen=True)
class Genre:
    """What a file is, and what one begins with: words for messages."""

    name: str
    rule: str


SCENARIO = Genre("scenario", "begins with `case: planar`")
SENSOR = Genre("sensor", "has an `accelerometer:` or a `gyroscope:` block")


@dataclass(frozen=True)
class Document:
    """A tree of dicts, lists and scalars, and where each of them was written."""

    tree: dict[str, Any]
    source: str
    lines: Mapping[PathKey, int] = field(default_factory=dict)
    overrides: Mapping[PathKey, str] = field(default_factory=dict)
    #: What relative file names refer to.
    folder: Path = Path()

    def place(self, path: PathKey) -> str:
        """``file:line`` (or the option) that set the value at ``path``, or its parent."""
        for end in range(len(path), -1, -1):
            if path[:end] in self.overrides:
                return self.overrides[path[:end]]
            if path[:end] in self.lines:
                return f"{self.source}:{self.lines[path[:end]]}"
        return self.source


def read_document(path: Path) -> Document:
    """Read a scenario's YAML file.

    Raises
    ------
    InputError
        Not a readable UTF-8 file, not YAML, not a mapping, or absurdly large.
    """
    return parse_document(read_text(path), str(path))


def read_text(path: Path, genre: Genre = SCENARIO) -> str:
    """The text of a YAML file.

    Raises
    ------
    InputError
        Not a readable UTF-8 file, or absurdly large.
    """
    return read_bounded_text(path, LARGEST_FILE, f"{genre.name} file")


def parse_document(text: str, source: str = "scenario", genre: Genre = SCENARIO) -> Document:
    """Parse YAML text; ``source`` is what messages call it.

    Raises
    ------
    InputError
        Not YAML, not a mapping, or absurdly large.
    """
    root = _load_yaml(text, source)
    if root is None:
        raise InputError(f"{source}: is empty; a {genre.name} file {genre.rule}")
    if not isinstance(root, dict):
        raise InputError(f"{source}: no `key: value` lines; a {genre.name} file {genre.rule}")
    lines: dict[PathKey, int] = {}
    tree = _Plain(source, lines).convert(root, (), 1)
    return Document(tree, source, lines)


def parse_scalar(text: str, source: str) -> Any:
    """The value of an override: YAML, so ``200 Hz``, ``3``, ``[1 m, 2 m]`` all work."""
    return _Plain(source, {}).convert(_load_yaml(text, source), (), 1)


def plain_tree(tree: Any, source: str) -> Any:
    """A copy of nested containers of Python that holds what YAML may hold, and no more.

    Raises
    ------
    InputError
        Absurdly large, deep or long, or something else than plain texts and numbers.
    """
    return _Plain(source, {}).convert(tree, (), 1)


def _load_yaml(text: str, source: str) -> Any:
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError

    _refuse_brackets(text, source)
    _refuse_endless_numbers(text, source)
    try:
        return YAML(typ="rt", pure=True).load(StringIO(text))
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f"{source}:{mark.line + 1}" if mark is not None else source
        problem = (error.problem or error.context or "not YAML").split("\n")[0].strip()
        hint = ""
        if "'\\t'" in problem:
            problem, hint = "a tab where YAML wants blanks", "; indent with blanks"
        elif "duplicate key" in problem:
            hint = "; keep one of the two"
        raise InputError(f"{place}: {problem}{hint}") from None
    except Exception as error:  # what else a reader of strange text may raise
        first = (str(error) or type(error).__name__).split("\n")[0]
        raise InputError(f"{source}: not YAML ({first})") from None


def _refuse_endless_numbers(text: str, source: str) -> None:
    """Python reads no whole number of more digits than this, and says so to programmers."""
    match = _ENDLESS.search(text)
    if match is not None:
        line = text.count("\n", 0, match.start()) + 1
        raise InputError(f"{source}:{line}: a number of more than {_MOST_DIGITS_READ} digits")


def _refuse_brackets(text: str, source: str) -> None:
    """Brackets within brackets cost the reader the square of their number."""
    depth = 0
    for line, content in enumerate(text.splitlines(), 1):
        for sign in _BRACKETS.findall(content):
            depth = max(0, depth + (1 if sign in "[{" else -1))
            if depth > MOST_BRACKETS:
                raise InputError(
                    f"{source}:{line}: more than {MOST_BRACKETS} brackets are open; close them"
                )


class _Plain:
    """Turns the reader's node types into plain ones and notes their lines."""

    def __init__(self, source: str, lines: dict[PathKey, int]) -> None:
        self.source = source
        self.lines = lines
        self.nodes = 0

    def convert(self, node: Any, path: PathKey, line: int) -> Any:
        self.nodes += 1
        if self.nodes > LARGEST_TREE or len(path) > DEEPEST_TREE:
            raise InputError(
                f"{self.source}: expands to more than {LARGEST_TREE} values or "
                f"{DEEPEST_TREE} levels (check its anchors and aliases)"
            )
        self.lines[path] = line
        if isinstance(node, dict):
            return self._mapping(node, path, line)
        if isinstance(node, list | tuple):
            return [
                self.convert(item, (*path, i), _line_of(node, i, line))
                for i, item in enumerate(node)
            ]
        if isinstance(node, bool) or node is None:
            return node
        if isinstance(node, Integral):
            return self._short(int(node), path, line)
        for plain in (float, str):
            if isinstance(node, plain):
                return self._printable(plain(node), path, line)
        # Booleans that carry an anchor, dates, tagged values.
        if type(node).__name__ == "ScalarBoolean":
            return bool(node)
        raise InputError(
            f"{self.source}:{line}: {'.'.join(map(str, path))}: "
            f"a plain text or number is needed here (write quotes around it)"
        )

    def _short(self, value: int, path: PathKey, line: int) -> int:
        if abs(value) >= 10**_MOST_DIGITS:
            raise InputError(
                f"{self.source}:{line}: {'.'.join(map(str, path))}: "
                f"is a number of more than {_MOST_DIGITS} digits"
            )
        return value

    def _printable(self, value: Any, path: PathKey, line: int) -> Any:
        if isinstance(value, str) and any("\ud800" <= sign <= "\udfff" for sign in value):
            raise InputError(
                f"{self.source}:{line}: {'.'.join(map(str, path))}: holds half of a surrogate pair"
            )
        return value

    def _mapping(self, node: Any, path: PathKey, line: int) -> dict[str, Any]:
        plain = {}
        for key, item in node.items():
            name = str(self._short(key, path, line) if isinstance(key, int) else key)
            plain[name] = self.convert(item, (*path, name), _line_of(node, key, line))
        return plain


def _line_of(node: Any, key: Any, default: int) -> int:
    try:
        lines: Any = node.lc
        position = lines.key(key) if isinstance(node, dict) else lines.item(key)
        return int(position[0]) + 1
    except (AttributeError, KeyError, TypeError, IndexError):
        return default


def get_path(tree: Any, path: PathKey) -> Any:
    """The value at ``path``, or None where there is none."""
    for key in path:
        if isinstance(tree, dict):
            tree = tree.get(key)
        elif isinstance(tree, list) and isinstance(key, int) and key < len(tree):
            tree = tree[key]
        else:
            return None
    return tree


def with_value(tree: Any, path: PathKey, value: Any) -> Any:
    """A copy of ``tree`` with ``value`` at ``path``; only what changes is copied.

    A sensor given by name alone (``accelerometer: LSM330DL``) becomes a block
    when one of its quantities is set.
    """
    if not path:
        return value
    key, rest = path[0], path[1:]
    if isinstance(tree, list) and isinstance(key, int):
        if key >= len(tree):
            raise InputError(
                f"there is no item {key}; the list has {len(tree)}, which count from 0"
            )
        return [with_value(item, rest, value) if i == key else item for i, item in enumerate(tree)]
    if isinstance(tree, str):
        tree = {"model": tree}
    if not isinstance(tree, dict):
        tree = {}
    return {**tree, str(key): with_value(tree.get(str(key)), rest, value)}
