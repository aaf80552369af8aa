"""The scenarios of the planar paper's figures, as they are shipped."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from mcsim.errors import InputError

if TYPE_CHECKING:
    from mcsim.scenario_file import Scenario

#: Shipped scenarios that belong to no numbered figure.
GROUPS = ("strapdown", "velocity", "vibration")


def shipped_scenarios() -> Path:
    """The folder of shipped scenarios: inside an installed package, or beside its source."""
    package = Path(__file__).resolve().parent.parent
    for folder in (package / "_scenarios", package.parent / "scenarios"):
        if folder.is_dir():
            return folder
    raise InputError("the shipped scenarios are not installed; reinstall mcsim")


def _planar_figures() -> dict[int, list[Path]]:
    """Files of the planar paper's figures, by number."""
    by_number: dict[int, list[Path]] = {}
    for path in sorted((shipped_scenarios() / "paper").glob("figure*.yaml")):
        match = re.match(r"figure(\d+)", path.stem)
        if match:
            by_number.setdefault(int(match[1]), []).append(path)
    return by_number


def figure_numbers(asked: tuple[str, ...], others: Iterable[int]) -> list[int]:
    """The numbers asked for, each once; all of the planar figures and of ``others`` if none is.

    Raises
    ------
    InputError
        Not the number of a figure.
    """
    known = [*_planar_figures(), *others]
    if not asked or "all" in asked:
        return known
    numbers = [text for text in asked if text not in GROUPS]
    for text in numbers:
        if not (text.isascii() and text.isdigit()) or int(text) not in known:
            names = ", ".join([*map(str, known), *GROUPS])
            raise InputError(f'figures: "{text}" is not one of {names}, all')
    return list(dict.fromkeys(map(int, numbers)))


def shipped(group: str) -> list[Scenario]:
    """The shipped sweeps of a folder, in the order of their names."""
    from mcsim.scenario_file import Scenario

    paths = sorted((shipped_scenarios() / group).glob("*.yaml"))
    scenarios = [Scenario.from_yaml(path) for path in paths]
    return [scenario for scenario in scenarios if scenario.axes]


def figure_scenarios(numbers: Iterable[int]) -> dict[int, list[Scenario]]:
    """Scenarios of those of the figures that belong to the planar paper."""
    from mcsim.scenario_file import Scenario

    files = _planar_figures()
    return {
        number: [Scenario.from_yaml(path) for path in files[number]]
        for number in numbers
        if number in files
    }


def title_of(scenarios: list[Scenario]) -> str:
    """The common title of a figure made of several scenarios."""
    return scenarios[0].base.title or ""
