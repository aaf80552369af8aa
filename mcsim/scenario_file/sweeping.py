"""Sweeps on a command line: ``sensors.rate=20..1000 Hz:9 log``, instead of those of a file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from mcsim.errors import InputError
from mcsim.scenario.document import parse_scalar
from mcsim.scenario_file.scenario import Scenario

#: Points of a range that says none.
POINTS = 9
_RANGE = re.compile(r"(?P<from>.+?)\.\.(?P<to>.+?)(?::\s*(?P<points>\d+))?(?P<log>\s+log)?")
_NUMBER = re.compile(r"[-+−]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_FORM = (
    '--sweep "{text}": write path=from..to or path=[…], for example "sensors.rate=20..1000 Hz:9 '
    'log" or "reconstruction.integration=[rectangular, trapezoidal]"'
)


def swept_anew(scenario: Scenario, sweeps: Sequence[str], as_map: bool = False) -> Scenario:
    """The scenario with other sweeps, and drawn as a map if asked for.

    Parameters
    ----------
    scenario : Scenario
    sweeps : sequence of str
        ``path=from..to``, then perhaps ``:points`` and ``log``, or ``path=[value, value]``, the
        first on the horizontal axis.  Without any the scenario keeps its own.
    as_map : bool
        Whether a map of two of them is wanted.

    Raises
    ------
    InputError
        Not of that form, no such path, or a map of fewer than two sweeps.
    """
    values: dict[str, Any] = {}
    if sweeps:
        values["sweep"] = None
        # Panels name axes of the file's own sweep, and the second line of the title tells of it.
        figure = scenario.document.tree.get("figure") or {}
        if figure.get("title"):
            values["figure.title"] = None
        if panels := figure.get("panels"):
            values["figure.panels"] = [{"errors": panel["errors"]} for panel in panels]
    for text in sweeps:
        path, value = _parsed(text)
        if f"sweep.{path}" in values:
            raise InputError(f"--sweep {path}: is given twice")
        values[f"sweep.{path}"] = value
    if as_map:
        values["figure.map"] = True
    found = scenario.with_values(values) if values else scenario
    if as_map and not found.axes:
        raise InputError(
            f"--map: {scenario.name} sweeps nothing; add two of `--sweep path=from..to`"
        )
    return found


def _parsed(text: str) -> tuple[str, Any]:
    path, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not path or not value:
        raise InputError(_FORM.format(text=text))
    if value.startswith(("[", "{")):
        return path, parse_scalar(value, f"--sweep {path}")
    match = _RANGE.fullmatch(value)
    if match is None:
        raise InputError(_FORM.format(text=text))
    first, last = match["from"].strip(), match["to"].strip()
    if _NUMBER.fullmatch(first) and (number := _NUMBER.match(last)):
        # The unit that both have stands at the second alone.
        first = f"{first}{last[number.end() :]}"
    place = f"--sweep {path}"
    return path, {
        "from": parse_scalar(first, place),
        "to": parse_scalar(last, place),
        "points": int(match["points"] or POINTS),
        "scale": "log" if match["log"] else "linear",
    }
