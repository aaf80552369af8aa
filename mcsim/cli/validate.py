"""``mcsim validate``: scenario files, checked without running them."""

from __future__ import annotations

from pathlib import Path

import click

from mcsim.cli.command import Command
from mcsim.errors import InputError


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
def validate(files: tuple[Path, ...]) -> None:
    """Check scenario files without running them."""
    from mcsim.api.scenario_files import validate as check

    problems = []
    for path in files:
        try:
            found = check(path)
        except InputError as error:
            problems.append(str(error))
            continue
        points = f", {found.points} point(s)" if found.points is not None else ""
        click.echo(f"{path}: valid{points}")
        for note in found.notes:
            click.echo(f"note: {note}", err=True)
    if problems:
        raise InputError("\n".join(problems))


COMMAND = Command("validate", validate)
