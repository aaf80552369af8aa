"""Histories and sample tracks of a scenario's points: the errors at every sample.

Histories hold at most ``HISTORY_REALIZATIONS`` realizations, the first of those that the table
is estimated from.  The table may know more: it may have more realizations, or control variates.
What it knows of the end is carried back in time.  So a history ends in its table.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mcsim.engine import PointResult, point_key
from mcsim.estimation import LOOKED_AT, takes_nets
from mcsim.memory import HISTORY_REALIZATIONS, history_realizations
from mcsim.scenario.error_quantities import UNITS
from mcsim.scenario_file import Point, Scenario
from mcsim.simulation.problem import History
from mcsim.statistics.collector import cell_size
from mcsim.statistics.history import carry_back, values_over_time
from mcsim.sweep import SweepResult
from mcsim.systems import problem_of
from mcsim.units import degrees

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: The column of the instant, in tables that hold several.
TIME = "time [s]"


def over_time(
    scenario: Scenario, sweep: SweepResult
) -> tuple[pd.DataFrame | None, pd.DataFrame | None]:
    """Histories and sample tracks of every point that has results, if asked for."""
    import pandas as pd

    outputs = scenario.base.outputs
    if not outputs.history and not outputs.tracks:
        return None, None
    histories, tracks = [], []
    for point in scenario.points:
        if point.index not in sweep.points:
            continue
        result = sweep.points[point.index]
        history, count, n_tracks = _simulated(point, scenario, result)
        coordinates = {
            axis.column: value for axis, value in zip(scenario.axes, point.values, strict=True)
        }
        if outputs.history:
            histories += list(_history_frames(coordinates, point, history, count, result))
        if outputs.tracks:
            tracks.append(_tracks_frame(coordinates, history, n_tracks))
    return (
        pd.concat(histories, ignore_index=True) if histories else None,
        pd.concat(tracks, ignore_index=True) if tracks else None,
    )


def _simulated(point: Point, scenario: Scenario, result: PointResult) -> tuple[History, int, int]:
    """A point's first realizations over time; how many are for the history, and for tracks."""
    settings, outputs = point.model.monte_carlo, scenario.base.outputs
    problem = problem_of(point.model, scenario.folder)
    behind = result.realizations or settings.realizations or HISTORY_REALIZATIONS
    count = history_realizations(behind, problem.n_samples + 1)
    n_tracks = min(outputs.tracks, behind)
    if not outputs.history:
        count = n_tracks
    key = point_key(settings, point.identities)
    limits = problem.limits(key, min(behind, LOOKED_AT)) if settings.offsets == "sobol" else ()
    net = cell_size(behind, nets=True) if takes_nets(problem, settings, limits) else 0
    return problem.history(key, 0, max(count, n_tracks), net), count, n_tracks


def _in_table_unit(name: str, values: Any) -> Any:
    return degrees(values) if UNITS[name] == "deg" else values


def _history_frames(
    coordinates: dict[str, Any], point: Point, history: History, count: int, result: PointResult
) -> Iterator[pd.DataFrame]:
    """One frame per error and statistic."""
    import pandas as pd

    for i, name in enumerate(point.model.ERRORS):
        values = values_over_time(history.errors[i, :, :count])
        _carry_back(values, history, i, count, point, result)
        for statistic, over_time in values.items():
            yield pd.DataFrame(
                {
                    **coordinates,
                    TIME: history.time,
                    "error": name,
                    "statistic": statistic,
                    "value": _in_table_unit(name, over_time),
                    "unit": UNITS[name],
                    "realizations": count,
                }
            )


def _carry_back(
    values: dict[str, Array],
    history: History,
    error: int,
    count: int,
    point: Point,
    result: PointResult,
) -> None:
    """What the table knows of its instants, taken into the values until each of them."""
    model = point.model
    # In the order of time.
    rows = [k for k, row in enumerate(model.error_rows) if row.name == model.ERRORS[error]]
    first = 0
    for number, row in enumerate(rows):
        time = model.error_rows[row].time
        end = len(history.time) - 1
        if time is not None:
            end = int(np.argmin(np.abs(history.time - time)))
        # After the last instant nothing more is known: what holds there goes on.
        until = end + 1 if number + 1 < len(rows) else len(history.time)
        estimates = result.estimates
        known = dict(zip(estimates.statistics, estimates.value[row], strict=True))
        if np.isfinite(known["mean"]):
            errors = history.errors[error, :, :count]
            carry_back(values, errors, slice(first, until), end, known)
        first = until


def _tracks_frame(coordinates: dict[str, Any], history: History, count: int) -> pd.DataFrame:
    """Sample tracks; the true one has realization -1."""
    import pandas as pd

    frames = [
        pd.DataFrame(
            {
                **coordinates,
                "realization": number,
                TIME: history.time,
                **dict(zip(history.coordinates, track, strict=True)),
            }
        )
        for number, track in [
            (-1, history.truth),
            *((r, history.tracks[:, :, r]) for r in range(count)),
        ]
    ]
    return pd.concat(frames, ignore_index=True)
