"""Measured runs with their mean; the mean with its uncertainty against a reference, its error."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mcsim.figures.style import curve_colour, house_style, legend_outside, set_title
from mcsim.measured_velocity.measurement import Measurement
from mcsim.measured_velocity.reference import Reference

Array = NDArray[np.float64]

_RUNS, _REFERENCE, _BAND = "#1b4965", "#d1495b", "#5c677d"
_MEAN = 2  # of the house's colours
_FACTOR = 1.959963984540054


def draw_velocity(found: Measurement, reference: Reference | None, title: str) -> Figure:
    """Figures 10 and 11: (a) the runs and their mean, (b) the mean with its corridor.

    With a reference the errors of the runs, and that of the mean with its corridor, stand beneath.
    """
    given, many = found.reference, found.group.runs > 1
    rows, columns = (1 if reference is None or given is None else 2), (2 if many else 1)
    with house_style():
        size = (9.6 if many else 6.4, 3.9 if rows == 1 else 6.2)
        figure = Figure(figsize=size, layout="constrained")
        ratios = (1.0,) if rows == 1 else (1.6, 1.0)
        panels = figure.subplots(
            rows, columns, sharex=True, sharey="row", squeeze=False, height_ratios=ratios
        )
        upper = panels[0, -1]
        _draw_mean(upper, found)
        if many:
            _draw_runs(panels[0, 0], found.group.time, found.runs, found.mean)
        if reference is not None and given is not None:
            upper.plot(found.group.time, given, color=_REFERENCE, ls="--")
            _draw_error(panels[1, -1], found, reference.deviation(given), found.mean - given)
            if many:
                _draw_runs(
                    panels[1, 0], found.group.time, _errors(found, given), found.mean - given
                )
            panels[1, 0].set_ylabel("velocity less\nreference [m/s]")
        panels[0, 0].set_ylabel("velocity [m/s]")
        for axes, letter in zip(panels.flat, "abcd", strict=False):
            axes.set_title(f"({letter})", loc="left")
        for axes in panels[-1]:
            axes.set_xlabel("time after the start of motion [s]")
        _legend(figure, upper, found, rows == 2)
        set_title(figure, title)
    return figure


def _errors(found: Measurement, given: Array) -> Array:
    """Errors (M, n + 1) of the runs, each against its own reference."""
    own = found.group.reference
    return found.runs - (given if own is None else own)


def _draw_runs(axes: Axes, time: Array, runs: Array, mean: Array) -> None:
    axes.plot(time, runs.T, color=_RUNS, alpha=0.45, linewidth=0.8)
    axes.plot(time, mean, color=curve_colour(_MEAN, 4), linewidth=2.0)


def _draw_mean(axes: Axes, found: Measurement) -> None:
    time, mean, u = found.group.time, found.mean, found.summed
    colour = curve_colour(_MEAN, 4)
    axes.fill_between(time, found.drawn.low, found.drawn.high, color=_BAND, alpha=0.18, linewidth=0)
    axes.fill_between(time, mean - u, mean + u, color=colour, alpha=0.4, linewidth=0)
    axes.plot(time, mean, color=colour, linewidth=1.6)


def _draw_error(axes: Axes, found: Measurement, own: Array, error: Array) -> None:
    """The error of the mean, and what it may be; ``own`` is the reference's uncertainty."""
    time, colour = found.group.time, curve_colour(_MEAN, 4)
    wide = _FACTOR * np.hypot(found.drawn.mean, own)
    axes.fill_between(time, -wide, wide, color=_BAND, alpha=0.18, linewidth=0)
    narrow = np.hypot(found.summed, own)
    axes.fill_between(time, -narrow, narrow, color=colour, alpha=0.4, linewidth=0)
    axes.plot(time, error, color=colour, linewidth=1.6)
    axes.axhline(0.0, color=_REFERENCE, ls="--", linewidth=1.0)


def _legend(figure: Figure, axes: Axes, found: Measurement, referred: bool) -> None:
    """One legend of all panels, outside of them."""
    colour = curve_colour(_MEAN, 4)
    many = found.group.runs > 1
    whose = "the mean" if many else "the run"
    equation = "Eq. (31)" if many else "Eq. (30)"
    if many:
        axes.plot([], [], color=_RUNS, alpha=0.6, label=f"{found.group.runs} runs")
    axes.plot([], [], color=colour, linewidth=2.0, label="their mean" if many else "velocity")
    nothing = ([0.0], [np.nan], [np.nan])
    axes.fill_between(
        *nothing, color=colour, alpha=0.4, linewidth=0,
        label=f"± uc of {whose} (k = 1), {equation}",
    )  # fmt: skip
    axes.fill_between(*nothing, color=_BAND, alpha=0.25, linewidth=0, label="95 %, Monte Carlo")
    if referred:
        axes.plot([], [], color=_REFERENCE, ls="--", label="reference")
    legend_outside(figure, axes)
