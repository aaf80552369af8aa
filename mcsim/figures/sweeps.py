"""Curve families over a sweep: one panel per error, intervals as bars."""

from __future__ import annotations

from dataclasses import dataclass, field
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcsim.figures import labels
from mcsim.figures.style import (
    LINE_STYLES,
    MARKERS,
    curve_colour,
    house_style,
    legend_outside,
    log_scale,
    set_title,
    spans_decades,
)
from mcsim.results import Results, at_the_end, in_unit_of_tables
from mcsim.scenario.axes import Axis, Value
from mcsim.scenario.error_quantities import SIGNS, UNITS
from mcsim.scenario.figure import Figure as FigureModel
from mcsim.scenario.figure import Panel
from mcsim.scenario_file import Scenario
from mcsim.statistics import METHOD

if TYPE_CHECKING:
    import pandas as pd

#: Values of a third axis that are drawn side by side.
_MOST_SLICES = 4
#: Letters of a remark that stand below a figure.
_LONGEST_REMARK = 44


@dataclass(frozen=True)
class Column:
    """A column of panels: results, and the values at which further axes are held."""

    results: Results
    held: dict[str, Value] = field(default_factory=dict)
    title: str = ""


def draw_sweep(results: Results) -> Figure:
    """The figure of a swept scenario."""
    axes = results.scenario.axes
    base = results.scenario.base
    title = "\n".join(filter(None, [base.title, base.figure.title]))
    rest = [axis for axis in axes if axis.path not in _drawn_paths(results)]
    if not rest:
        return draw_columns([Column(results)], title)
    held = {axis.path: axis.values[0] for axis in rest[1:]}
    columns = [
        Column(
            results,
            {rest[0].path: value, **held},
            f"{labels.path_words(rest[0].path)} {labels.value_label(rest[0], value)}",
        )
        for value in rest[0].values[:_MOST_SLICES]
    ]
    notes = [
        f"{labels.path_words(axis.path)} {labels.value_label(axis, axis.values[0])}"
        for axis in rest[1:]
    ]
    if len(rest[0].values) > _MOST_SLICES:
        notes.append(
            f"{_MOST_SLICES} of {len(rest[0].values)} values of {labels.path_words(rest[0].path)}"
        )
    return draw_columns(columns, "\n".join(filter(None, [title, ", ".join(notes)])))


def draw_columns(columns: list[Column], title: str | None = None) -> Figure:
    """Panels of one column in two columns of a page, several columns side by side."""
    panels = [c.results.scenario.base.panels for c in columns]
    rows = max(map(len, panels))
    with house_style():
        if len(columns) == 1:
            across = min(2, rows)
            down = -(-rows // across)
            figure = Figure(figsize=(4.6 * across, 3.3 * down + 0.8), layout="constrained")
            flat = figure.subplots(down, across, squeeze=False).ravel()
            grid = flat[:rows, None]
            for unused in flat[rows:]:
                unused.set_visible(False)
        else:
            figure = Figure(figsize=(4.4 * len(columns), 2.9 * rows + 0.8), layout="constrained")
            grid = figure.subplots(rows, len(columns), squeeze=False)
        if title:
            set_title(figure, title)
        log_units = _units_that_span_decades(columns)
        families = set()
        for j, column in enumerate(columns):
            for i, panel in enumerate(panels[j]):
                families.add(_draw_panel(grid[i, j], column, panel, log_units))
            for i in range(len(panels[j]), rows):
                grid[i, j].set_visible(False)
            if column.title:
                grid[0, j].set_title(column.title)
        _place_legends(figure, grid, families)
        zeros = any(_has_zeros(column, log_units) for column in columns)
        scenarios = [column.results.scenario for column in columns]
        _explain_marks(figure, scenarios, _remarked(columns), zeros)
    return figure


def _has_zeros(column: Column, log_units: set[str]) -> bool:
    """Whether exact zeros are drawn on a logarithmic axis."""
    base = column.results.scenario.base
    rows = _slice(column, base.figure.statistic, column.held)
    drawn = [e for panel in base.panels for e in panel.errors if UNITS[e] in log_units]
    return bool((rows["error"].isin(drawn) & (rows["value"] == 0.0)).any())


def _remarked(columns: list[Column]) -> list[str]:
    """Remarks on points that are drawn hollow, without repeating any."""
    notes: dict[str, None] = {}
    for column in columns:
        base = column.results.scenario.base
        rows = _slice(column, base.figure.statistic, column.held)
        drawn = [error for panel in base.panels for error in panel.errors]
        rows = rows[rows["error"].isin(drawn) & rows["value"].notna() & (rows["note"] != "")]
        notes |= dict.fromkeys(rows["note"])
    return list(notes)


def _explain_marks(
    figure: Figure, scenarios: list[Scenario], remarked: list[str], zeros: bool
) -> None:
    sigmas = scenarios[0].base.monte_carlo.confidence
    text = f"bars: {labels.confidence_words(sigmas)} bootstrap intervals "
    if any(scenario.base.figure.method for scenario in scenarios):
        text += "\ndotted: method error, no sensor error "
    if zeros:
        text += "\ntriangles: exactly zero "
    if remarked:
        text += f"\nhollow: {shorten(remarked[0], _LONGEST_REMARK, placeholder=' …')} "
    style: dict[str, Any] = {"ha": "right", "va": "bottom", "fontsize": 7.5, "color": "#6b7280"}
    if figure.legends:
        figure.text(1.0, 0.0, text, **style)
    else:
        # Legends stand below the panels: the text needs a line of its own.
        figure.supxlabel(text.replace(" \n", "; "), x=1.0, **style)


def _units_that_span_decades(columns: list[Column]) -> set[str]:
    """Units whose errors deserve logarithmic axes somewhere; all their panels get them."""
    units = set()
    for column in columns:
        base = column.results.scenario.base
        table = _slice(column, base.figure.statistic, column.held)
        for panel in base.panels:
            values = table[table["error"].isin(panel.errors)]["value"].to_numpy()
            if base.statistics()[base.figure.statistic].log_axes and spans_decades(values):
                units.add(UNITS[panel.errors[0]])
    return units


def _place_legends(figure: Figure, grid: Any, families: set[tuple[Any, ...]]) -> None:
    """One legend below if all panels share their curves, else one beside each column or panel."""
    if len(families) == 1:
        legend_outside(figure, grid[0, 0], next(iter(families))[0])
        return
    if grid.shape[1] > 1:
        for axes in grid[-1, :]:
            handles, names = axes.get_legend_handles_labels()
            axes.legend(
                handles,
                names,
                title=axes.mcsim_curves,
                loc="upper center",
                bbox_to_anchor=(0.5, -0.2),
                ncols=min(3, len(names)),
            )
        return
    figure.set_figwidth(figure.get_figwidth() * 1.3)
    for axes in grid[:, 0]:
        handles, names = axes.get_legend_handles_labels()
        axes.legend(
            handles, names, title=axes.mcsim_curves, loc="center left", bbox_to_anchor=(1.0, 0.5)
        )


def _drawn_paths(results: Results) -> set[str]:
    paths = set()
    for panel in results.scenario.base.panels:
        x, curves = _panel_axes(results.scenario.axes, panel)
        paths |= {x.path} | ({curves.path} if curves else set())
    return paths


def _panel_axes(axes: tuple[Axis, ...], panel: Panel) -> tuple[Axis, Axis | None]:
    """Which axis runs horizontally, and which distinguishes the curves."""
    by_path = {axis.path: axis for axis in axes}
    named = {panel.x, panel.curves}
    free = [axis for axis in axes if axis.path not in named]
    x = by_path[panel.x] if panel.x else free.pop(0)
    curves = by_path[panel.curves] if panel.curves else (free[0] if free else None)
    return x, curves


def _draw_panel(axes: Axes, column: Column, panel: Panel, log_units: set[str]) -> tuple[Any, ...]:
    """Draw one panel; returns what its legend says."""
    scenario = column.results.scenario
    statistic = scenario.base.figure.statistic
    x_axis, curve_axis = _panel_axes(scenario.axes, panel)
    held = _held_in_panel(column, x_axis, curve_axis)
    table = _slice(column, statistic, held)
    method = _slice(column, METHOD, held)
    curve_values: tuple[Value | None, ...] = curve_axis.values if curve_axis else (None,)
    names = []
    unit = UNITS[panel.errors[0]]
    for c, curve_value in enumerate(curve_values):
        for e, error in enumerate(panel.errors):
            rows, floor = (t[t["error"] == error] for t in (table, method))
            if curve_axis is not None:
                rows, floor = (t[t[curve_axis.column] == curve_value] for t in (rows, floor))
            name = _curve_name(panel, error, curve_axis, curve_value)
            names.append(name)
            if not len(rows):
                continue  # every point of this curve failed
            n_styles = len(curve_values) if curve_axis else len(panel.errors)
            index = c if curve_axis else e
            _draw_curve(
                axes,
                x_axis,
                rows,
                label=name,
                color=curve_colour(index, n_styles),
                marker=MARKERS[index % len(MARKERS)],
                linestyle=LINE_STYLES[e % len(LINE_STYLES)] if curve_axis else "-",
            )
            if unit in log_units:
                _draw_zeros(axes, x_axis, rows, curve_colour(index, n_styles))
            if scenario.base.figure.method:
                axes.plot(
                    _positions(x_axis, floor),
                    np.abs(floor["value"].to_numpy(float)),
                    color=curve_colour(index, n_styles),
                    linestyle=(0, (1, 1.6)),
                    linewidth=1.0,
                    zorder=1.8,
                )
    drawn = table[table["error"].isin(panel.errors)]["value"].to_numpy(float)
    limit = _draw_limit(axes, scenario.base.figure, unit)
    _scale(axes, x_axis, np.append(drawn, limit), unit in log_units)
    axes.set_xlabel(labels.axis_label(x_axis))
    axes.set_ylabel(labels.error_label(panel.errors, scenario.base.statistics()[statistic], unit))
    elsewhere = [
        f"{labels.path_words(axis.path)} {labels.value_label(axis, held[axis.path])}"
        for axis in scenario.axes
        if axis.path in held.keys() - column.held.keys()
    ]
    if elsewhere:
        axes.set_title("at " + ", ".join(elsewhere))
    title = labels.axis_label(curve_axis) if curve_axis else None
    axes.mcsim_curves = title  # type: ignore[attr-defined]
    return (title, *names)


def _held_in_panel(column: Column, x_axis: Axis, curve_axis: Axis | None) -> dict[str, Value]:
    """Where the axes stand that this panel does not draw: the column's value, or their first."""
    drawn = {x_axis.path} | ({curve_axis.path} if curve_axis else set())
    return {
        axis.path: column.held.get(axis.path, axis.values[0])
        for axis in column.results.scenario.axes
        if axis.path not in drawn
    }


def _slice(column: Column, statistic: str, held: dict[str, Value]) -> pd.DataFrame:
    """The rows of one statistic where the held axes have their values."""
    table = at_the_end(column.results.table)
    table = table[table["statistic"] == statistic]
    for axis in column.results.scenario.axes:
        if axis.path in held:
            table = table[table[axis.column] == held[axis.path]]
    return table


def _curve_name(
    panel: Panel, error: str, curve_axis: Axis | None, curve_value: Value | None
) -> str:
    parts = []
    if len(panel.errors) > 1 or curve_axis is None:
        parts.append(labels.error_words(error))
    if curve_axis is not None and curve_value is not None:
        parts.append(labels.value_label(curve_axis, curve_value))
    return ", ".join(parts)


def _draw_curve(axes: Axes, x_axis: Axis, rows: pd.DataFrame, **style: Any) -> None:
    value = rows["value"].to_numpy(float)
    below = np.nan_to_num(value - rows["ci_low"].to_numpy(float))
    above = np.nan_to_num(rows["ci_high"].to_numpy(float) - value)
    bars = np.maximum([below, above], 0.0)
    axes.errorbar(
        _positions(x_axis, rows),
        value,
        yerr=bars,
        markeredgecolor="white",
        markeredgewidth=0.4,
        **style,
    )
    # What the table remarks on is hollow.
    noted = rows[(rows["note"] != "") & rows["value"].notna()]
    if len(noted):
        axes.plot(
            _positions(x_axis, noted),
            noted["value"].to_numpy(float),
            linestyle="none",
            marker=style["marker"],
            markerfacecolor="white",
            markeredgecolor=style["color"],
            markeredgewidth=1.0,
            zorder=3.0,
        )


def _draw_zeros(axes: Axes, x_axis: Axis, rows: pd.DataFrame, colour: Any) -> None:
    """Values of exactly zero, which a logarithmic axis does not hold, at its lower end."""
    zeros = rows[rows["value"] == 0.0]
    if len(zeros):
        axes.plot(
            _positions(x_axis, zeros),
            np.zeros(len(zeros)),
            transform=axes.get_xaxis_transform(),
            linestyle="none",
            marker="v",
            color=colour,
            clip_on=False,
            zorder=3.0,
        )


def _positions(x_axis: Axis, rows: pd.DataFrame) -> Any:
    """Where the rows stand horizontally; names stand at 0, 1, 2 …"""
    x = rows[x_axis.column]
    return x if x_axis.numeric else [x_axis.values.index(v) for v in x]


def _scale(axes: Axes, x_axis: Axis, values: Any, log: bool) -> None:
    """Logarithmic axes where the range spans decades; names on the ticks of plain values."""
    if not x_axis.numeric:
        axes.set_xticks(range(len(x_axis.values)), [str(v) for v in x_axis.values])
    else:
        x = [float(v) for v in x_axis.values]
        log_x = x_axis.log or spans_decades(x)
        if log_x:
            log_scale(axes, "x", x)
        # The whole axis, also where values are missing; panels then line up.
        ends = np.log([min(x), max(x)]) if log_x else np.array([min(x), max(x)])
        margin = 0.04 * (ends[1] - ends[0]) * np.array([-1.0, 1.0])
        if ends[1] > ends[0]:
            axes.set_xlim(*(np.exp(ends + margin) if log_x else ends + margin))
    positive = values[values > 0.0]
    if log and len(positive):
        log_scale(axes, "y", positive)
        # Method errors may fall far below; they do not decide what is in view.
        axes.set_ylim(bottom=0.6 * positive.min())
    elif np.any(np.isfinite(values)) and np.nanmin(values) >= 0.0:
        axes.set_ylim(bottom=0.0)


def _draw_limit(axes: Axes, figure: FigureModel, unit: str) -> list[float]:
    """The requirement line, with its value written on it; returns what must be in view."""
    limits = figure.limits
    limit = {"m": limits.position, "deg": limits.angle, "m/s": limits.velocity}[unit]
    if limit is None:
        return []
    shown = float(in_unit_of_tables(unit, limit))
    axes.axhline(shown, color="#6b7280", linestyle=(0, (6, 3)), linewidth=1.0, zorder=1.5)
    axes.annotate(
        f"limit {shown:.3g} {SIGNS[unit]}",
        (1.0, shown),
        xycoords=("axes fraction", "data"),
        xytext=(-2, 2),
        textcoords="offset points",
        ha="right",
        va="bottom",
        fontsize=7.5,
        color="#6b7280",
    ).set_in_layout(False)
    return [shown]
