"""What a file of a command must say: one object, listed in ``commands``."""

from __future__ import annotations

from dataclasses import dataclass

import click


@dataclass(frozen=True)
class Command:
    """A command of ``mcsim``.

    Attributes
    ----------
    name : str
        What is written after ``mcsim``.
    command : click.Command
        Its options, and the function that they go to.  It should import what is heavy inside
        that function.  ``mcsim.InputError`` becomes a message and exit code 2.
    """

    name: str
    command: click.Command
