"""Keys that a scenario writes and that change nothing there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class IdleKey:
    """A key that has no effect where ``idle`` holds, unless what decides it is swept.

    ``deciding`` are the paths, or the beginnings of paths, that ``idle`` looks at.
    """

    path: str
    deciding: tuple[str, ...]
    idle: Callable[[Any], bool]
    reason: str


def always(_: Any) -> bool:
    """In every scenario of the case."""
    return True
