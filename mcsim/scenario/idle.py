"""Keys that a scenario writes and that change nothing there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class IdleKey:
    """A key that has no effect in some scenarios, unless what decides it is swept.

    Attributes
    ----------
    path : str
        Of the key: ``body.roll.damping``.
    deciding : tuple of str
        The paths, or the beginnings of paths, that ``idle`` looks at.
    idle : callable
        ``idle(model)``: whether the key has no effect in this validated scenario.
    reason : str
        Why, as the note says it.
    """

    path: str
    deciding: tuple[str, ...]
    idle: Callable[[Any], bool]
    reason: str


def always(_: Any) -> bool:
    """In every scenario of the case."""
    return True
