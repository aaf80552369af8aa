"""The shipped scenarios."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mcsim.errors import InputError

if TYPE_CHECKING:
    from mcsim.scenario_file import Scenario
    from mcsim.systems.velocity.scenario import VelocityScenario

#: The two accelerometers of the velocity paper, as their scenarios are named.
VELOCITY_SENSORS = ("a1", "a2")


def shipped_scenarios() -> Path:
    """The folder of shipped scenarios: inside an installed package, or beside its source."""
    package = Path(__file__).resolve().parent.parent
    for folder in (package / "_scenarios", package.parent / "scenarios"):
        if folder.is_dir():
            return folder
    raise InputError("the shipped scenarios are not installed; reinstall mcsim")


def scenarios_of(group: str, pattern: str = "*.yaml") -> list[Scenario]:
    """The scenarios of a folder whose names fit a pattern, in the order of their names."""
    from mcsim.scenario_file import Scenario

    return [
        Scenario.from_yaml(path) for path in sorted((shipped_scenarios() / group).glob(pattern))
    ]


def velocity_sensor(name: str, **overrides: str) -> tuple[Scenario, VelocityScenario]:
    """The scenario of one of ``VELOCITY_SENSORS``; in names of values ``__`` stands for a dot."""
    from mcsim.scenario_file import Scenario
    from mcsim.systems.velocity.scenario import VelocityScenario

    path = shipped_scenarios() / "velocity" / f"{name}.yaml"
    scenario = Scenario.from_yaml(path, {k.replace("__", "."): v for k, v in overrides.items()})
    assert isinstance(scenario.base, VelocityScenario)
    return scenario, scenario.base
