"""``mcsim budget``: the GUM budget of a velocity scenario, beside Monte Carlo."""

from __future__ import annotations

from pathlib import Path

import click

from mcsim.cli.command import Command
from mcsim.cli.names import refuse_same_names
from mcsim.cli.options import NO_SUMMARY, SCENARIOS, SET, output


@click.command()
@SCENARIOS
@SET
@output("each scenario gets a folder NAME-budget")
@NO_SUMMARY
def budget(
    scenarios: tuple[Path, ...], overrides: tuple[str, ...], output: Path, quiet: bool
) -> None:
    """Uncertainty budget of velocity scenarios, by the law of propagation.

    Writes budget.csv (the rows of the source's Tables 3 and 4 and the totals), shares of the
    variances, and a comparison over time with Monte Carlo, as table, figure and in words.
    Limits of the sensor and of the model that the run reaches are said.
    """
    from mcsim.api.budget import budget as budget_of
    from mcsim.api.budget import check_budget
    from mcsim.scenario_file import Scenario
    from mcsim.text_table import frame_text

    read = [Scenario.from_yaml(path, overrides) for path in scenarios]
    for scenario in read:
        check_budget(scenario)
    refuse_same_names(read)
    for scenario in read:
        found = budget_of(scenario)
        folder = output / f"{scenario.name}-budget"
        found.write(folder)
        if not quiet:
            notes = [f"note: {limit}" for limit in found.course.limits]
            click.echo("\n".join([frame_text(found.table), "", found.words, *notes, f"{folder}/"]))


COMMAND = Command("budget", budget)
