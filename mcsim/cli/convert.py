"""``mcsim convert``: a noise figure or a sensor file from one dialect to the others."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import click

from mcsim.cli.command import Command
from mcsim.cli.dialect_options import DialectName, answers
from mcsim.cli.notes import note
from mcsim.errors import InputError

if TYPE_CHECKING:
    from mcsim.api.convert import Translation
    from mcsim.dialects.quantity import Conversion

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
@click.option("--from", "source", type=DialectName("readable"), help="Recognised if absent.")
@click.option("--to", "target", type=DialectName("writable"), help="All of them if absent.")
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
    from mcsim.api.convert import convert as translation_of
    from mcsim.api.convert import convert_quantity, is_file
    from mcsim.units import KINDS, parse

    hertz = parse(rate, KINDS["frequency"]) if rate is not None else None
    if hertz is not None and hertz <= 0.0:
        raise InputError(f'--rate "{rate}" must be above zero')
    if not given.strip():
        raise InputError("name a file, a sensor or a quantity such as '0.2 °/√h'")
    if not is_file(given) and _begins_with_number(given):
        click.echo(_quantity(convert_quantity(given, target, role=role, rate=hertz)))
        return
    found = translation_of(
        given, target, source=source, assume=answers(assume), rate=hertz, axis=axis
    )
    for text in found.notes:
        note(text)
    click.echo(found.texts[target] if target is not None else _all(found), nl=False)


COMMAND = Command("convert", convert)


def _begins_with_number(given: str) -> bool:
    return given.strip()[:1] in set("0123456789.+-")


def _quantity(conversion: Conversion) -> str:
    from mcsim.text_table import columns

    rows = [[f"  {row.what}", row.values, row.remark] for row in conversion.rows]
    return "\n".join([conversion.meaning, *columns(rows)])


def _all(found: Translation) -> str:
    """Every dialect under its name, or why it cannot be written."""
    from mcsim.dialects import writable

    parts = []
    for name in writable():
        if name in found.texts:
            parts.append(f"# --to {name}\n{found.texts[name]}")
        else:
            reason = "\n#   ".join(found.refused[name].splitlines())
            parts.append(f"# --to {name} is not possible so:\n#   {reason}\n")
    return "\n".join(parts)
