"""Options that are quantities within bounds, with advice that holds when it is followed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from mcsim.errors import InputError, UnitError
from mcsim.units import Kind, parse


def between(option: str, text: str, kind: Kind, ends: tuple[str, str], example: str) -> float:
    """The SI value of an option such as ``--duration`` that lies between two ``ends``.

    Raises
    ------
    InputError
        No quantity of the kind, or one beyond the ends; the ``example`` is given as advice.
    """
    low, high = (parse(end, kind) for end in ends)
    words = f"must lie between {ends[0]} and {ends[1]}"
    return _checked(option, text, replace(kind, example=example), lambda x: low <= x <= high, words)


def positive(option: str, text: str, kind: Kind) -> float:
    """The SI value of an option above zero; errors as ``between``."""
    return _checked(option, text, kind, lambda x: x > 0.0, "must be above zero")


def not_negative(option: str, text: str, kind: Kind) -> float:
    """The SI value of an option of zero or more; errors as ``between``."""
    return _checked(option, text, kind, lambda x: x >= 0.0, "must not be negative")


def _checked(
    option: str, text: str, kind: Kind, accepts: Callable[[float], bool], words: str
) -> float:
    try:
        value = parse(text, replace(kind, accepts=accepts))
    except UnitError as error:
        raise InputError(f"{option}: {error}") from None
    if not accepts(value):
        raise InputError(f'{option}: "{text}" {words}')
    return value
