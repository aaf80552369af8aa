"""Kernel systems of the rules that users have added, by case and name."""

from __future__ import annotations

from typing import Any

_SYSTEMS: dict[tuple[str, str], type[Any]] = {}


def add_system(case: str, name: str, system: type[Any]) -> None:
    """Keep the kernel system of a user's rule."""
    _SYSTEMS[case, name] = system


def own_system(case: str, name: str) -> type[Any] | None:
    """The system of a rule that a user has added; None for shipped rules."""
    return _SYSTEMS.get((case, name))
