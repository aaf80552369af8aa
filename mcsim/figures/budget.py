"""Figures of the velocity case: shares of the variance, and uncertainty over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcsim.figures.style import curve_colour, house_style, set_title
from mcsim.gum import Budget, BudgetRow, Course

#: Smaller shares are drawn together.
_LEAST_SHARE = 0.005
_SUMMED, _SIMULATED = "#1b4965", "#d1495b"


def draw_shares(
    budgets: Sequence[Budget], names: Sequence[str], output: Literal["Dv", "acx"], title: str
) -> Figure:
    """Shares of the variance of one output, a panel per budget: Figures 13 and 14."""
    with house_style():
        figure = Figure(figsize=(4.6 * len(budgets), 3.0), layout="constrained")
        panels = figure.subplots(1, len(budgets), squeeze=False)[0]
        for axes, budget, name in zip(panels, budgets, names, strict=True):
            _draw_bars(axes, budget.group(output))
            axes.set_title(f"{name}: u = {budget.uncertainty(output):.2g} {_UNITS[output]}")
        set_title(figure, title)
    return figure


_UNITS = {"Dv": "m/s", "acx": "g"}


def _draw_bars(axes: Axes, rows: Sequence[BudgetRow]) -> None:
    total = sum(row.variance for row in rows)
    if not total > 0.0:
        axes.set_axis_off()
        axes.annotate("no uncertainty", (0.5, 0.5), xycoords="axes fraction", ha="center")
        return
    shares = sorted(((row.variance / total, row.quantity) for row in rows), reverse=True)
    shown = [(share, name) for share, name in shares if share >= _LEAST_SHARE]
    rest = [(share, name) for share, name in shares if share < _LEAST_SHARE]
    if rest:
        names = rest[0][1] if len(rest) == 1 else f"{len(rest)} others"
        shown.append((sum(share for share, _ in rest), names))
    position = np.arange(len(shown))
    axes.barh(position, [100.0 * share for share, _ in shown], color=_SUMMED, height=0.62)
    for y, (share, _) in zip(position, shown, strict=True):
        text = f"{share:.1%}" if share >= 0.001 else "< 0.1%"
        axes.annotate(text, (100.0 * share, y), (3, 0), textcoords="offset points", va="center")
    axes.set_yticks(position, [name for _, name in shown])
    axes.invert_yaxis()
    axes.set_xlim(0.0, 115.0 * shown[0][0])
    axes.set_xlabel("share of the variance [%]")
    axes.grid(visible=False, axis="y")


def draw_comparison(course: Course, title: str) -> Figure:
    """u(v) over time by Eq. (30), Eq. (31) and Monte Carlo, and source by source at the end."""
    with house_style():
        figure = Figure(figsize=(10.4, 4.0), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
        run, mean = "one run", f"mean of {course.runs}"
        left.plot(course.time, course.summed_total, color=_SUMMED, label=f"Eq. (30), {run}")
        if course.runs > 1:
            left.plot(
                course.time, course.summed_mean, color=_SUMMED, ls="--", label=f"Eq. (31), {mean}"
            )
        left.plot(course.time, course.total, color=_SIMULATED, label=f"Monte Carlo, {run}")
        if course.runs > 1:
            left.plot(
                course.time,
                course.total_mean,
                color=_SIMULATED,
                ls="--",
                label=f"Monte Carlo, {mean}",
            )
        left.set_xlabel("time after the start [s]")
        left.set_ylabel("standard uncertainty of the velocity [m/s]")
        left.set_ylim(bottom=0.0)
        left.legend(loc="upper left")
        _draw_sources(right, course)
        set_title(figure, title)
    return figure


def _draw_sources(axes: Axes, course: Course) -> None:
    largest = max(course.summed_total[-1], course.total[-1])
    # The equations know nothing of some sources.
    by_sums = {name: course.summed.get(name, np.zeros(1))[-1] for name in course.simulated}
    names = [
        name
        for name, values in course.simulated.items()
        if max(by_sums[name], values[-1]) > 1e-3 * largest
    ]
    y = np.arange(len(names) + 1)
    summed = [*(by_sums[name] for name in names), course.summed_total[-1]]
    simulated = [*(course.simulated[name][-1] for name in names), course.total[-1]]
    axes.barh(y - 0.19, summed, 0.36, color=_SUMMED, label="Eq. (30)")
    axes.barh(y + 0.19, simulated, 0.36, color=_SIMULATED, label="Monte Carlo")
    for offset, values in ((-0.19, summed), (0.19, simulated)):
        for position, value in zip(y, values, strict=True):
            axes.annotate(
                f"{value:.2g}" if value > 0.0 else "left out",
                (value, position + offset),
                (3, 0),
                textcoords="offset points",
                va="center",
                fontsize=7.5,
            )
    axes.set_yticks(y, [*names, "all together"])
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.15 * max(*summed, *simulated) or 1.0)
    axes.set_xlabel(f"u(v) of one run after {course.time[-1]:.3g} s, source alone [m/s]")
    axes.grid(visible=False, axis="y")
    axes.legend(loc="upper right")


def draw_runs(
    time: np.ndarray, runs: np.ndarray, truth: np.ndarray, u_mean: np.ndarray, title: str
) -> Figure:
    """Repeated runs with their mean, and the mean with its uncertainty: Figures 10 and 11.

    ``runs`` (n + 1, m) velocities in m/s; ``u_mean`` (n + 1,) the uncertainty of their mean.
    """
    mean = runs.mean(axis=1)
    with house_style():
        figure = Figure(figsize=(9.6, 3.6), layout="constrained")
        left, right = figure.subplots(1, 2, sharey=True)
        left.plot(time, runs, color=_SUMMED, alpha=0.45, linewidth=0.8)
        left.plot([], [], color=_SUMMED, alpha=0.6, label=f"{runs.shape[1]} simulated runs")
        left.plot(time, mean, color=curve_colour(2, 4), linewidth=2.0, label="their mean")
        right.fill_between(
            time,
            mean - u_mean,
            mean + u_mean,
            color=curve_colour(2, 4),
            alpha=0.3,
            linewidth=0,
            label="± uc of the mean (k = 1), Eq. (31)",
        )
        right.plot(time, mean, color=curve_colour(2, 4), linewidth=1.6, label="mean")
        right.plot(time, truth, color=_SIMULATED, ls="--", label="true velocity")
        left.set_ylabel("velocity [m/s]")
        for axes, letter in ((left, "a"), (right, "b")):
            axes.set_xlabel("time after the start [s]")
            axes.set_title(f"({letter})", loc="left")
            axes.legend(loc="lower center")
        set_title(figure, title)
    return figure
