"""The commands of ``mcsim``: another one is a file with a ``COMMAND`` and a line here."""

from __future__ import annotations

from mcsim.cli.command import Command
from mcsim.registry import Registry

COMMANDS: Registry[Command] = Registry(
    "command",
    later={
        name: f"mcsim.cli.{name}:COMMAND"
        for name in (
            "allan",
            "budget",
            "calibrate",
            "characterise",
            "convert",
            "figures",
            "linearity",
            "plot",
            "run",
            "schema",
            "sensors",
            "table",
            "validate",
            "velocity",
            "vibration",
        )
    },
)
