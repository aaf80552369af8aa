"""Measured runs with their mean; the mean with its uncertainty against a reference, its error."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcsim.figures.style import curve_colour, house_style, legend_outside, set_title
from mcsim.measured_velocity.measurement import Measurement
from mcsim.measured_velocity.reference import Reference

_RUNS, _REFERENCE, _BAND = "#1b4965", "#d1495b", "#5c677d"
_MEAN = 2  # of the house's colours
_FACTOR = 1.959963984540054


def draw_velocity(found: Measurement, reference: Reference | None, title: str) -> Figure:
    """Figures 10 and 11: (a) the runs and their mean, (b) the mean with its corridor.

    With a reference the errors of the runs, and that of the mean with its corridor, stand beneath.
    """
    rows = 1 if reference is None or found.reference is None else 2
    with house_style():
        figure = Figure(figsize=(9.6, 3.9 if rows == 1 else 6.2), layout="constrained")
        ratios = (1.0,) if rows == 1 else (1.6, 1.0)
        panels = figure.subplots(
            rows, 2, sharex=True, sharey="row", squeeze=False, height_ratios=ratios
        )
        _draw_runs(panels[0, 0], found)
        _draw_mean(panels[0, 1], found)
        panels[0, 0].set_ylabel("velocity [m/s]")
        if reference is not None and found.reference is not None:
            panels[0, 1].plot(found.group.time, found.reference, color=_REFERENCE, ls="--")
            _draw_errors(panels[1, 0], panels[1, 1], found, reference)
            panels[1, 0].set_ylabel("velocity less\nreference [m/s]")
        for axes, letter in zip(panels.flat, "abcd", strict=False):
            axes.set_title(f"({letter})", loc="left")
        for axes in panels[-1]:
            axes.set_xlabel("time after the start of motion [s]")
        _legend(figure, panels[0, 1], found, rows == 2)
        set_title(figure, title)
    return figure


def _draw_runs(axes: Axes, found: Measurement) -> None:
    axes.plot(found.group.time, found.runs.T, color=_RUNS, alpha=0.45, linewidth=0.8)
    if found.group.runs > 1:
        axes.plot(found.group.time, found.mean, color=curve_colour(_MEAN, 4), linewidth=2.0)


def _draw_mean(axes: Axes, found: Measurement) -> None:
    time, mean, u = found.group.time, found.mean, found.summed
    colour = curve_colour(_MEAN, 4)
    axes.fill_between(time, found.drawn.low, found.drawn.high, color=_BAND, alpha=0.18, linewidth=0)
    axes.fill_between(time, mean - u, mean + u, color=colour, alpha=0.4, linewidth=0)  # type: ignore[arg-type]
    axes.plot(time, mean, color=colour, linewidth=1.6)  # type: ignore[arg-type]


def _draw_errors(left: Axes, right: Axes, found: Measurement, reference: Reference) -> None:
    time, given = found.group.time, found.reference
    assert given is not None
    of_runs = found.runs - (given if found.group.reference is None else found.group.reference)
    error, own = found.mean - given, reference.deviation(given)
    colour = curve_colour(_MEAN, 4)
    left.plot(time, of_runs.T, color=_RUNS, alpha=0.45, linewidth=0.8)
    if found.group.runs > 1:
        left.plot(time, error, color=colour, linewidth=2.0)  # type: ignore[arg-type]
    wide = _FACTOR * np.hypot(found.drawn.mean, own)
    right.fill_between(time, -wide, wide, color=_BAND, alpha=0.18, linewidth=0)
    narrow = np.hypot(found.summed, own)
    right.fill_between(time, -narrow, narrow, color=colour, alpha=0.4, linewidth=0)  # type: ignore[arg-type]
    right.plot(time, error, color=colour, linewidth=1.6)  # type: ignore[arg-type]
    for axes in (left, right):
        axes.axhline(0.0, color=_REFERENCE, ls="--", linewidth=1.0)


def _legend(figure: Figure, axes: Axes, found: Measurement, referred: bool) -> None:
    """One legend of all panels, outside of them."""
    colour = curve_colour(_MEAN, 4)
    many = found.group.runs > 1
    whose = "the mean" if many else "the run"
    equation = "Eq. (31)" if many else "Eq. (30)"
    axes.plot([], [], color=_RUNS, alpha=0.6, label=f"{found.group.runs} runs" if many else "run")
    if many:
        axes.plot([], [], color=colour, linewidth=2.0, label="their mean")  # type: ignore[arg-type]
    nothing = ([0.0], [np.nan], [np.nan])
    axes.fill_between(
        *nothing, color=colour, alpha=0.4, linewidth=0,  # type: ignore[arg-type]
        label=f"± uc of {whose} (k = 1), {equation}",
    )  # fmt: skip
    axes.fill_between(*nothing, color=_BAND, alpha=0.25, linewidth=0, label="95 %, Monte Carlo")
    if referred:
        axes.plot([], [], color=_REFERENCE, ls="--", label="reference")
    legend_outside(figure, axes)
