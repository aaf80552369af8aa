"""The scenarios of the planar paper's figures, as they are shipped."""

from __future__ import annotations

import re
from pathlib import Path

from mcsim.errors import InputError
from mcsim.scenario import Scenario


def shipped_scenarios() -> Path:
    """The folder of shipped scenarios: inside an installed package, or beside its source."""
    package = Path(__file__).resolve().parent.parent
    for folder in (package / "_scenarios", package.parent / "scenarios"):
        if folder.is_dir():
            return folder
    raise InputError("the shipped scenarios are not installed; reinstall mcsim")


def figure_scenarios(numbers: tuple[str, ...]) -> dict[int, list[Scenario]]:
    """Scenarios by the number of their figure; all figures if none is named.

    Raises
    ------
    InputError
        Not the number of a figure.
    """
    by_number: dict[int, list[Path]] = {}
    for path in sorted((shipped_scenarios() / "paper").glob("figure*.yaml")):
        match = re.match(r"figure(\d+)", path.stem)
        if match:
            by_number.setdefault(int(match[1]), []).append(path)
    wanted = list(by_number)
    if numbers and "all" not in numbers:
        wanted = []
        for text in numbers:
            if not (text.isascii() and text.isdigit()) or int(text) not in by_number:
                known = ", ".join(map(str, by_number))
                raise InputError(f'figures: "{text}" is not one of {known}, all')
            wanted.append(int(text))
    return {
        number: [Scenario.from_yaml(path) for path in by_number[number]]
        for number in dict.fromkeys(wanted)
    }


def title_of(scenarios: list[Scenario]) -> str:
    """The common title of a figure made of several scenarios."""
    return scenarios[0].base.title or ""
