"""``mcsim table``: printed tables of the sources beside what mcsim computes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mcsim.cli.command import Command
from mcsim.papers import TABLES, PaperTable, Setting


class _Tables(click.Group):
    """A command for each table of the list, made of what the table says of itself."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        del ctx
        return sorted(TABLES)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        del ctx
        return _command(TABLES[cmd_name]) if cmd_name in TABLES else None


@click.group(cls=_Tables)
def table() -> None:
    """Tables of the sources: printed, recomputed and simulated values side by side."""


COMMAND = Command("table", table)


def _command(part: PaperTable) -> click.Command:
    options: list[click.Parameter] = [_option(setting) for setting in part.settings]
    if len(part.files) == 1:
        file = click.Path(path_type=Path, dir_okay=False)
        options.append(click.Option(["--csv"], type=file, help="Also write a CSV file."))
    files = ", ".join(f"{name}.csv" for name in part.files)
    inside = f"; {part.folder} is made inside" if part.folder else ""
    options.append(
        click.Option(
            ["--output"],
            type=click.Path(path_type=Path),
            default=part.output,
            show_default=part.output is not None,
            help=f"Folder for {files}{inside}.",
        )
    )
    options.append(click.Option(["--quiet"], is_flag=True, help="No table on the terminal."))

    def compute(output: Path | None, quiet: bool, csv: Path | None = None, **settings: Any) -> None:
        _compute(part, settings, output, csv, quiet)

    return click.Command(part.name, callback=compute, params=options, help=part.title)


def _option(setting: Setting) -> click.Option:
    kind: Any = str
    if setting.choices:
        kind = click.Choice(setting.choices)
    elif isinstance(setting.default, int):
        kind = click.IntRange(setting.least)
    return click.Option(
        [f"--{setting.name}"],
        type=kind,
        default=setting.default,
        show_default=True,
        help=setting.help,
        metavar=setting.metavar,
    )


def _compute(
    part: PaperTable,
    settings: dict[str, Any],
    output: Path | None,
    csv: Path | None,
    quiet: bool,
) -> None:
    from mcsim.cli.progress import announce_compilation
    from mcsim.papers.table import table as table_of

    if not quiet:
        announce_compilation()
    found = table_of(part.name, **settings)
    if not quiet:
        click.echo(found.text)
    if csv is not None:
        found.write_csv(csv)
    if output is not None:
        folder = output / part.folder
        found.write(folder)
        if not quiet:
            click.echo("\n".join(str(folder / f"{name}.csv") for name in found.tables))
