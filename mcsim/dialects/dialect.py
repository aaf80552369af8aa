"""What a file of a dialect must say of it: one object, listed in ``registry``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mcsim.dialects.description import Assumptions, Description, Reading
from mcsim.dialects.terms import Term


@dataclass(frozen=True)
class Dialect:
    """How one tool writes a sensor.

    ``title`` tells people what it is, ``comment`` begins a comment line in it.
    ``convention`` says what its noise numbers mean; ``recognises`` whether a text is written
    in it.  ``read`` takes a text, its name for messages, and the user's answers; ``write`` a
    description and the answers.  Either is None where it makes no sense.  ``terms`` are the
    numbers that a single noise figure becomes in it; ``ending`` is that of its files.
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
