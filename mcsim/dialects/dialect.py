"""What a file of a dialect must say of it: one object, listed in ``registry``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mcsim.dialects.description import Assumptions, Description, Reading
from mcsim.dialects.terms import Term


@dataclass(frozen=True)
class Dialect:
    """How one tool writes a sensor.

    Parameters
    ----------
    name : str
        What ``--from`` and ``--to`` call it.
    title : str
        What a text in it is.
    convention : str
        What its noise numbers mean; said at the head of what is written.
    recognises : callable or None
        Whether a text is written in it.
    read : callable or None
        Takes a text, its name for messages, and the user's answers; None where it is not read.
    write : callable or None
        Takes a description and the user's answers; None where it is not written.
    comment : str
        What begins a comment; '' where it knows none, and nothing is said at the head.
    terms : tuple of Term
        The numbers that a single noise figure becomes in it.
    ending : str
        That of the names of its files.
    """

    name: str
    title: str
    convention: str
    recognises: Callable[[str], bool] | None
    read: Callable[[str, str, Assumptions], Reading] | None
    write: Callable[[Description, Assumptions], str] | None
    comment: str = "#"
    terms: tuple[Term, ...] = ()
    ending: str = ".yaml"
