"""What users add to kernels: their rules by case and name, and what tells their sources apart."""

from __future__ import annotations

import hashlib
import inspect
from typing import Any

_SYSTEMS: dict[tuple[str, str], type[Any]] = {}


def add_system(case: str, name: str, system: type[Any]) -> None:
    """Keep the kernel system of a user's rule."""
    _SYSTEMS[case, name] = system


def own_system(case: str, name: str) -> type[Any] | None:
    """The system of a rule that a user has added; None for shipped rules."""
    return _SYSTEMS.get((case, name))


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
