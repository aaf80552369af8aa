"""``mcsim calibrate``: an accelerometer from its positions at rest."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

import click

from mcsim.cli.command import Command
from mcsim.cli.dialect_options import Hertz
from mcsim.cli.notes import note
from mcsim.cli.options import FILE, NO_SUMMARY, SIMULATION_SEED, output

if TYPE_CHECKING:
    from mcsim.api.calibrate import Positions


class _Options(TypedDict):
    positions: Positions
    weighted: bool
    rate: float | None
    rest: float
    samples: int
    repetitions: int
    alignment: str
    count: int
    seed: int


@click.command()
@FILE
@click.option(
    "--positions", type=click.Choice(["six", "arbitrary", "rests"]), default="six",
    show_default=True,
    help="The six along the axes; ten or more in any direction, by the norm of gravity; or the "
    "rests in one log of a sensor that is turned about.",
)  # fmt: skip
@click.option("--weighted", is_flag=True, help="Six positions: weight each by its own uncertainty.")
@click.option(
    "--rate", type=Hertz(), metavar="HZ", help="Rests: sampling rate of a log without time."
)
@click.option(
    "--rest", type=click.FloatRange(0.5, 3600.0), default=2.0, show_default=True, metavar="S",
    help="Rests: the shortest that counts.",
)  # fmt: skip
@click.option(
    "--samples", type=click.IntRange(1, 10_000_000), default=1000, show_default=True,
    help="Simulation: samples per position.",
)  # fmt: skip
@click.option(
    "--repetitions", type=click.IntRange(1, 10_000), default=2, show_default=True,
    help="Simulation of six: how often the test is made.",
)  # fmt: skip
@click.option(
    "--alignment", default="0.1 °", show_default=True,
    help="Simulation of six: standard deviation of each position's angles.",
)  # fmt: skip
@click.option(
    "--count", type=click.IntRange(1, 10_000), default=24, show_default=True,
    help="Simulation of arbitrary ones: how many.",
)  # fmt: skip
@SIMULATION_SEED
@output("a folder named after the file is made")
@NO_SUMMARY
def calibrate(file: Path, output: Path, quiet: bool, **options: Unpack[_Options]) -> None:
    """Matrix and bias of an accelerometer from its positions at rest, with uncertainties.

    FILE is a CSV with the columns position (+x, -x … -z: the axis that points up or down), x, y, z
    in g (or the unit in brackets, x [m/s^2]), and perhaps repetition; one row per position, or many
    samples.  With --positions arbitrary positions have any names, or none and each row is one;
    with --positions rests FILE is a log.  A velocity scenario (YAML) instead simulates the test of
    its sensor.

    Norms tell nine of twelve parameters: the correction is symmetric, a rotation of the sensor
    in its housing stays unknown.
    """
    from mcsim.api.calibrate import calibrate as calibration_of
    from mcsim.text_table import frame_text

    found = calibration_of(
        file,
        positions=options["positions"],
        weighted=options["weighted"],
        samples=options["samples"],
        repetitions=options["repetitions"],
        alignment=options["alignment"],
        count=options["count"],
        seed=options["seed"],
        rate=options["rate"],
        shortest_rest=options["rest"],
        tell=None if quiet else note,
    )
    folder = output / f"{file.stem}-calibration"
    found.write(folder)
    if not quiet:
        click.echo(frame_text(found.table))
        click.echo("\n".join(textwrap.wrap(found.words, 100)))
        largest = abs(found.fit.residuals).max()
        click.echo(f"largest residual {largest:.2g} g\n{folder / 'calibration.yaml'}")


COMMAND = Command("calibrate", calibrate)
