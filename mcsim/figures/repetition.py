"""Figure of repeated runs: uncertainty over their number, and their mean against the worst."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mcsim.figures.style import (
    LINE_STYLES,
    MARKERS,
    curve_colour,
    house_style,
    log_scale,
    set_title,
)

Array = NDArray[np.float64]

_TOGETHER = "#20262e"
#: Smaller uncertainties (m/s) are not drawn.
_LEAST = 3e-4


@dataclass(frozen=True)
class Marked:
    """A sensor's share of groups, with its interval, at its ratio of shared to own errors."""

    name: str
    ratio: float
    share: float
    low: float
    high: float


def draw_repetition(
    sources: Mapping[str, Mapping[str, tuple[Array, Array]]],
    runs: NDArray[np.int64],
    normals: tuple[Array, Array],
    marks: Sequence[Marked],
    title: str,
) -> Figure:
    """Panels of sensors, then the share of groups whose mean beats the worst run by 75 %.

    ``sources`` are uncertainties (k,) in m/s over ``runs`` (k,) by sensor and source, linear
    and simulated; ``normals`` are ratios (m,) of shared to own errors and shares (m,).
    """
    with house_style():
        figure = Figure(figsize=(12.0, 4.6), layout="constrained")
        *panels, last = figure.subplots(1, len(sources) + 1)
        for axes, (name, curves) in zip(panels, sources.items(), strict=True):
            axes.sharey(panels[0])
            _draw_sources(axes, runs, curves)
            axes.set_title(name)
        panels[0].set_ylim(bottom=_LEAST)
        panels[0].set_ylabel("standard uncertainty of the mean velocity [m/s]")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=5)
        _draw_shares(last, *normals, marks)
        set_title(figure, title)
    return figure


def _draw_sources(
    axes: Axes, runs: NDArray[np.int64], curves: Mapping[str, tuple[Array, Array]]
) -> None:
    for i, (source, (linear, simulated)) in enumerate(curves.items()):
        last = i == len(curves) - 1
        colour = _TOGETHER if last else curve_colour(i, len(curves))
        style = {"color": colour, "linestyle": LINE_STYLES[i % 2], "linewidth": 1.3 + 0.7 * last}
        axes.plot(runs, linear, **style)
        axes.plot(runs, simulated, color=colour, linestyle="", marker=MARKERS[i])
        axes.plot([], [], label=source, marker=MARKERS[i], **style)
    shown = [float(v) for linear, _ in curves.values() for v in linear if v > _LEAST]
    log_scale(axes, "x", list(map(float, runs)))
    log_scale(axes, "y", shown)
    axes.set_xticks(runs, [str(m) for m in runs])
    axes.set_xlabel("runs averaged; lines: linear model, marks: simulated")


def _draw_shares(axes: Axes, ratios: Array, shares: Array, marks: Sequence[Marked]) -> None:
    axes.plot(ratios, 100.0 * shares, color=_TOGETHER, label="normal errors")
    for i, mark in enumerate(marks):
        share = 100.0 * mark.share
        ends = [[share - 100.0 * mark.low], [100.0 * mark.high - share]]
        axes.errorbar(
            mark.ratio,
            share,
            ends,
            color=curve_colour(i, len(marks)),
            marker=MARKERS[i],
            linestyle="",
            label=mark.name,
        )
    log_scale(axes, "x", ratios.tolist())
    axes.set_ylim(0.0, 100.0)
    axes.set_xlabel("errors that runs share, by each run's own (deviations)")
    axes.set_ylabel("groups: mean 75 % better than worst run [%]")
    axes.legend(loc="upper right")
