"""``mcsim linearity``: the shaker test of an accelerometer."""

from __future__ import annotations

from pathlib import Path

import click

from mcsim.cli.command import Command
from mcsim.cli.notes import note
from mcsim.cli.options import FILE, NO_SUMMARY, SIMULATION_SEED, output

#: Scale factors that a sensor may have.
_SENSITIVITIES = (0.2, 5.0)


@click.command()
@FILE
@click.option("--full-scale", help="Range of the sensor, such as 15 g; a scenario brings its own.")
@click.option(
    "--mxx",
    type=click.FloatRange(*_SENSITIVITIES),
    help="M0's element of a six-position test, for Eq. (34); a scenario brings its own.",
)
@SIMULATION_SEED
@output("a folder named after the file is made")
@NO_SUMMARY
def linearity(
    file: Path,
    full_scale: str | None,
    mxx: float | None,
    seed: int,
    output: Path,
    quiet: bool,
) -> None:
    """Shaker test: straight line and non-linearity of an accelerometer.

    FILE is a CSV with the columns reference and measured (amplitudes in g, or in the
    unit in brackets), or a
    velocity scenario (YAML) with a block shaker, whose test is simulated.
    """
    from mcsim.api.linearity import linearity as linearity_of

    found = linearity_of(
        file, full_scale=full_scale, mxx=mxx, seed=seed, tell=None if quiet else note
    )
    folder = output / f"{file.stem}-linearity"
    found.write(folder)
    if not quiet:
        click.echo(f"{found.words}\n{folder / 'linearity.png'}")


COMMAND = Command("linearity", linearity)
