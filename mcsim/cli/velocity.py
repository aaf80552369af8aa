"""``mcsim velocity``: recorded runs of an accelerometer to a velocity with its uncertainty."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypedDict, Unpack

import click

from mcsim.cli.command import Command
from mcsim.cli.notes import note, silent
from mcsim.cli.options import NO_SUMMARY, output

if TYPE_CHECKING:
    from mcsim.api.velocity_options import ReferenceOptions


class _Options(TypedDict):
    calibration: Path
    columns: str | None
    units: str | None
    run_column: str | None
    runs: int | None
    rest: str | None
    duration: str | None
    still: str | None
    align: Literal["auto", "samples", "time"]
    gravity: str | None
    gravity_uncertainty: str | None
    tilt_change: str | None
    unevenness: str | None
    axle_distance: str | None
    nonlinearity: str | None
    interval_uncertainty: str | None
    time_errors: Literal["independent", "stamps"] | None
    tilt_order: Literal["first", "second", "exact"] | None
    reference: tuple[str, ...]
    reference_file: tuple[Path, ...]
    wheel_radius: str | None
    ticks_per_turn: float | None
    reference_uncertainty: str | None
    draws: int
    seed: int
    output: Path
    quiet: bool


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--calibration",
    required=True,
    type=click.Path(path_type=Path),
    help="calibration.yaml of mcsim calibrate, or a velocity scenario.",
)
@click.option("--columns", help="What the columns are, as in mcsim characterise: accel_x=TITLE,….")
@click.option("--units", help="Units of columns without one: accelerometer=g,time=ms.")
@click.option("--run-column", help="Column that tells runs apart; `run` if there is one.")
@click.option("--runs", type=click.IntRange(min=1), help="How many runs the files must hold.")
@click.option("--rest", help="Rest before each motion, '10 s' or '1000 samples'; found if absent.")
@click.option("--duration", help="Length of the motion, '1.5 s'; until it stays still if absent.")
@click.option("--still", help="How long a rest lasts at least when it is found; 2 s if absent.")
@click.option(
    "--align",
    type=click.Choice(["auto", "samples", "time"]),
    default="auto",
    show_default=True,
    help="Average runs sample by sample, or at common instants.",
)
@click.option("--gravity", help="g at the site of calibration, '9.81213 m/s²'.")
@click.option("--gravity-uncertainty", help="Its standard uncertainty, '3e-6 m/s²'.")
@click.option("--tilt-change", help="u(δα), change of the tilt while moving, '0.1 °'.")
@click.option("--unevenness", help="Instead: how far one axle rises against the other, '1 mm'.")
@click.option("--axle-distance", help="With it: distance of the axles, '0.57 m'.")
@click.option("--nonlinearity", help="Of the scale factor, for u(lxx) by Eq. (34): '1000 ppm'.")
@click.option("--interval-uncertainty", help="u(Δt); from the time stamps if absent.")
@click.option(
    "--time-errors",
    type=click.Choice(["independent", "stamps"]),
    help="Whether intervals or stamps err; told by their correlation if absent.",
)
@click.option(
    "--tilt-order",
    type=click.Choice(["first", "second", "exact"]),
    help="Eq. (15), Eq. (12), or the whole rotation; first if absent.",
)
@click.option(
    "--reference",
    multiple=True,
    metavar="'NAME in UNIT'",
    help="Column of the reference: a speed, a wheel's rate or angle, or ticks; give left and "
    "right, and their mean counts.",
)
@click.option(
    "--reference-file",
    multiple=True,
    type=click.Path(path_type=Path),
    help="File of the reference, one for each FILE, on the same clock.",
)
@click.option("--wheel-radius", help="Radius of the wheels, '0.1 m'.")
@click.option("--ticks-per-turn", type=float, help="Of the wheels' encoders.")
@click.option("--reference-uncertainty", help="Of the reference, '0.005 m/s' or '1 %'.")
@click.option("--draws", type=int, default=10_000, show_default=True, help="Of the Monte Carlo.")
@click.option(
    "--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of the Monte Carlo."
)
@output("a folder named after the first file is made")
@NO_SUMMARY
def velocity(files: tuple[Path, ...], **options: Unpack[_Options]) -> None:
    """Velocity of recorded runs with its uncertainty: correction, tilt, integration.

    FILES are logs of a tri-axial accelerometer (x forward, z upward) with time stamps and the rest
    before each motion: a run in each, runs told apart by a column `run`, or runs with rests
    between them.  Writes velocity.csv (v(t) of every run, their mean, s(v), uc by Eq. (30) and
    (31)-(33), and Monte Carlo), budget.csv (the rows of Tables 3 and 4, averaged over the motion),
    and figures; with a reference its errors too.
    """
    from mcsim.api.velocity import velocity as velocity_of
    from mcsim.text_table import frame_text

    found = velocity_of(
        files,
        options["calibration"],
        read={key: options[key] for key in ("columns", "units", "run_column")},  # type: ignore[misc]
        motion={key: options[key] for key in ("rest", "duration", "still", "runs", "align")},  # type: ignore[misc]
        known={key: options[key] for key in _KNOWN},  # type: ignore[misc]
        reference=_reference(options),
        monte_carlo={"draws": options["draws"], "seed": options["seed"]},
        tell=silent if options["quiet"] else note,
    )
    folder = options["output"] / f"{files[0].name.split('.')[0]}-velocity"
    found.write(folder)
    if not options["quiet"]:
        tables = [frame_text(found.runs), "", frame_text(found.budget)]
        click.echo("\n".join([*tables, "", found.words, f"{folder / 'velocity.png'}"]))


_KNOWN = (
    "gravity", "gravity_uncertainty", "tilt_change", "unevenness", "axle_distance",
    "nonlinearity", "interval_uncertainty", "time_errors", "tilt_order",
)  # fmt: skip


def _reference(options: _Options) -> ReferenceOptions:
    return {
        "columns": options["reference"],
        "files": options["reference_file"],
        "wheel_radius": options["wheel_radius"],
        "ticks_per_turn": options["ticks_per_turn"],
        "uncertainty": options["reference_uncertainty"],
    }


COMMAND = Command("velocity", velocity)
