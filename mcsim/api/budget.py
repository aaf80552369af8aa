"""``mcsim.budget``: the GUM budget of a velocity scenario, beside Monte Carlo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from mcsim.api.found import Found
from mcsim.errors import InputError
from mcsim.gum import Budget, Course, course_of_uncertainty, step_budget
from mcsim.gum.tables import budget_table, comparison_table
from mcsim.gum.words import comparison_words
from mcsim.report import Report
from mcsim.results import circumstances
from mcsim.scenario_file import Scenario
from mcsim.systems.velocity.scenario import VelocityScenario

if TYPE_CHECKING:
    import pandas as pd

_OUTPUTS: tuple[Literal["Dv", "acx"], ...] = ("Dv", "acx")


@dataclass(frozen=True)
class UncertaintyBudget(Found):
    """The uncertainty of a velocity scenario, by propagation and by Monte Carlo.

    Attributes
    ----------
    scenario : Scenario
    step : mcsim.gum.Budget
        The 26 rows of one step.
    course : mcsim.gum.Course
        Standard uncertainties of the velocity after every step (m/s), arrays (n + 1,).
    """

    scenario: Scenario
    step: Budget
    course: Course

    @property
    def table(self) -> pd.DataFrame:
        """The 26 rows and the totals: columns ``mcsim.gum.tables.BUDGET_COLUMNS``."""
        return budget_table(self.step, self.course)

    @property
    def comparison(self) -> pd.DataFrame:
        """Columns ``time [s], method, of, source, uncertainty [m/s]``."""
        return comparison_table(self.course)

    @property
    def words(self) -> str:
        """What the comparison says."""
        return comparison_words(self.course)

    def report(self) -> Report:
        """Files ``budget``, ``comparison``, ``shares-dv`` and ``shares-acx``."""
        from mcsim.figures.budget import draw_comparison, draw_shares
        from mcsim.figures.style import printed

        title = self.scenario.base.title or self.scenario.name
        pictures = printed(draw_comparison(self.course, title), "comparison")
        for output in _OUTPUTS:
            of = f"{title}: variance of {output}"
            shares = draw_shares([self.step], [self.scenario.name], output, of)
            pictures |= printed(shares, f"shares-{output.lower()}")
        return Report(
            provenance=self._provenance(),
            tables={"budget": self.table, "comparison": self.comparison},
            pictures=pictures,
            texts={"comparison.txt": self.words},
        )

    def _provenance(self) -> dict[str, Any]:
        told = circumstances(self.scenario)
        return {**told, "command": "budget", "remarks": list(self.course.limits)}


def budget(scenario: Scenario) -> UncertaintyBudget:
    """Propagate a velocity scenario's uncertainties through a step and over its run.

    Parameters
    ----------
    scenario : Scenario
        Of ``case: velocity``, with a block ``budget``, without a sweep.

    Returns
    -------
    UncertaintyBudget
        ``table`` (the 26 rows of a step) and ``comparison`` (uncertainty of the velocity over time,
        m/s, by method), with ``words`` and ``write(folder)``.

    Raises
    ------
    InputError
        Another case, a sweep, a single run, no block ``budget``, or a run that cannot be sampled.
    """
    model = check_budget(scenario)
    course = course_of_uncertainty(model, folder=scenario.folder)
    return UncertaintyBudget(scenario, step_budget(model), course)


def check_budget(scenario: Scenario) -> VelocityScenario:
    """The scenario's model, if it has a budget.

    Raises
    ------
    InputError
        Another case, a sweep, a single run, or no block ``budget``.
    """
    model, source = scenario.base, scenario.document.source
    if not isinstance(model, VelocityScenario):
        raise InputError(f"{source}: case: a budget needs `case: velocity`, not {model.case}")
    if scenario.axes:
        raise InputError(f"{source}: sweep: a budget is of one point; remove the sweep")
    if model.runs < 2:
        raise InputError(f"{source}: runs: Eq. (31) compares repeated runs; write at least 2")
    if model.budget is None:
        raise InputError(
            f"{source}: budget: is missing; write `budget: {{output: …, rest_x: …, rest_z: …}}`"
        )
    return model
