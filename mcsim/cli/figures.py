"""``mcsim figures``: figures of the papers, and what the other shipped scenarios give."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcsim.cli.command import Command
from mcsim.cli.options import JOBS, QUIET, output
from mcsim.cli.own import own_files
from mcsim.cli.running import note_remarks, raise_failures, run_one
from mcsim.papers import FIGURES

if TYPE_CHECKING:
    from mcsim.results import Results
    from mcsim.scenario_file import Scenario


class _Names(click.Argument):
    """The names of figures, which files of a user's own may have added to."""

    def make_metavar(self, *_: object) -> str:
        return f"[{'|'.join([*FIGURES, 'all'])}]…"


@click.command()
@click.argument("names", nargs=-1, cls=_Names)
@JOBS
@output("each scenario gets a folder")
@QUIET
def figures(names: tuple[str, ...], jobs: int | None, output: Path, quiet: bool) -> None:
    """Reproduce figures: planar paper (1 to 5), velocity paper (10 to 14), other scenarios."""
    from mcsim.papers.drawing import Drawing
    from mcsim.papers.making import figures_named, make_figures
    from mcsim.processors import default_jobs

    def run(scenario: Scenario, draw: Callable[[Results, Path], object]) -> Results:
        results = run_one(scenario, output, jobs=jobs, quiet=quiet, draw=draw, formats=("csv",))
        if not quiet:
            note_remarks(results)
        return results

    wanted = figures_named(names)
    # Other processes know nothing of parts of a user's own.
    processes = 1 if own_files() else jobs or default_jobs()
    with Drawing(processes) as drawing:
        pictures, failures = make_figures(wanted, output, drawing, run)
    if not quiet:
        click.echo("\n".join(map(str, pictures)))
    raise_failures(failures)


COMMAND = Command("figures", figures)
