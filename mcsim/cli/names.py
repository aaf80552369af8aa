"""Scenarios of one command must not share a folder of results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mcsim.errors import InputError

if TYPE_CHECKING:
    from mcsim.scenario_file import Scenario


def refuse_same_names(scenarios: list[Scenario]) -> None:
    names = [scenario.name for scenario in scenarios]
    for name in names:
        if names.count(name) > 1:
            raise InputError(
                f"two scenarios are named {name}; their results would share a folder: "
                "rename one, or run them with different --output"
            )
