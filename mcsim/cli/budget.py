"""``mcsim budget``: the GUM budget of a velocity scenario, beside Monte Carlo."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from mcsim.cli.names import refuse_same_names
from mcsim.errors import InputError

if TYPE_CHECKING:
    from mcsim.scenario_file import Scenario


@click.command()
@click.argument("scenarios", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--set", "overrides", multiple=True, metavar="PATH=VALUE", help="Replace a value.")
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    default=Path("output"),
    show_default=True,
    help="Folder for results; each scenario gets a folder NAME-budget inside.",
)
@click.option("--quiet", is_flag=True, help="No summary.")
def budget(
    scenarios: tuple[Path, ...], overrides: tuple[str, ...], output: Path, quiet: bool
) -> None:
    """Uncertainty budget of velocity scenarios, by the law of propagation.

    Writes budget.csv (the rows of the source's Tables 3 and 4 and the totals), shares of the
    variances, and a comparison over time with Monte Carlo, as table, figure and in words.
    Limits of the sensor and of the model that the run reaches are said.
    """
    from mcsim.scenario_file import Scenario
    from mcsim.systems.velocity.scenario import VelocityScenario

    read = [Scenario.from_yaml(path, overrides) for path in scenarios]
    for path, scenario in zip(scenarios, read, strict=True):
        if not isinstance(scenario.base, VelocityScenario):
            raise InputError(
                f"{path}: case: a budget needs `case: velocity`, not {scenario.base.case}"
            )
        if scenario.axes:
            raise InputError(f"{path}: sweep: a budget is of one point; remove the sweep")
        if scenario.base.runs < 2:
            raise InputError(f"{path}: runs: Eq. (31) compares repeated runs; write at least 2")
        if scenario.base.budget is None:
            raise InputError(
                f"{path}: budget: is missing; write `budget: {{output: …, rest_x: …, rest_z: …}}`"
            )
    refuse_same_names(read)
    for scenario in read:
        words = write_budget(scenario, output / f"{scenario.name}-budget")
        if not quiet:
            click.echo(words)


def write_budget(scenario: Scenario, folder: Path) -> str:
    """Compute and write everything of one scenario; what to tell the user."""
    from mcsim.cli.tables import budget_summary
    from mcsim.figures import write_figure
    from mcsim.figures.budget import draw_comparison, draw_shares
    from mcsim.gum import course_of_uncertainty, step_budget
    from mcsim.gum.tables import budget_table, comparison_table
    from mcsim.gum.words import comparison_words
    from mcsim.results import circumstances
    from mcsim.store import write_provenance, write_table, write_text
    from mcsim.systems.velocity.scenario import VelocityScenario

    model = scenario.base
    assert isinstance(model, VelocityScenario)  # checked by the command
    budget, course = step_budget(model), course_of_uncertainty(model)
    table, words = budget_table(budget, course), comparison_words(course)
    title = scenario.base.title or scenario.name
    write_table(table, folder, "budget")
    write_table(comparison_table(course), folder, "comparison")
    write_text(words, folder, "comparison.txt")
    write_provenance({**circumstances(scenario), "remarks": list(course.limits)}, folder)
    outputs: tuple[Literal["Dv", "acx"], ...] = ("Dv", "acx")
    for output in outputs:
        shares = draw_shares([budget], [scenario.name], output, f"{title}: variance of {output}")
        write_figure(shares, folder, f"shares-{output.lower()}")
    write_figure(draw_comparison(course, title), folder, "comparison")
    notes = [f"note: {limit}" for limit in course.limits]
    return "\n".join([budget_summary(table), "", words, *notes, f"{folder}/"])
