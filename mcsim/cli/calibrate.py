"""``mcsim calibrate``: the six-position test of an accelerometer."""

from __future__ import annotations

import textwrap
from pathlib import Path

import click

from mcsim.cli.command import Command
from mcsim.cli.notes import note
from mcsim.cli.options import FILE, NO_SUMMARY, SIMULATION_SEED, output


@click.command()
@FILE
@click.option(
    "--samples", type=click.IntRange(1, 10_000_000), default=1000, show_default=True,
    help="Simulation: samples per position.",
)  # fmt: skip
@click.option(
    "--repetitions", type=click.IntRange(1, 10_000), default=2, show_default=True,
    help="Simulation: how often the test is made.",
)  # fmt: skip
@click.option(
    "--alignment", default="0.1 °", show_default=True,
    help="Simulation: standard deviation of each position's angles.",
)  # fmt: skip
@SIMULATION_SEED
@output("a folder named after the file is made")
@NO_SUMMARY
def calibrate(
    file: Path,
    samples: int,
    repetitions: int,
    alignment: str,
    seed: int,
    output: Path,
    quiet: bool,
) -> None:
    """Six-position test: matrix and bias of an accelerometer, with uncertainties.

    FILE is a CSV with the columns position (+x, -x … -z: the axis that points up or down), x, y, z
    in g (or the unit in brackets, x [m/s^2]), and perhaps repetition; one row per position, or many
    samples.  A velocity scenario (YAML) instead simulates the test of its sensor.
    """
    from mcsim.api.calibrate import calibrate as calibration_of
    from mcsim.text_table import frame_text

    found = calibration_of(
        file,
        samples=samples,
        repetitions=repetitions,
        alignment=alignment,
        seed=seed,
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
