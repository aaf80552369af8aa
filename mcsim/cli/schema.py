"""``mcsim schema``: what scenario files may say, for editors."""

from __future__ import annotations

import click

from mcsim.api.scenario_files import KINDS
from mcsim.cli.command import Command


@click.command()
@click.argument("kind", type=click.Choice(list(KINDS)), default="scenario")
def schema(kind: str) -> None:
    """Print the JSON schema (draft 7) of scenario files."""
    import json

    from mcsim.api.scenario_files import schema as schema_of

    click.echo(json.dumps(schema_of(kind), indent=2))


COMMAND = Command("schema", schema)
