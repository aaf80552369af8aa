"""Commands of ``mcsim``; heavy imports happen inside the command that needs them."""

from __future__ import annotations

import gc
import io
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcsim.cli.budget import budget
from mcsim.cli.calibrate import calibrate, linearity
from mcsim.cli.characterise import characterise
from mcsim.cli.convert import convert
from mcsim.cli.names import refuse_same_names
from mcsim.cli.own import run_own
from mcsim.cli.signals import stopped_like_ctrl_c
from mcsim.cli.table import table
from mcsim.cli.vibration import analyse_shipped, vibration
from mcsim.errors import InputError, InterruptedRun, McsimError, PartialError
from mcsim.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from mcsim.results import Results
    from mcsim.scenario_file import Scenario

EXIT_DONE, EXIT_FAILED, EXIT_BAD_INPUT, EXIT_PARTIAL, EXIT_INTERRUPTED = 0, 1, 2, 3, 130
_OUTPUT = click.option(
    "--output",
    type=click.Path(path_type=Path),
    default=Path("output"),
    show_default=True,
    help="Folder for results; each scenario gets a folder inside.",
)
_JOBS = click.option(
    "--jobs",
    type=click.IntRange(min=1),
    help="Number of threads; all processors if absent. Results do not depend on it.",
)
_QUIET = click.option("--quiet", is_flag=True, help="No progress, no summary.")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit with its code."""
    code = exit_code(arguments)
    # The interpreter would look through all of numba's objects before it goes.
    gc.freeze()
    sys.exit(code)


def exit_code(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; every error becomes one message and an exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A terminal or pipe that lacks a sign gets a substitute, not an error.
            stream.reconfigure(errors="replace")
    try:
        with stopped_like_ctrl_c():
            code = commands.main(arguments, prog_name="mcsim", standalone_mode=False)
        return code if isinstance(code, int) else EXIT_DONE
    except click.ClickException as error:
        error.show()
        return EXIT_BAD_INPUT
    except InputError as error:
        return _fail(str(error), EXIT_BAD_INPUT)
    except PartialError as error:
        return _fail(str(error), EXIT_PARTIAL)
    except InterruptedRun as error:
        return _fail(str(error), EXIT_INTERRUPTED)
    except McsimError as error:
        return _fail(str(error), EXIT_FAILED)
    except (KeyboardInterrupt, click.Abort):
        return _fail("interrupted", EXIT_INTERRUPTED)
    except BrokenPipeError:
        # The reader of a pipe has left; nobody is there to be told.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_FAILED
    except Exception as error:
        if os.environ.get("MCSIM_DEBUG"):
            raise
        return _fail(
            f"internal error: {type(error).__name__}: {error} (MCSIM_DEBUG=1 shows where)",
            EXIT_FAILED,
        )


def _fail(message: str, code: int) -> int:
    if sys.stderr is None:
        return code
    lines = message.splitlines() or [""]
    print(f"mcsim: {lines[0]}", *lines[1:], sep="\n       ", file=sys.stderr)
    return code


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mcsim")
def commands() -> None:
    """How well can a vehicle know where it is, from inertial sensors alone?

    A scenario (YAML) describes a track, sensors and a sweep; mcsim reconstructs
    thousands of disturbed drives and reports the errors with their intervals.
    """


commands.add_command(table)


@commands.command()
@click.argument("scenarios", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--set", "overrides", multiple=True, metavar="PATH=VALUE", help="Replace a value.")
@click.option("--seed", type=int, help="Seed of the random numbers.")
@click.option("--realizations", type=int, help="Realizations per point.")
@click.option("--linear", is_flag=True, help="The linear model's answer, at once.")
@click.option(
    "--with",
    "own",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="FILE.py",
    help="Run this Python file first: it adds rules of your own (mcsim.add_rule).",
)
@click.option("--dask", metavar="ADDRESS", help="Run the points on this Dask scheduler's workers.")
@click.option("--no-figures", is_flag=True, help="Tables only; `mcsim plot` draws them later.")
@click.option("--dry-run", is_flag=True, help="Say what would be run, and stop.")
@_JOBS
@_OUTPUT
@_QUIET
def run(
    scenarios: tuple[Path, ...],
    overrides: tuple[str, ...],
    seed: int | None,
    realizations: int | None,
    linear: bool,
    own: tuple[Path, ...],
    dask: str | None,
    no_figures: bool,
    dry_run: bool,
    jobs: int | None,
    output: Path,
    quiet: bool,
) -> None:
    """Run scenarios; write tables, figures and provenance."""
    from mcsim.cli.plan import plan
    from mcsim.results import check

    if own and dask is not None:
        raise InputError("--with: rules of your own run on this machine alone, not with --dask")
    for file in own:
        run_own(file)
    read = [_read(path, overrides, seed, realizations, linear) for path in scenarios]
    refuse_same_names(read)
    for scenario in read:
        check(scenario)
    if dry_run:
        for scenario in read:
            click.echo(plan(scenario))
            _note_without_effect(scenario)
        return
    failures = []
    draw = _leave_undrawn if no_figures else None
    for scenario in read:
        results = _run_one(scenario, jobs, output, quiet, draw, dask)
        failures += results.failures
        if not quiet:
            names = ["table.csv"] if no_figures else ["table.csv", "figure.png"]
            _report(results, [output / scenario.name / name for name in names])
    _raise_failures(failures)


for command in (budget, calibrate, characterise, convert, linearity, table, vibration):
    commands.add_command(command)


@commands.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
def validate(files: tuple[Path, ...]) -> None:
    """Check scenario files without running them."""
    from mcsim.results import check
    from mcsim.scenario_file import Scenario
    from mcsim.vibration.scenario import is_vibration, read_vibration

    problems = []
    for path in files:
        try:
            if is_vibration(path):
                read_vibration(path)
                click.echo(f"{path}: valid")
                continue
            scenario = Scenario.from_yaml(path)
            check(scenario)
            click.echo(f"{path}: valid, {scenario.n_points} point(s)")
            _note_without_effect(scenario)
        except InputError as error:
            problems.append(str(error))
    if problems:
        raise InputError("\n".join(problems))


@commands.command()
@click.argument("case", type=click.Choice(["scenario", "vibration"]), default="scenario")
def schema(case: str) -> None:
    """Print the JSON schema (draft 7) of scenario files."""
    import json

    from mcsim.scenario_file.schema import scenario_schema
    from mcsim.vibration.scenario import vibration_schema

    known = {"scenario": scenario_schema, "vibration": vibration_schema}
    click.echo(json.dumps(known[case](), indent=2))


@commands.command()
@click.argument("name", required=False)
def sensors(name: str | None) -> None:
    """List the built-in sensors, or one of them with its sources."""
    from mcsim.cli.tables import sensor_details, sensor_list

    click.echo(sensor_details(name) if name else sensor_list())


@commands.command()
@click.argument("numbers", nargs=-1, metavar="[1 … 5, 10 … 14|strapdown|velocity|vibration|all]")
@_JOBS
@_OUTPUT
@_QUIET
def figures(numbers: tuple[str, ...], jobs: int | None, output: Path, quiet: bool) -> None:
    """Reproduce figures: planar paper (1 to 5), velocity paper (10 to 14), other scenarios."""
    from mcsim.cli.drawing import Drawing
    from mcsim.cli.paper import GROUPS, figure_numbers, figure_scenarios, shipped, title_of
    from mcsim.cli.velocity_paper import FIGURES, draw_figure
    from mcsim.processors import default_jobs

    failures, pictures = [], []
    wanted = figure_numbers(numbers, FIGURES)
    groups = [name for name in GROUPS if not numbers or name in numbers or "all" in numbers]
    with Drawing(jobs or default_jobs()) as drawing:

        def draw_alone(_: Results, folder: Path) -> None:
            drawing.one(folder)

        for number, parts in figure_scenarios(wanted).items():
            folders = [output / scenario.name for scenario in parts]
            # Parts of one figure are drawn side by side, and not each alone as well.
            draw = _leave_undrawn if len(parts) > 1 else draw_alone
            for scenario in parts:
                results = _run_one(scenario, jobs, output, quiet, draw)
                failures += results.failures
                if not quiet:
                    _note(results)
            folder = output / f"figure{number}" if len(parts) > 1 else folders[0]
            if len(parts) > 1:
                drawing.side_by_side(folders, title_of(parts), folder)
            pictures.append(folder / "figure.png")
        for scenario in (s for name in groups if name != "vibration" for s in shipped(name)):
            results = _run_one(scenario, jobs, output, quiet, draw_alone)
            failures += results.failures
            pictures.append(output / scenario.name / "figure.png")
        if "vibration" in groups:
            pictures += analyse_shipped(output / "vibration")
        for number in wanted:
            if number in FIGURES:
                draw_figure(number, output)
                pictures.append(output / f"figure{number}" / "figure.png")
    if not quiet:
        click.echo("\n".join(map(str, pictures)))
    _raise_failures(failures)


@commands.command()
@click.argument("results", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--output", type=click.Path(path_type=Path), help="Folder for the figures; that of the result."
)
def plot(results: tuple[Path, ...], output: Path | None) -> None:
    """Draw stored results again."""
    from mcsim.figures import save_figures
    from mcsim.store import load_results, readable_errors

    for path in results:
        stored = load_results(path)
        folder = path if path.is_dir() else path.parent
        if output is not None:
            folder = output / stored.scenario.name
            with readable_errors(folder):
                folder.mkdir(parents=True, exist_ok=True)
        try:
            files = save_figures(stored, folder)
        except McsimError:
            raise
        except Exception as error:  # whatever strange tables make of a drawing
            if os.environ.get("MCSIM_DEBUG"):
                raise
            raise InputError(
                f"{path}: a damaged result ({type(error).__name__}: {error}); run it again"
            ) from None
        for file in files:
            click.echo(file)


def _read(
    path: Path,
    overrides: tuple[str, ...],
    seed: int | None,
    realizations: int | None,
    linear: bool,
) -> Scenario:
    from mcsim.scenario_file import Scenario

    scenario = Scenario.from_yaml(path, overrides)
    settings: dict[str, Any] = {}
    if seed is not None:
        settings["monte_carlo.seed"] = seed
    if realizations is not None:
        settings |= {
            "monte_carlo.realizations": realizations,
            "monte_carlo.precision": None,
            "monte_carlo.max_realizations": None,
        }
    if linear:
        settings["monte_carlo.estimator"] = "linear"
    return scenario.with_values(settings) if settings else scenario


def _run_one(
    scenario: Scenario,
    jobs: int | None,
    output: Path,
    quiet: bool,
    draw: Callable[[Results, Path], object] | None = None,
    dask: str | None = None,
) -> Results:
    from mcsim.api import run as run_scenario
    from mcsim.cli.progress import announce_compilation, progress_for
    from mcsim.store import Checkpoint

    if not quiet:
        announce_compilation()
    try:
        return run_scenario(
            scenario, jobs=jobs, output=output, progress=progress_for(quiet), draw=draw, dask=dask
        )
    except KeyboardInterrupt:
        kept = len(Checkpoint.of(scenario, output / scenario.name).read())
        then = "the same command goes on from there" if kept else "nothing is kept"
        raise InterruptedRun(
            f"{scenario.name}: interrupted with {kept} of {scenario.n_points} points done; {then}"
        ) from None


def _leave_undrawn(results: Results, folder: Path) -> None:
    """Draw nothing; remove the figures of an earlier run, which would not belong to the tables."""
    from mcsim.store import remove_figures

    del results
    remove_figures(folder)


def _report(results: Results, files: Sequence[Path]) -> None:
    from mcsim.cli.tables import summary

    if not results.scenario.axes:
        click.echo(summary(results))
    _note(results)
    click.echo(f"{results.scenario.name}: {', '.join(map(str, files))}")


def _note(results: Results) -> None:
    from mcsim.kernels.compilation import unkept

    if unkept:
        click.echo("note: no folder for compiled code can be written; it is made anew", err=True)
    for remark in results.remarks:
        click.echo(f"note: {remark}", err=True)


def _note_without_effect(scenario: Scenario) -> None:
    from mcsim.scenario_file.effect import without_effect

    for sentence in without_effect(scenario):
        click.echo(f"note: {sentence}", err=True)


def _raise_failures(failures: list[str]) -> None:
    if failures:
        shown = failures[:10] + [f"… and {len(failures) - 10} more"] * (len(failures) > 10)
        raise PartialError(
            "\n".join([f"{len(failures)} point(s) failed; the others are written:", *shown])
        )
