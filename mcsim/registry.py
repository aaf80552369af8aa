"""Lists of parts: one for each kind that a user may add to, from inside or outside the package.

A kind of part (a shape of track, a sensor term, a statistic, a dialect, a case …) is a frozen
dataclass with a ``name``; the parts that exist stand in one ``Registry``, in the order of every
table and message.  To add one is a file and a line in that list, or ``mcsim.add(part)`` in a
user's own file.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping
from importlib import import_module
from typing import Any, Generic, Protocol, TypeVar, cast

from mcsim.errors import InputError


class Part(Protocol):
    """What all kinds of parts have."""

    @property
    def name(self) -> str:
        """What scenarios, options or tables call it."""


P = TypeVar("P", bound=Part)


class Registry(Mapping[str, P], Generic[P]):
    """The parts of one kind by name, in order.

    Parameters
    ----------
    kind : str
        What one of them is, for messages: ``"shape of track"``.
    parts : iterable of parts
    later : mapping, optional
        Parts that are imported when they are first looked up: name to ``"module:ATTRIBUTE"``.
        Only for what is costly to import.
    """

    def __init__(
        self, kind: str, parts: Iterable[P] = (), later: Mapping[str, str] | None = None
    ) -> None:
        self.kind = kind
        self._parts: dict[str, P | str] = dict(later or {})
        self._told: list[Callable[[P], None]] = []
        for part in parts:
            self.add(part)

    @property
    def one(self) -> str:
        """The kind with its article: ``a shape of track``, ``an error``."""
        return f"{'an' if self.kind[:1] in 'aeiou' else 'a'} {self.kind}"

    def add(self, part: P) -> None:
        """List one more part.

        Raises
        ------
        InputError
            A name that is taken, or none.
        """
        name = part.name
        if not name or not isinstance(name, str):
            raise InputError(f"{self.one} needs a name")
        if name in self._parts:
            raise InputError(f"{name}: there is {self.one} of that name already")
        for tell in self._told:
            tell(part)
        self._parts[name] = part

    def tell(self, hears: Callable[[P], None]) -> None:
        """Call ``hears`` with each part that is added from now on, before it is listed."""
        self._told.append(hears)

    def remove(self, name: str) -> None:
        """Take a part off the list; for those who add parts for a while."""
        del self._parts[name]

    def find(self, name: str, where: str = "") -> P:
        """The part of a name as a user writes it; ``where`` begins the message if there is none.

        Raises
        ------
        InputError
            There is none of that name.
        """
        if name not in self._parts:
            raise InputError(f"{where}{self.unknown(name)}")
        return self[name]

    def unknown(self, name: str) -> str:
        """What to say of a name that no part has."""
        names = ", ".join(self._parts)
        return f'"{name}" is not {self.one} (known: {names}){suggest(name, self._parts)}'

    def __getitem__(self, name: str) -> P:
        part: Any = self._parts[name]
        if isinstance(part, str):
            module, _, attribute = part.partition(":")
            part = self._parts[name] = cast(P, getattr(import_module(module), attribute))
        return cast(P, part)

    def __iter__(self) -> Iterator[str]:
        return iter(tuple(self._parts))

    def __len__(self) -> int:
        return len(self._parts)


def suggest(word: str, known: Iterable[str]) -> str:
    """``; did you mean "…"?`` or nothing."""
    close = difflib.get_close_matches(word, list(known), n=1, cutoff=0.6)
    return f'; did you mean "{close[0]}"?' if close else ""
