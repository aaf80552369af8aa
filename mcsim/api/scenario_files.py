"""``mcsim.validate`` and ``mcsim.schema``: the kinds of scenario files, checked and described."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcsim.registry import Registry


@dataclass(frozen=True)
class Validity:
    """What is said of a file that is valid.

    Attributes
    ----------
    points : int or None
        Of its sweep, if it is of a kind that has one.
    notes : tuple of str
        What the file says without effect.
    """

    points: int | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class ScenarioKind:
    """A kind of scenario file.

    Attributes
    ----------
    name : str
        What ``mcsim schema`` calls it.
    check : callable
        ``check(path) -> Validity`` refuses what is not valid.
    schema : callable
        Its JSON schema (draft 7).
    recognises : callable, optional
        Whether a file is of this kind; absent: what is of no other.
    """

    name: str
    check: Callable[[Path], Validity]
    schema: Callable[[], dict[str, Any]]
    recognises: Callable[[Path], bool] | None = None


def _check_simulation(path: Path) -> Validity:
    from mcsim.results import check
    from mcsim.scenario_file import Scenario
    from mcsim.scenario_file.effect import without_effect

    scenario = Scenario.from_yaml(path)
    check(scenario)
    return Validity(scenario.n_points, tuple(without_effect(scenario)))


def _simulation_schema() -> dict[str, Any]:
    from mcsim.scenario_file.schema import scenario_schema

    return scenario_schema()


def _is_vibration(path: Path) -> bool:
    from mcsim.vibration.scenario import is_vibration

    return is_vibration(path)


def _check_vibration(path: Path) -> Validity:
    from mcsim.vibration.scenario import read_vibration

    read_vibration(path)
    return Validity()


def _vibration_schema() -> dict[str, Any]:
    from mcsim.vibration.scenario import vibration_schema

    return vibration_schema()


#: What they need is imported when they are used.
KINDS: Registry[ScenarioKind] = Registry(
    "kind of scenario file",
    [
        ScenarioKind("scenario", _check_simulation, _simulation_schema),
        ScenarioKind("vibration", _check_vibration, _vibration_schema, _is_vibration),
    ],
)


def validate(file: str | Path) -> Validity:
    """Check a scenario file without running it.

    Parameters
    ----------
    file : path
        A scenario (YAML) of a run or of a vibration.

    Returns
    -------
    Validity
        ``points`` of its sweep, and ``notes`` on what it says without effect.

    Raises
    ------
    InputError
        Not readable or not valid; one line per problem.
    """
    path = Path(file)
    for kind in KINDS.values():
        if kind.recognises is not None and kind.recognises(path):
            return kind.check(path)
    return next(kind for kind in KINDS.values() if kind.recognises is None).check(path)


def schema(kind: str = "scenario") -> dict[str, Any]:
    """The JSON schema (draft 7) of a kind of scenario files.

    Parameters
    ----------
    kind : str
        ``scenario`` or ``vibration``.

    Returns
    -------
    dict
        As ``json.dumps`` writes it; parts of one's own are in it.

    Raises
    ------
    InputError
        No such kind.
    """
    return KINDS.find(kind).schema()
