"""``mcsim table``: printed tables of the sources beside what mcsim computes."""

from __future__ import annotations

import click

from mcsim.cli.bias_table import bias_tracking
from mcsim.cli.gravity_leakage import gravity_leakage
from mcsim.cli.sensor_table import sensor_table_command
from mcsim.cli.velocity_paper import velocity_tables


@click.group()
def table() -> None:
    """Tables of the sources: printed, recomputed and simulated values side by side."""


for command in (bias_tracking, gravity_leakage, sensor_table_command, velocity_tables):
    table.add_command(command)
