"""Deviations of the Allan family of a log, side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mcsim.figures.style import LINE_STYLES, curve_colour, house_style, log_scale, set_title

Array = NDArray[np.float64]

_WIDTH, _HEIGHT, _COLUMNS = 4.1, 3.4, 3


@dataclass(frozen=True)
class Line:
    """A curve in SI units with its interval (k,), nan where there is none."""

    kind: str
    tau: Array
    deviation: Array
    low: Array
    high: Array


@dataclass(frozen=True)
class Panel:
    """A channel; ``one`` is an SI unit in ``unit``."""

    name: str
    unit: str
    one: float
    lines: Sequence[Line]


def draw_deviations(panels: Sequence[Panel], words: Mapping[str, str], title: str) -> Figure:
    """A panel per channel; curves with their intervals shaded, in a legend by ``words``."""
    columns = min(_COLUMNS, len(panels))
    rows = math.ceil(len(panels) / columns)
    with house_style():
        size = max(_WIDTH * columns, 7.0), _HEIGHT * rows + 1.0
        figure = Figure(figsize=size, layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, panel in zip(grid, panels, strict=False):
            shown = []
            for k, line in enumerate(panel.lines):
                colour = curve_colour(k, 6)
                value = line.deviation * panel.one
                low, high = line.low * panel.one, line.high * panel.one
                axes.fill_between(line.tau, low, high, color=colour, alpha=0.15, lw=0)
                axes.plot(
                    line.tau,
                    value,
                    color=colour,
                    linestyle=LINE_STYLES[k % len(LINE_STYLES)],
                    label=words[line.kind],
                )
                shown.append(value)
            every = np.concatenate(shown)
            log_scale(axes, "x", np.concatenate([line.tau for line in panel.lines]).tolist())
            log_scale(axes, "y", every.tolist())
            axes.set_ylim(0.6 * every.min(), 1.8 * every.max())
            axes.set(xlabel="cluster time τ [s]", ylabel=f"{panel.name}, deviation [{panel.unit}]")
        for axes in grid[len(panels) :]:
            axes.set_axis_off()
        handles, labels = grid[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
        set_title(figure, title)
    return figure
