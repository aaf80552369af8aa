"""Theoretical Allan deviations: each term with its slope and reading, and those of a sensor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mcsim.characterisation.noise_terms import NoiseTerm, total_variance
from mcsim.characterisation.read_offs import Reading
from mcsim.figures.style import curve_colour, house_style, log_scale, set_title

Array = NDArray[np.float64]

_LETTERS = ("Q", "N", "B", "K", "R", "GM", "S")
_STYLES = dict(zip(_LETTERS, ("-.", ":", "--", "-.", "--", "-", ":"), strict=True))
_COLOURS = {letter: curve_colour(i % 6, 6) for i, letter in enumerate(_LETTERS)}
_TOTAL, _MARK = "black", "#d1495b"
_WIDTH, _HEIGHT, _COLUMNS = 4.1, 3.2, 3
#: Curves are drawn down to this part of the least of the total.
_DEPTH = 0.15


@dataclass(frozen=True)
class TermPanel:
    """Terms over cluster times ``tau`` (k,) in s, singly and, where there are several, together.

    ``one`` is an SI unit in units of the axis ``label``; ``readings`` are marked, or where there
    are none each term's own read-off point.
    """

    title: str
    label: str
    terms: Sequence[NoiseTerm]
    tau: Array
    one: float = 1.0
    readings: Sequence[Reading] = ()


@dataclass(frozen=True)
class CorrelationPanel:
    """The autocorrelation of a Gauss-Markov process, Figure 3.7 of the thesis."""

    title: str


def draw_terms(panels: Sequence[TermPanel | CorrelationPanel], title: str) -> Figure:
    """The panels, three to a row."""
    columns = min(_COLUMNS, len(panels))
    rows = math.ceil(len(panels) / columns)
    with house_style():
        size = max(_WIDTH * columns, 6.4), _HEIGHT * rows + 0.9
        figure = Figure(figsize=size, layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, panel in zip(grid, panels, strict=False):
            if isinstance(panel, TermPanel):
                _draw(panel, axes)
            else:
                _correlation(panel, axes)
        for axes in grid[len(panels) :]:
            axes.set_axis_off()
        _legend(figure)
        set_title(figure, title)
    return figure


def _draw(panel: TermPanel, axes: Axes) -> None:
    total = np.sqrt(total_variance(panel.terms, panel.tau)) * panel.one
    together = len(panel.terms) > 1
    bottom = _DEPTH * float(total.min()) if together else 0.5 * float(np.quantile(total, 0.02))
    for term in panel.terms:
        line = term.deviation(panel.tau) * panel.one
        axes.plot(
            panel.tau,
            np.where(line > bottom, line, np.nan),
            linestyle=_STYLES[term.letter] if together else "-",
            color=_COLOURS[term.letter],
            label=f"{term.letter}: {term.words}",
        )
    if together:
        axes.plot(panel.tau, total, color=_TOTAL, label="all together")
    _mark(panel, axes, bottom)
    log_scale(axes, "x", panel.tau.tolist())
    log_scale(axes, "y", [bottom, float(total.max())])
    axes.set_ylim(bottom, 2.0 * float(total.max()))
    axes.set(xlabel="cluster time τ [s]", ylabel=panel.label)
    axes.set_title(panel.title, fontsize=8.6, loc="left")


def _mark(panel: TermPanel, axes: Axes, bottom: float) -> None:
    """Dots where the coefficients are read; a term's region along the bottom."""
    if not panel.readings:
        for term in panel.terms:
            if term.read_off is not None:
                point = term.read_off
                level = point.level * term.coefficient * panel.one
                if level < bottom:
                    continue
                axes.plot(point.tau, level, "o", color=_MARK, zorder=4, label="read off here")
        return
    for k, reading in enumerate(panel.readings):
        level = math.sqrt(float(total_variance(panel.terms, np.array([reading.tau]))[0]))
        axes.plot(reading.tau, level * panel.one, "o", color=_MARK, zorder=4, label="read off here")
        if reading.region is not None:
            axes.axvspan(
                *_clipped(reading.region, panel.tau),
                ymax=0.03 + 0.02 * (k % 2),
                color=_COLOURS[reading.term.letter],
                lw=0,
                zorder=0.5,
                label="cluster times of a reading",
            )


def _clipped(region: tuple[float, float], tau: Array) -> tuple[float, float]:
    return max(region[0], float(tau[0])), min(region[1], float(tau[-1]))


def _correlation(panel: CorrelationPanel, axes: Axes) -> None:
    lag = np.linspace(-4.0, 4.0, 401)
    axes.plot(lag, np.exp(-np.abs(lag)), color=_COLOURS["GM"])
    axes.plot([-1.0, 1.0], [math.exp(-1.0)] * 2, "o", color=_MARK)
    axes.axhline(math.exp(-1.0), color="#6b7280", linewidth=0.8, linestyle=":")
    axes.set(xlabel="lag over correlation time Tc", ylabel="autocorrelation over variance")
    axes.set_ylim(0.0, 1.05)
    axes.set_title(panel.title, fontsize=8.6, loc="left")


def _legend(figure: Figure) -> None:
    """One legend for all panels, each label once."""
    found: dict[str, Artist] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    columns = max(1, min(len(found), int(figure.get_figwidth() / 2.3)))
    figure.legend(list(found.values()), list(found), loc="outside lower center", ncols=columns)
