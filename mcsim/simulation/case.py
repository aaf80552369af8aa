"""What the package knows of a case: one object, listed in ``mcsim.systems``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcsim.scenario.case import CaseScenario
from mcsim.scenario.error_quantities import ErrorQuantity
from mcsim.scenario.idle import IdleKey
from mcsim.scenario.rules import Rules
from mcsim.simulation.problem import Problem


def _no_notes(_: Any, __: Path) -> tuple[str, ...]:
    return ()


@dataclass(frozen=True)
class Case:
    """A system that can be simulated: its scenario block, its truth and its problem.

    Attributes
    ----------
    name : str
        What scenarios write after ``case:``.
    scenario : type
        The validated model of its scenarios; says its errors and percentiles.
    problem : callable
        ``problem(model, folder) -> Problem`` of a validated point; relative files are looked up in
        ``folder``.  Raises InputError where the point cannot run.
    samples : callable
        ``samples(model, folder) -> int``, samples of a realization; refuses what cannot run as
        ``problem`` does, without preparing it.
    quantities : tuple of ErrorQuantity
        Errors that no other case has.
    idle : tuple of IdleKey
        Keys that change nothing in some of its scenarios.
    rules : Rules, optional
        Its rules of integration, where users may add their own, and
    kernel : callable, optional
        ``kernel() -> type``, the kernel system that own rules are derived from.
    notes : callable
        ``notes(model, folder)``: what a user should know of where the truth comes from.
    raw_log : callable, optional
        ``raw_log(model, folder) -> {title: values}``, what its sensors would have recorded, where
        the scenario asks for it; None where it does not.
    """

    name: str
    scenario: type[CaseScenario]
    problem: Callable[[Any, Path], Problem]
    samples: Callable[[Any, Path], int]
    quantities: tuple[ErrorQuantity, ...] = ()
    idle: tuple[IdleKey, ...] = ()
    rules: Rules | None = None
    kernel: Callable[[], type[Any]] | None = None
    notes: Callable[[Any, Path], tuple[str, ...]] = _no_notes
    raw_log: Callable[[Any, Path], Mapping[str, Any] | None] | None = None
