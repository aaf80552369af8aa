"""``mcsim run``: scenarios to tables, figures and provenance."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

import click

from mcsim.cli.command import Command
from mcsim.cli.names import refuse_same_names
from mcsim.cli.options import JOBS, QUIET, SCENARIOS, SET, output
from mcsim.cli.own import own_files, run_files
from mcsim.cli.running import note_remarks, raise_failures, run_one
from mcsim.errors import InputError

if TYPE_CHECKING:
    from mcsim.results import Results
    from mcsim.scenario_file import Scenario


class _Options(TypedDict):
    overrides: tuple[str, ...]
    sweeps: tuple[str, ...]
    as_map: bool
    seed: int | None
    realizations: int | None
    linear: bool
    own: tuple[Path, ...]
    dask: str | None
    no_figures: bool
    dry_run: bool
    jobs: int | None
    output: Path
    quiet: bool


@click.command()
@SCENARIOS
@SET
@click.option(
    "--sweep",
    "sweeps",
    multiple=True,
    metavar="PATH=FROM..TO",
    help="Sweep this instead of what the file sweeps: `sensors.rate=20..1000 Hz:9 log`, or a list.",
)
@click.option("--map", "as_map", is_flag=True, help="Also draw two swept values as a map.")
@click.option("--seed", type=int, help="Seed of the random numbers.")
@click.option("--realizations", type=int, help="Realizations per point.")
@click.option("--linear", is_flag=True, help="The linear model's answer, at once.")
@click.option(
    "--with",
    "own",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="FILE.py",
    callback=run_files,
    help="Run this Python file first: it adds parts of your own.",
)
@click.option("--dask", metavar="ADDRESS", help="Run the points on this Dask scheduler's workers.")
@click.option("--no-figures", is_flag=True, help="Tables only; `mcsim plot` draws them later.")
@click.option("--dry-run", is_flag=True, help="Say what would be run, and stop.")
@JOBS
@output("each scenario gets a folder")
@QUIET
def run(scenarios: tuple[Path, ...], **options: Unpack[_Options]) -> None:
    """Run scenarios; write tables, figures and provenance."""
    from mcsim.results import check

    if (options["own"] or own_files()) and options["dask"] is not None:
        raise InputError("--with: parts of your own run on this machine alone, not with --dask")
    read = [_read(path, options) for path in scenarios]
    refuse_same_names(read)
    for scenario in read:
        check(scenario)
    if options["dry_run"]:
        _tell_plans(read)
        return
    failures = []
    draw = _leave_undrawn if options["no_figures"] else None
    for scenario in read:
        results = run_one(
            scenario,
            options["output"],
            jobs=options["jobs"],
            quiet=options["quiet"],
            draw=draw,
            dask=options["dask"],
        )
        failures += results.failures
        if not options["quiet"]:
            pictures = [] if options["no_figures"] else _pictures(results)
            names = ["table.csv", *pictures]
            _report(results, [options["output"] / scenario.name / name for name in names])
    raise_failures(failures)


COMMAND = Command("run", run)


def _read(path: Path, options: _Options) -> Scenario:
    from mcsim.scenario_file import Scenario
    from mcsim.scenario_file.sweeping import swept_anew

    scenario = Scenario.from_yaml(path, options["overrides"])
    if options["sweeps"] or options["as_map"]:
        scenario = swept_anew(scenario, options["sweeps"], options["as_map"])
    settings: dict[str, Any] = {}
    if options["seed"] is not None:
        settings["monte_carlo.seed"] = options["seed"]
    if options["realizations"] is not None:
        settings |= {
            "monte_carlo.realizations": options["realizations"],
            "monte_carlo.precision": None,
            "monte_carlo.max_realizations": None,
        }
    if options["linear"]:
        settings["monte_carlo.estimator"] = "linear"
    return scenario.with_values(settings) if settings else scenario


def _tell_plans(scenarios: Sequence[Scenario]) -> None:
    from mcsim.cli.plan import plan
    from mcsim.scenario_file.effect import without_effect

    for scenario in scenarios:
        click.echo(plan(scenario))
        for sentence in without_effect(scenario):
            click.echo(f"note: {sentence}", err=True)


def _leave_undrawn(results: Results, folder: Path) -> None:
    """Figures of an earlier run are gone: they would not belong to the tables."""
    del results, folder


def _pictures(results: Results) -> list[str]:
    from mcsim.figures import PICTURES

    return [f"{p.name}.png" for p in PICTURES.values() if p.wants(results)]


def _report(results: Results, files: Sequence[Path]) -> None:
    from mcsim.cli.summary import summary

    if not results.scenario.axes:
        click.echo(summary(results))
    note_remarks(results)
    click.echo(f"{results.scenario.name}: {', '.join(map(str, files))}")
