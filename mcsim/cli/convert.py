"""``mcsim convert``: a noise figure or a sensor file from one dialect to the others."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcsim.cli.dialect_options import DialectName, answers
from mcsim.errors import InputError

if TYPE_CHECKING:
    from mcsim.dialects import Assumptions, Description

_NEGATIVE = re.compile(r"-\.?\d")


class _Command(click.Command):
    """A command whose argument may be a negative number: refused as such, not as an option."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        last = ""
        for place, text in enumerate(args):
            # Every option of this command takes a value.
            if _NEGATIVE.match(text) and not last.startswith("--"):
                args = [*args[:place], *args[place + 1 :], "--", text]
                break
            last = text
        return super().parse_args(ctx, args)


@click.command(cls=_Command)
@click.argument("given", metavar="QUANTITY|FILE|SENSOR")
@click.option("--from", "source", type=DialectName("READABLE"), help="Recognised if absent.")
@click.option("--to", "target", type=DialectName("WRITABLE"), help="All of them if absent.")
@click.option(
    "--as", "role", metavar="KEY", help="What a quantity is, where its unit does not say."
)
@click.option(
    "--assume", multiple=True, metavar="KEY=MEANING", help="Answer to what a file leaves open."
)
@click.option("--rate", metavar="'100 Hz'", help="Sampling rate, where it is needed.")
@click.option(
    "--axis",
    type=click.Choice(["x", "y", "z", "largest"]),
    help="For tools with one value for all axes.",
)
def convert(
    given: str,
    source: str | None,
    target: str | None,
    role: str | None,
    assume: tuple[str, ...],
    rate: str | None,
    axis: str | None,
) -> None:
    """Convert noise figures between data sheets, Allan's N, B, K and other tools.

    A quantity ("0.2 °/√h") is shown in all units and dialects, or in the one asked for. A file
    (mcsim sensor file, Kalibr imu.yaml, MATLAB code, gnss-ins-sim, KF-GINS, imu_utils) or a
    built-in sensor is written in the dialect asked for, to standard output.
    """
    from mcsim.dialects import Assumptions
    from mcsim.units import KINDS, parse

    hertz = parse(rate, KINDS["frequency"]) if rate is not None else None
    if hertz is not None and hertz <= 0.0:
        raise InputError(f'--rate "{rate}" must be above zero')
    if not given.strip():
        raise InputError("name a file, a sensor or a quantity such as '0.2 °/√h'")
    assumptions = Assumptions(answers(assume), hertz, axis)
    if not _is_file(given) and _begins_with_number(given):
        click.echo(_quantity(given, role, hertz, target))
        return
    sensor = _sensor(given, source, assumptions)
    click.echo(_written(sensor, target, assumptions), nl=False)


def _is_file(given: str) -> bool:
    try:
        return Path(given).exists()
    except OSError:
        return False


def _begins_with_number(given: str) -> bool:
    return given.strip()[:1] in set("0123456789.+-")


def _quantity(given: str, role: str | None, rate: float | None, target: str | None) -> str:
    from mcsim.cli.tables import columns
    from mcsim.dialects.quantity import convert_quantity

    conversion = convert_quantity(given, role, rate)
    if target is not None:
        conversion = conversion.only(target)
    rows = [[f"  {row.what}", row.values, row.remark] for row in conversion.rows]
    return "\n".join([conversion.meaning, *columns(rows)])


def _sensor(given: str, source: str | None, assumptions: Assumptions) -> Description:
    """The description behind a file's name or a built-in sensor's."""
    from mcsim import catalogue
    from mcsim.dialects import describe_file, read_file
    from mcsim.scenario.document import Document
    from mcsim.scenario.sensor_file import SensorFile
    from mcsim.scenario.validation import validate

    if _is_file(given):
        reading = read_file(Path(given), source, assumptions)
        for note in reading.notes:
            click.echo(f"note: {note}", err=True)
        return reading.description
    if any(sign in given for sign in "/\\.") and given.casefold() not in {
        name.casefold() for name in catalogue.sensors()
    }:
        raise InputError(f"{given}: no such file")
    sensor = catalogue.find(given)
    tree = {"name": sensor.name, **dict.fromkeys(sensor.elements, sensor.name)}
    return describe_file(validate(Document(tree, sensor.name), SensorFile))


def _written(sensor: Description, target: str | None, assumptions: Assumptions) -> str:
    from mcsim.dialects import WRITABLE, write_sensor

    if target is not None:
        return write_sensor(sensor, target, assumptions)
    parts = []
    for name in WRITABLE:
        try:
            parts.append(f"# --to {name}\n{write_sensor(sensor, name, assumptions)}")
        except InputError as error:
            reason = "\n#   ".join(str(error).splitlines())
            parts.append(f"# --to {name} is not possible so:\n#   {reason}\n")
    return "\n".join(parts)
