"""What is said beside the answer, on standard error."""

from __future__ import annotations

import sys

import click


def note(text: str) -> None:
    """Something that a user should know."""
    click.echo(f"note: {text}", err=True)


def say(line: str) -> None:
    """What is being done."""
    print(line, file=sys.stderr, flush=True)


def silent(_: str) -> None:
    """Nothing."""
