"""``mcsim table``: tables of the sources, printed and recomputed beside each other."""

from __future__ import annotations

import click

from mcsim.cli.gravity_leakage import gravity_leakage


@click.group()
def table() -> None:
    """Recompute a table of the sources."""


table.add_command(gravity_leakage)
