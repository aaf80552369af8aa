"""What a scenario would run, in words: ``mcsim run --dry-run``."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mcsim.scenario_file import Scenario


def plan(scenario: Scenario) -> str:
    """Points, realizations, axes and samples."""
    from mcsim.systems import problem_of

    settings = scenario.base.monte_carlo
    count = (
        f"{settings.realizations:,} realizations"
        if settings.realizations
        else f"up to {settings.most_realizations:,} realizations"
    )
    lines = [f"{scenario.name}: {scenario.n_points} point(s), {count} each"]
    for axis in scenario.axes:
        first, last = axis.written(axis.values[0]), axis.written(axis.values[-1])
        lines.append(f"  {axis.path}: {len(axis.values)} value(s), {first} … {last}")
    problem = problem_of(scenario.points[0].model, scenario.folder)
    lines.append(f"  {problem.n_samples} samples per realization at the first point")
    return "\n".join(lines)
