"""``mcsim plot``: stored results, drawn again."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcsim.cli.command import Command
from mcsim.errors import InputError, McsimError

if TYPE_CHECKING:
    from mcsim.results import Results


@click.command()
@click.argument("results", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--output", type=click.Path(path_type=Path), help="Folder for the figures; that of the result."
)
def plot(results: tuple[Path, ...], output: Path | None) -> None:
    """Draw stored results again."""
    from mcsim.store import load_results

    for path in results:
        stored = load_results(path)
        folder = path if path.is_dir() else path.parent
        if output is not None:
            folder = output / stored.scenario.name
        for file in _drawn(stored, path, folder):
            click.echo(file)


COMMAND = Command("plot", plot)


def _drawn(stored: Results, path: Path, folder: Path) -> list[Path]:
    from mcsim.figures.saving import save_figures

    try:
        return save_figures(stored, folder)
    except McsimError:
        raise
    except Exception as error:  # whatever strange tables make of a drawing
        if os.environ.get("MCSIM_DEBUG"):
            raise
        raise InputError(
            f"{path}: a damaged result ({type(error).__name__}: {error}); run it again"
        ) from None
