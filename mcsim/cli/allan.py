"""``mcsim allan``: plans, theory, densities and deviations of Allan analysis."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcsim.cli.command import Command
from mcsim.cli.log_options import log_options, read_options
from mcsim.cli.options import NO_SUMMARY

if TYPE_CHECKING:
    from mcsim.api.found import Found

_ELEMENT = click.option(
    "--element",
    type=click.Choice(["accelerometer", "gyroscope"]),
    help="Of the sensor; both if absent.",
)
_AXIS = click.option("--axis", type=click.Choice(["x", "y", "z"]), help="One axis only.")
_COLUMN = click.option("--column", metavar="TITLE", help="Of a table where several would fit.")
_CHANNEL = click.option("--channel", metavar="NAME", help="Of a table with several, accel_x ….")
_GIVEN_OUTPUT = click.option(
    "--output",
    type=click.Path(path_type=Path),
    help="Folder for tables and picture; nothing is written if absent.",
)


class _Words(click.ParamType[tuple[str, ...]]):
    """Words between commas."""

    name = "words"

    def convert(self, value: Any, param: object, ctx: object) -> tuple[str, ...]:
        del param, ctx
        if isinstance(value, tuple):
            return value
        return tuple(word.strip() for word in str(value).split(",") if word.strip())


@click.group()
def allan() -> None:
    """Allan analysis: plan a test, theory of its terms, densities, deviations of a log."""


COMMAND = Command("allan", allan)


@allan.command()
@click.option("--sensor", required=True, metavar="NAME|FILE", help="Built-in, or a sensor file.")
@click.option(
    "--accuracy", default="10 %", show_default=True, help="Standard error of the coefficients."
)
@click.option("--terms", type=_Words(), help="Of N,B,K,Tc; all that the sensor has if absent.")
@click.option("--rate", metavar="'100 Hz'", help="Of the log; what the sensor asks for if absent.")
@_ELEMENT
@_AXIS
@_GIVEN_OUTPUT
@NO_SUMMARY
def plan(sensor: str, output: Path | None, quiet: bool, **options: Any) -> None:
    """Plan a test: how long and at which rate, for N, B, K and Tc to so many per cent.

    Eqs. (3.24) and (3.25) of the thesis where each coefficient is read, and beside them what a fit
    of the whole curve attains.
    """
    from mcsim.api.allan import plan as plan_of

    _show(plan_of(sensor, **options), output, quiet)


@allan.command()
@click.argument("sensor", required=False)
@_ELEMENT
@_AXIS
@_GIVEN_OUTPUT
@NO_SUMMARY
def curves(sensor: str | None, output: Path | None, quiet: bool, **options: Any) -> None:
    """Theoretical Allan deviation of each term, or of the terms of a SENSOR together.

    Without a SENSOR (built-in, or a sensor file) the terms themselves: Figures 3.2 to 3.7.
    """
    from mcsim.api.allan import curves as curves_of

    _show(curves_of(sensor, **options), output, quiet)


@allan.command("from-density")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--sides", type=click.Choice(["one", "two"]), help="One- or two-sided, where no title says it."
)
@_COLUMN
@_CHANNEL
@_GIVEN_OUTPUT
@NO_SUMMARY
def from_density(file: Path, output: Path | None, quiet: bool, **options: Any) -> None:
    """Allan deviation of a power spectral density, by the integral of Eq. (3.12).

    FILE is a table with units in its header, such as psd.csv of mcsim characterise:
    "frequency [Hz],one-sided density [(m/s²)²/Hz]".
    """
    from mcsim.api.allan import from_density as curve_of

    _show(curve_of(file, **options), output, quiet)


@allan.command("to-density")
@click.argument("given", metavar="SENSOR|ALLAN.csv")
@click.option("--terms", type=_Words(), help="Of a table: Q,N,B,K,R,GM; N,B,K if absent.")
@_COLUMN
@_CHANNEL
@_ELEMENT
@_AXIS
@_GIVEN_OUTPUT
@NO_SUMMARY
def to_density(given: str, output: Path | None, quiet: bool, **options: Any) -> None:
    """Power spectral density of a sensor's noise terms, or of those fitted to an Allan curve.

    An Allan curve does not determine its density; the fit of non-negative terms does.
    """
    from mcsim.api.allan import to_density as density_of

    _show(density_of(given, **options), output, quiet)


@allan.command()
@click.argument("log", type=click.Path(path_type=Path))
@click.option(
    "--deviation",
    "kinds",
    type=_Words(),
    default="oadev,mdev,hdev,totdev",
    show_default=True,
    help="Of adev, oadev, mdev, hdev, totdev, welch.",
)
@click.option("--confidence", default="68.27 %", show_default=True, help="Of the intervals.")
@log_options
@_GIVEN_OUTPUT
@NO_SUMMARY
def deviations(
    log: Path,
    kinds: tuple[str, ...],
    confidence: str,
    output: Path | None,
    quiet: bool,
    **options: Any,
) -> None:
    """Modified, Hadamard and total deviation of a static LOG beside its Allan deviation."""
    from mcsim.api.allan import deviations as deviations_of

    read = read_options(options)
    _show(deviations_of(log, kinds, read=read, confidence=confidence), output, quiet)


def _show(found: Found, output: Path | None, quiet: bool) -> None:
    """Print what was found, and write it where a folder is named."""
    if not quiet:
        click.echo(found.text)  # type: ignore[attr-defined]
    if output is not None:
        files = found.write(output)
        if not quiet:
            click.echo(", ".join(str(file) for file in files))
