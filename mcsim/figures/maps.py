"""Maps: the errors over two swept parameters as colours, with contour lines."""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import shorten

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from mcsim.figures import Picture, labels
from mcsim.figures.contours import DARK, Lines, is_log, levels_of, numbers, steps_of
from mcsim.figures.style import house_style, log_scale, set_title, spans_decades
from mcsim.results import Results, at_the_end, in_unit_of_tables
from mcsim.scenario.axes import Axis, Value
from mcsim.scenario.error_quantities import SIGNS, UNITS
from mcsim.scenario.figure import Limits

Array = NDArray[np.float64]

#: Values of a third axis that are drawn side by side.
_MOST_COLUMNS = 4
_MISSING, _GREY = "#d9dde2", "#6b7280"
_LONGEST_REMARK = 60


@dataclass(frozen=True)
class Grid:
    """One error over two axes: ``values`` (y, x), where a note stands, and what is held."""

    error: str
    x: Axis
    y: Axis
    values: Array
    notes: NDArray[np.object_]
    held: dict[str, Value]


def wants(results: Results) -> bool:
    """Whether the scenario asks for a map and sweeps two numbers."""
    return results.scenario.base.figure.map and len(map_axes(results.scenario.axes)) > 1


def map_axes(axes: tuple[Axis, ...]) -> tuple[Axis, ...]:
    """The axes that have numbers, more than one of them."""
    return tuple(axis for axis in axes if axis.numeric and len(axis.values) > 1)


def draw_map(results: Results) -> Figure:
    """A panel per error; a third axis is drawn in columns, further ones at their first value."""
    grids, notes = _grids(results)
    base = results.scenario.base
    columns = len(grids[0]) if len(grids[0]) > 1 else min(2, len(grids))
    panels = [grid for row in grids for grid in row]
    rows = -(-len(panels) // columns)
    with house_style():
        figure = Figure(figsize=(5.0 * columns, 3.7 * rows + 0.8), layout="constrained")
        flat = figure.subplots(rows, columns, squeeze=False).ravel()
        for unused in flat[len(panels) :]:
            unused.set_visible(False)
        for axes, grid in zip(flat, panels, strict=False):
            alike = [g for g in panels if UNITS[g.error] == UNITS[grid.error]]
            scale = _scale_of([g.values for g in alike])
            own = [g.values.ravel() for g in alike if g.error == grid.error]
            _draw_panel(figure, axes, grid, scale, np.concatenate(own), results)
        set_title(figure, "\n".join(filter(None, [base.title, base.figure.title, *notes])))
        _explain(figure, panels, base.figure.limits)
    return figure


def _grids(results: Results) -> tuple[list[list[Grid]], list[str]]:
    """Per error a row of grids, and where axes stand that are not drawn."""
    axes = results.scenario.axes
    x, y = map_axes(axes)[:2]
    rest = [axis for axis in axes if axis not in (x, y)]
    beside = next((axis for axis in rest if len(axis.values) > 1), None)
    held = {axis.path: axis.values[0] for axis in rest}
    columns = beside.values[:_MOST_COLUMNS] if beside else (None,)
    errors = dict.fromkeys(e for panel in results.scenario.base.panels for e in panel.errors)
    grids = [
        [
            _grid(results, error, x, y, held | ({beside.path: value} if beside and value else {}))
            for value in columns
        ]
        for error in errors
    ]
    notes = [_at(axis, axis.values[0]) for axis in rest if axis is not beside]
    if beside and len(beside.values) > _MOST_COLUMNS:
        words = labels.path_words(beside.path)
        notes.append(f"{_MOST_COLUMNS} of {len(beside.values)} values of {words}")
    return grids, notes


def _at(axis: Axis, value: Value) -> str:
    return f"{labels.path_words(axis.path)} {labels.value_label(axis, value)}"


def _grid(results: Results, error: str, x: Axis, y: Axis, held: dict[str, Value]) -> Grid:
    table = at_the_end(results.table)
    statistic = results.scenario.base.figure.statistic
    table = table[(table["statistic"] == statistic) & (table["error"] == error)]
    for axis in results.scenario.axes:
        if axis.path in held:
            table = table[table[axis.column] == held[axis.path]]
    values = np.full((len(y.values), len(x.values)), np.nan)
    notes = np.full(values.shape, "", object)
    columns = (table[y.column], table[x.column], table["value"], table["note"])
    for y_value, x_value, value, note in zip(*columns, strict=True):
        at = y.values.index(y_value), x.values.index(x_value)
        values[at], notes[at] = value, note
    beside = {p: v for p, v in held.items() if len(_axis(results, p).values) > 1}
    return Grid(error, x, y, values, notes, beside)


def _axis(results: Results, path: str) -> Axis:
    return next(axis for axis in results.scenario.axes if axis.path == path)


def _scale_of(values: list[Array]) -> Normalize:
    """The colours' scale: of all panels in one unit, logarithmic where they span decades."""
    flat = np.concatenate([v.ravel() for v in values])
    flat = flat[np.isfinite(flat)]
    positive = flat[flat > 0.0]
    if len(flat) and np.all(flat >= 0.0) and spans_decades(positive):
        return LogNorm(float(positive.min()), float(positive.max()))
    if np.any(flat < 0.0):
        largest = float(np.max(np.abs(flat)))
        return Normalize(-largest, largest)
    return Normalize(0.0, float(flat.max()) if len(flat) and flat.max() > 0.0 else 1.0)


def _draw_panel(
    figure: Figure, axes: Axes, grid: Grid, scale: Normalize, alike: Array, results: Results
) -> None:
    """One map; ``alike`` are the values of all maps of its error, which have lines in common."""
    base, unit = results.scenario.base, UNITS[grid.error]
    x, y = numbers(grid.x), numbers(grid.y)
    for which, axis, values in (("x", grid.x, x), ("y", grid.y, y)):
        if is_log(axis):
            log_scale(axes, which, list(values))  # type: ignore[arg-type]
    log = isinstance(scale, LogNorm)
    shown = np.where(grid.values > 0.0, grid.values, np.nan) if log else grid.values
    signed = bool(scale.vmin is not None and scale.vmin < 0.0)
    ink = DARK if signed else "white"
    mesh = axes.pcolormesh(
        _edges(x, is_log(grid.x)),
        _edges(y, is_log(grid.y)),
        np.ma.masked_invalid(shown),
        norm=scale,
        cmap="RdBu_r" if signed else "viridis",
    )
    axes.set_facecolor(_MISSING)
    axes.grid(visible=False)
    limit = _limit(grid.error, base.figure.limits)
    levels = levels_of(alike[np.isfinite(alike) & ((alike > 0.0) | (not log))], log)
    if limit is not None:
        levels = levels[~np.isclose(levels, limit)]
    lines = Lines(axes, grid.x, grid.y, shown, log)
    lines.draw(levels, "{:.3g}", colors=ink, linewidths=0.8)
    if limit is not None:
        lines.draw_limit(limit, SIGNS[unit])
    _mark(axes, grid, ink)
    axes.set_xlabel(labels.axis_label(grid.x))
    axes.set_ylabel(labels.axis_label(grid.y))
    axes.set_title(", ".join(_at(_axis(results, p), v) for p, v in grid.held.items()))
    bar = figure.colorbar(mesh, ax=axes)
    statistic = base.statistics()[base.figure.statistic]
    bar.set_label(labels.error_label((grid.error,), statistic, unit))
    if log:
        bar.ax.yaxis.set_major_locator(
            LogLocator(subs=steps_of(float(scale.vmin), float(scale.vmax)))
        )
        bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        bar.ax.yaxis.set_minor_formatter(NullFormatter())


def _edges(values: Array, log: bool) -> Array:
    """Borders of the cells around points, in the order of the points."""
    at = np.log(values) if log else values
    middles = 0.5 * (at[1:] + at[:-1])
    ends = np.array([at[0] - (middles[0] - at[0]), at[-1] + (at[-1] - middles[-1])])
    edges = np.concatenate([ends[:1], middles, ends[1:]])
    return np.exp(edges) if log else edges


def _limit(error: str, limits: Limits) -> float | None:
    """The requirement on an error, in the unit of tables."""
    unit = UNITS[error]
    limit = {"m": limits.position, "deg": limits.angle, "m/s": limits.velocity}.get(unit)
    return None if limit is None else float(in_unit_of_tables(unit, limit))


def _mark(axes: Axes, grid: Grid, ink: str) -> None:
    """Circles where the table remarks on a value; zeros, which have no logarithm, as such."""
    x, y = numbers(grid.x), numbers(grid.y)
    for (i, j), note in np.ndenumerate(grid.notes):
        if note and np.isfinite(grid.values[i, j]):
            axes.plot(
                x[j], y[i], marker="o", color=ink, markerfacecolor="none", markeredgewidth=0.8
            )
        if grid.values[i, j] == 0.0:
            axes.annotate("0", (x[j], y[i]), ha="center", va="center", fontsize=7.5)


def _explain(figure: Figure, grids: list[Grid], limits: Limits) -> None:
    """What the marks mean that are there."""
    texts = []
    limits_drawn = {
        f"{limit:.3g} {SIGNS[UNITS[g.error]]}": None
        for g in grids
        if (limit := _limit(g.error, limits)) is not None
        and np.nanmin(g.values, initial=np.inf) < limit < np.nanmax(g.values, initial=-np.inf)
    }
    if limits_drawn:
        texts.append(f"bold: limit {', '.join(limits_drawn)}")
    if any(np.isnan(grid.values).any() for grid in grids):
        texts.append("grey: no value")
    notes = [n for g in grids for n in g.notes[np.isfinite(g.values)] if n]
    if notes:
        texts.append(f"circles: {shorten(notes[0], _LONGEST_REMARK, placeholder=' …')}")
    if texts:
        figure.supxlabel("; ".join(texts), x=1.0, ha="right", fontsize=7.5, color=_GREY)


PICTURE = Picture("map", wants=wants, paint=draw_map)
