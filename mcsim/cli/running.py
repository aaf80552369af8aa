"""Running a scenario as the commands do: with progress, remarks, and what an interruption keeps."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcsim.errors import InterruptedRun, PartialError

if TYPE_CHECKING:
    from mcsim.results import Results
    from mcsim.scenario_file import Scenario


def run_one(
    scenario: Scenario,
    output: Path,
    *,
    jobs: int | None = None,
    quiet: bool = False,
    draw: Callable[[Results, Path], object] | None = None,
    dask: str | None = None,
    formats: tuple[str, ...] = ("csv", "parquet"),
) -> Results:
    """Run a scenario into a folder of ``output``, telling how it goes.

    Raises
    ------
    InterruptedRun
        By Ctrl-C; the message says how to go on.
    """
    from mcsim.api.run import run
    from mcsim.checkpoints import Checkpoint
    from mcsim.cli.progress import announce_compilation, progress_for

    if not quiet:
        announce_compilation()
    told = progress_for(quiet)
    try:
        return run(
            scenario,
            jobs=jobs,
            output=output,
            progress=told,
            draw=draw,
            dask=dask,
            formats=formats,
        )
    except KeyboardInterrupt:
        kept = len(Checkpoint.of(scenario, output / scenario.name).read())
        then = "the same command goes on from there" if kept else "nothing is kept"
        raise InterruptedRun(
            f"{scenario.name}: interrupted with {kept} of {scenario.n_points} points done; {then}"
        ) from None


def note_remarks(results: Results) -> None:
    """Say what a user should know beyond the numbers."""
    from mcsim.kernels.compilation import unkept

    if unkept:
        click.echo("note: no folder for compiled code can be written; it is made anew", err=True)
    for remark in results.remarks:
        click.echo(f"note: {remark}", err=True)


def raise_failures(failures: list[str]) -> None:
    """End with the points that failed, if any did.

    Raises
    ------
    PartialError
        Some did.
    """
    if failures:
        shown = failures[:10] + [f"… and {len(failures) - 10} more"] * (len(failures) > 10)
        raise PartialError(
            "\n".join([f"{len(failures)} point(s) failed; the others are written:", *shown])
        )
