"""What users add to kernels: their rules by case and name, and what tells their sources apart."""

from __future__ import annotations

import hashlib
import inspect
from typing import Any

_SYSTEMS: dict[tuple[str, str], tuple[type[Any], type[Any]]] = {}


def add_system(case: str, name: str, even: type[Any], timed: type[Any]) -> None:
    """Keep the kernel systems of a user's rule: for even intervals, and for varying ones."""
    _SYSTEMS[case, name] = even, timed


def own_system(case: str, name: str, timed: bool = False) -> type[Any] | None:
    """The system of a rule that a user has added; None for shipped rules."""
    systems = _SYSTEMS.get((case, name))
    return None if systems is None else systems[timed]


def digest_of(*parts: Any) -> str:
    """Tells apart what functions and types are compiled from."""
    digest = hashlib.blake2b(digest_size=8)
    for part in parts:
        digest.update(_source_of(part))
    return digest.hexdigest()


def _source_of(part: Any) -> bytes:
    """What a part is compiled from: the whole file, since functions call others in it."""
    try:
        return (inspect.getsource(inspect.getmodule(part) or part)).encode()
    except (OSError, TypeError):
        return repr(part).encode()
