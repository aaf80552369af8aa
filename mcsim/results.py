"""Results of a scenario: the tidy table, histories, sample tracks, provenance."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mcsim.engine import PointResult
from mcsim.errors import InputError
from mcsim.memory import check_memory
from mcsim.over_time import TIME, over_time
from mcsim.provenance import reproducible, time_and_machine
from mcsim.scenario.case import CaseScenario
from mcsim.scenario.error_quantities import UNITS, ErrorRow
from mcsim.scenario_file import Point, Scenario
from mcsim.scenario_file.effect import without_effect
from mcsim.statistics import METHOD
from mcsim.statistics.history import history_statistics
from mcsim.sweep import SweepResult, check_points, describe_point
from mcsim.systems import notes_of, raw_log_of
from mcsim.tracks import drive_notes
from mcsim.units import degrees
from mcsim.version import __version__

if TYPE_CHECKING:
    import pandas as pd

#: Columns of the table after those of the swept paths.
COLUMNS = ("error", "statistic", "value", "ci_low", "ci_high", "unit", "realizations", "note")
_MOST_HISTORY_ROWS = 20_000_000
#: Smaller shares of the variance are rounding.
_LEAST_SHARE = 1e-20
_NUMBER = re.compile(r"\d[\d.,e+-]*")


@dataclass(frozen=True)
class Results:
    """Everything that a run found out.

    Attributes
    ----------
    scenario : Scenario
    table : DataFrame
        One row per point, error and statistic; swept values in the scenario's units.
    provenance : dict
        Scenario as resolved, seed, versions, platform, time, remarks, failures.
    budget : DataFrame or None
        Standard deviation and share of the variance that each source of disturbance
        causes in each error, by the linear model.
    history : DataFrame or None
        Statistics of the errors at every sample, if the scenario asks for them.
    tracks : DataFrame or None
        Reconstructed sample tracks and the true one, if the scenario asks for them.
    runs : DataFrame or None
        Raw runs as the sensor would have recorded them, if the scenario asks for them; not read
        back from a folder.
    """

    scenario: Scenario
    table: pd.DataFrame
    provenance: dict[str, Any]
    budget: pd.DataFrame | None = None
    history: pd.DataFrame | None = None
    tracks: pd.DataFrame | None = None
    runs: pd.DataFrame | None = None

    @property
    def remarks(self) -> list[str]:
        """What a user should know beyond the numbers."""
        return list(self.provenance["remarks"])

    @property
    def failures(self) -> list[str]:
        """Points that failed, with the reason."""
        return list(self.provenance["failures"])


def check(scenario: Scenario) -> None:
    """Refuse, before anything runs, what cannot run or would not fit in memory.

    Raises
    ------
    InputError
        A point's track cannot be built or sampled, or more memory is asked for than there may be.
    """
    counts = check_points(scenario)
    check_memory(scenario, counts)
    outputs = scenario.base.outputs
    if scenario.axes and getattr(outputs, "runs", False):
        raise InputError(
            f"{scenario.document.place(('outputs', 'runs'))}: outputs.runs: raw runs are of one "
            "point; remove the sweep, or leave them out"
        )
    per_error = len(history_statistics())
    per_sample = outputs.tracks + outputs.history * len(scenario.base.ERRORS) * per_error
    rows = per_sample * sum(count + 1 for count in counts)
    if rows > _MOST_HISTORY_ROWS:
        raise InputError(
            f"{scenario.document.place(('outputs',))}: outputs: histories and tracks of "
            f"{scenario.n_points} points need {rows:,} rows, more than {_MOST_HISTORY_ROWS:,}; "
            "sweep fewer points or keep fewer tracks"
        )


def assemble(scenario: Scenario, sweep: SweepResult, seconds: float) -> Results:
    """Turn the points' results into tables."""
    first = getattr(scenario.points[0].model, "trajectory", None)
    told = notes_of(scenario.points[0].model, scenario.folder)
    remarks = [*drive_notes(first, scenario.folder), *told, *_remarks(scenario, sweep)]
    history, tracks = over_time(scenario, sweep)
    return Results(
        scenario=scenario,
        table=_table(scenario, sweep),
        provenance=_provenance(scenario, sweep, remarks, seconds),
        budget=_budget(scenario, sweep),
        history=history,
        tracks=tracks,
        runs=_runs(scenario),
    )


def _runs(scenario: Scenario) -> pd.DataFrame | None:
    """Raw runs of the one point of a scenario, if it asks for them."""
    import pandas as pd

    columns = None if scenario.axes else raw_log_of(scenario.base, scenario.folder)
    return None if columns is None else pd.DataFrame(columns)


def in_table_unit(name: str, value: Any) -> Any:
    """An SI error in the unit of tables."""
    return in_unit_of_tables(UNITS[name], value)


def in_unit_of_tables(unit: str, value: Any) -> Any:
    """An SI value in one of the units of tables."""
    return degrees(value) if unit == "deg" else value


def at_the_end(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of each point's last instant, in tables that hold several."""
    if TIME not in table:
        return table
    # Swept values stand before the time; a swept duration moves a point's last instant.
    swept = list(table.columns[: table.columns.get_loc(TIME)])
    last = table.groupby(swept, sort=False)[TIME].transform("max") if swept else table[TIME].max()
    return table[table[TIME] == last]


def _table(scenario: Scenario, sweep: SweepResult) -> pd.DataFrame:
    import pandas as pd

    rows = [
        row
        for point in scenario.points
        if point.index in sweep.points
        for row in _point_rows(point, sweep.points[point.index])
    ]
    columns = [*coordinate_columns(scenario), *COLUMNS]
    return pd.DataFrame(rows, columns=columns)


def summarised(model: CaseScenario) -> dict[str, str]:
    """The statistics that a single run prints and draws, by name, with their words."""
    shown = {name: s.words for name, s in model.statistics().items() if s.summary}
    return {**shown, METHOD: "method error (no sensor error)"}


def coordinate_columns(scenario: Scenario) -> list[str]:
    """What tells the rows of one error apart: swept values, and the instant if there are some."""
    timed = any(row.time is not None for row in scenario.base.error_rows)
    return [*(axis.column for axis in scenario.axes), *([TIME] if timed else [])]


def _coordinates(point: Point, row: ErrorRow) -> tuple[Any, ...]:
    return point.values if row.time is None else (*point.values, row.time)


def _point_rows(point: Point, result: PointResult) -> Iterator[tuple[Any, ...]]:
    estimates = result.estimates
    for i, row in enumerate(point.model.error_rows):
        missing = bool(np.isnan(result.method[i]))
        note = "; ".join(filter(None, [result.notes.get(row.label, ""), *result.limits]))
        for j, statistic in enumerate((*estimates.statistics, METHOD)):
            if statistic == METHOD:
                numbers = [result.method[i]] * 3
            else:
                numbers = [estimates.value[i, j], estimates.low[i, j], estimates.high[i, j]]
            yield (
                *_coordinates(point, row),
                row.name,
                statistic,
                *(float(in_table_unit(row.name, number)) for number in numbers),
                row.unit,
                result.realizations,
                note if missing or statistic != METHOD else "; ".join(result.limits),
            )


def _budget(scenario: Scenario, sweep: SweepResult) -> pd.DataFrame:
    """One row per point, error and source that disturbs it."""
    import pandas as pd

    rows = []
    for point in scenario.points:
        if point.index not in sweep.points:
            continue
        variances = sweep.points[point.index].variances
        total = np.sum(list(variances.values()), axis=0)
        for i, row in enumerate(point.model.error_rows):
            if np.isnan(sweep.points[point.index].method[i]):
                continue  # an undefined error has no sources
            for source, variance in variances.items():
                if variance[i] > _LEAST_SHARE * total[i]:
                    std = float(in_table_unit(row.name, np.sqrt(variance[i])))
                    share = float(variance[i] / total[i])
                    rows.append((*_coordinates(point, row), row.name, source, std, share, row.unit))
    columns = coordinate_columns(scenario)
    return pd.DataFrame(rows, columns=[*columns, "error", "source", "std", "share", "unit"])


def _remarks(scenario: Scenario, sweep: SweepResult) -> list[str]:
    """Notes of all points, each said once with the number of points that it holds for."""
    affected: dict[str, list[str]] = {}
    for result in sweep.points.values():
        notes = [f"{name}: {note}" for name, note in result.notes.items()]
        for remark in [*notes, *result.limits]:
            # Remarks that differ by their numbers alone are one.
            affected.setdefault(_NUMBER.sub("#", remark), []).append(remark)
    return [
        *without_effect(scenario),
        *(_of_points(remarks, scenario) for remarks in affected.values()),
    ]


def _of_points(remarks: list[str], scenario: Scenario) -> str:
    if not scenario.axes:
        return remarks[0]
    where = f"{len(remarks)} of {scenario.n_points} points"
    if len(set(remarks)) > 1:
        where += ", the first of them quoted"
    return f"{remarks[0]} ({where})"


def _provenance(
    scenario: Scenario, sweep: SweepResult, remarks: list[str], seconds: float
) -> dict[str, Any]:
    return {
        **circumstances(scenario),
        "points": scenario.n_points,
        "points_done": len(sweep.points),
        "realizations": sum(result.realizations for result in sweep.points.values()),
        "failures": [
            f"{describe_point(scenario, scenario.points[index])}: {reason}"
            for index, reason in sweep.failures.items()
        ],
        "remarks": remarks,
        **({} if reproducible() else {"seconds": round(seconds, 3)}),
    }


def circumstances(scenario: Scenario) -> dict[str, Any]:
    """What was computed, with what, and when: the provenance of what follows from a scenario."""
    return {
        "mcsim": __version__,
        "name": scenario.name,
        "seed": scenario.base.monte_carlo.seed,
        "scenario": scenario.document.tree,
        "resolved": scenario.base.model_dump(mode="json", exclude_none=True),
        **time_and_machine(),
    }
