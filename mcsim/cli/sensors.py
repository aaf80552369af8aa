"""``mcsim sensors``: the built-in sensors."""

from __future__ import annotations

import click

from mcsim.cli.command import Command


@click.command()
@click.argument("name", required=False)
def sensors(name: str | None) -> None:
    """List the built-in sensors, or one of them with its sources."""
    from mcsim.cli.catalogue import sensor_details, sensor_list

    click.echo(sensor_details(name) if name else sensor_list())


COMMAND = Command("sensors", sensors)
