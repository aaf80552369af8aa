"""Sample tracks, the scatter of their ends with its error ellipse, and fan charts over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from mcsim.figures import Picture, labels
from mcsim.figures.style import house_style
from mcsim.results import Results
from mcsim.scenario.error_quantities import SIGNS

if TYPE_CHECKING:
    import pandas as pd

_TRUTH, _SAMPLE, _BAND = "#d1495b", "#2a9d8f", "#1b4965"
_FEWEST_ENDS = 10
_ALONG = "along [m]"
#: Tracks more elongated than this are not drawn true to scale.
_LONGEST_TRUE_TO_SCALE = 4.0


def draw_over_time(results: Results) -> Figure:
    """Tracks and fan charts of the first point, of which the run kept one or both."""
    history = _first_point(results, results.history)
    tracks = _first_point(results, results.tracks)
    rows: list[Any] = []
    plane = tracks is not None and _ALONG in tracks
    if tracks is not None:
        rows.append(["tracks", "ends"] if plane else ["tracks", "tracks"])
    if history is not None:
        drawn = results.scenario.base.DRAWN
        pairs = [list(drawn[i : i + 2]) for i in range(0, len(drawn), 2)]
        rows += [pair if len(pair) == 2 else pair * 2 for pair in pairs]
    with house_style():
        figure = Figure(figsize=(9.2, 3.1 * len(rows) + 0.6), layout="constrained")
        panels = figure.subplot_mosaic(rows)
        if tracks is not None and not plane:
            _draw_courses(panels["tracks"], tracks)
        elif tracks is not None:
            _draw_tracks(panels["tracks"], tracks)
            _draw_ends(panels["ends"], tracks, results.scenario.base.monte_carlo.confidence)
        if history is not None:
            for name in drawn:
                _draw_fan(panels[name], history[history["error"] == name], name)
            handles, texts = panels[drawn[0]].get_legend_handles_labels()
            figure.legend(handles, texts, loc="outside lower center", ncols=4)
        figure.suptitle(_title(results), fontsize=10.5)
    return figure


PICTURE = Picture(
    "tracks",
    wants=lambda results: results.tracks is not None or results.history is not None,
    paint=draw_over_time,
)


def _first_point(results: Results, table: pd.DataFrame | None) -> pd.DataFrame | None:
    if table is None:
        return None
    for axis in results.scenario.axes:
        table = table[table[axis.column] == axis.values[0]]
    return table


def _title(results: Results) -> str:
    scenario = results.scenario
    title = scenario.base.figure.title or scenario.base.title or scenario.name
    where = ", ".join(
        f"{labels.path_words(axis.path)} {labels.value_label(axis, axis.values[0])}"
        for axis in scenario.axes
    )
    return f"{title} – {where}" if where else title


def _draw_tracks(axes: Axes, tracks: pd.DataFrame) -> None:
    for _, track in tracks[tracks["realization"] >= 0].groupby("realization"):
        axes.plot(track["along [m]"], track["across [m]"], color=_SAMPLE, alpha=0.35, linewidth=0.7)
    truth = tracks[tracks["realization"] == -1]
    axes.plot(truth["along [m]"], truth["across [m]"], color=_TRUTH, linewidth=1.6, label="truth")
    span = np.ptp(tracks[["along [m]", "across [m]"]].to_numpy(), axis=0)
    if span.min() * _LONGEST_TRUE_TO_SCALE > span.max():
        axes.set_aspect("equal", adjustable="datalim")
    axes.plot([], [], color=_SAMPLE, label=f"{tracks['realization'].nunique() - 1} realizations")
    axes.set_xlabel("along [m]")
    axes.set_ylabel("across [m]")
    axes.set_title("reconstructed tracks")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.1)
    axes.title.set_position((0.85, 1.0))


def _draw_courses(axes: Axes, tracks: pd.DataFrame) -> None:
    """What is not a track in the plane, over time."""
    quantity = tracks.columns[-1]
    for _, track in tracks[tracks["realization"] >= 0].groupby("realization"):
        axes.plot(track["time [s]"], track[quantity], color=_SAMPLE, alpha=0.35, linewidth=0.7)
    truth = tracks[tracks["realization"] == -1]
    axes.plot(truth["time [s]"], truth[quantity], color=_TRUTH, linewidth=1.6, label="truth")
    axes.plot([], [], color=_SAMPLE, label=f"{tracks['realization'].nunique() - 1} realizations")
    axes.set_xlabel("time [s]")
    axes.set_ylabel(quantity)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.1)


def _draw_ends(axes: Axes, tracks: pd.DataFrame, sigmas: float) -> None:
    ends = tracks.groupby("realization")[["along [m]", "across [m]"]].last()
    errors = (ends.drop(index=-1) - ends.loc[-1]).to_numpy()
    axes.plot(errors[:, 0], errors[:, 1], ".", color=_SAMPLE, markersize=4)
    axes.plot(0.0, 0.0, "+", color=_TRUTH, markersize=9, markeredgewidth=1.6)
    if len(errors) >= _FEWEST_ENDS:
        axes.add_patch(_ellipse(errors, sigmas))
        axes.autoscale_view()
        words = labels.confidence_words(sigmas)
        axes.set_title(f"ends, with the {words} ellipse of their covariance")
    else:
        axes.set_title("ends")
    axes.set_xlabel("along-road error [m]")
    axes.set_ylabel("across-road error [m]")


def _ellipse(errors: Any, sigmas: float) -> Ellipse:
    """The contour of the ends' normal distribution at ``sigmas`` along each principal axis."""
    values, vectors = np.linalg.eigh(np.cov(errors.T))
    width, height = 2.0 * sigmas * np.sqrt(np.maximum(values, 0.0))
    angle = np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0]))
    centre = errors.mean(axis=0)
    return Ellipse(
        (centre[0], centre[1]), width, height, angle=angle, fill=False, color=_BAND, linewidth=1.3
    )


def _draw_fan(axes: Axes, rows: pd.DataFrame, name: str) -> None:
    by_statistic = dict(list(rows.groupby("statistic")))
    time = by_statistic["mean"]["time [s]"]

    def line(statistic: str) -> Any:
        return by_statistic[statistic]["value"].to_numpy(float)

    axes.fill_between(
        time, line("p05"), line("p95"), color=_BAND, alpha=0.18, linewidth=0, label="5–95 %"
    )
    mean, std = line("mean"), line("std")
    axes.fill_between(
        time, mean - std, mean + std, color=_BAND, alpha=0.25, linewidth=0, label="mean ± std"
    )
    axes.plot(time, mean, color=_BAND, label="mean")
    axes.plot(time, line("rms"), color=_TRUTH, linestyle="--", label="RMS")
    axes.axhline(0.0, color="#6b7280", linewidth=0.8, zorder=1.5)
    unit = rows["unit"].iloc[0]
    axes.set_xlabel("time [s]")
    axes.set_ylabel(f"{labels.error_words(name)} [{SIGNS[unit]}]")
