"""Options that several commands have."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])

FILE = click.argument("file", type=click.Path(path_type=Path))
SCENARIOS = click.argument("scenarios", nargs=-1, required=True, type=click.Path(path_type=Path))
SET = click.option(
    "--set", "overrides", multiple=True, metavar="PATH=VALUE", help="Replace a value."
)
JOBS = click.option(
    "--jobs",
    type=click.IntRange(min=1),
    help="Number of threads; all processors if absent. Results do not depend on it.",
)
QUIET = click.option("--quiet", is_flag=True, help="No progress, no summary.")
NO_SUMMARY = click.option("--quiet", is_flag=True, help="No summary.")
SIMULATION_SEED = click.option(
    "--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of a simulation."
)


def output(what: str) -> Callable[[F], F]:
    """``--output``, by default the folder ``output``; ``what`` is made inside."""
    return click.option(
        "--output",
        type=click.Path(path_type=Path),
        default=Path("output"),
        show_default=True,
        help=f"Folder for results; {what} inside.",
    )
