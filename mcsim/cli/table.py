"""``mcsim table``: printed tables of the sources beside what mcsim computes."""

from __future__ import annotations

import click

from mcsim.cli.velocity_paper import velocity_tables


@click.group()
def table() -> None:
    """Tables of the sources: printed, recomputed and simulated values side by side."""


table.add_command(velocity_tables)
