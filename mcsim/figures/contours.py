"""Contour lines of maps, through values as they stand on the axes.

Between points of a logarithmic axis they are interpolated in logarithms, so that the contours of a
power law are straight.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from mcsim.figures.style import spans_decades
from mcsim.scenario.axes import Axis

Array = NDArray[np.float64]

#: Group id of the limit's contour.
LIMIT = "limit"
#: Steps between two points that contour lines are drawn through.
_FINER = 8
#: Within a decade contour lines stand at these, where values span at most so many decades.
_STEPS = ((2.0, (1.0, 2.0, 5.0)), (4.0, (1.0, 3.0)), (math.inf, (1.0,)))
#: Ink on light and on dark colours, and that of limits.
DARK, _LIMIT = "#1f2933", "#d1495b"


def numbers(axis: Axis) -> Array:
    return np.array([float(value) for value in axis.values])


def is_log(axis: Axis) -> bool:
    return axis.log or spans_decades(numbers(axis))


class Lines:
    """Contour lines of a map of ``values`` (y, x); the heights are logarithms where ``log``."""

    def __init__(self, axes: Axes, x_axis: Axis, y_axis: Axis, values: Array, log: bool) -> None:
        self._axes, self._log = axes, log
        known = values[np.isfinite(values)]
        self._ends = (float(known.min()), float(known.max())) if len(known) else (0.0, 0.0)
        x, self._x = _finer(numbers(x_axis), is_log(x_axis))
        y, self._y = _finer(numbers(y_axis), is_log(y_axis))
        heights = _interpolated(np.log10(values) if log else values, x, y)
        self._heights = np.ma.masked_invalid(heights)

    def draw(self, levels: Array, words: str, **style: Any) -> Any:
        """Lines at some levels that the map reaches, with their values; None without any."""
        levels = levels[(levels > self._ends[0]) & (levels < self._ends[1])]
        if not len(levels):
            return None
        heights = np.log10(levels) if self._log else levels
        lines = self._axes.contour(
            self._x, self._y, self._heights, levels=heights, linestyles="solid", **style
        )
        for text in self._axes.clabel(
            lines, fontsize=7.5, fmt=lambda h: words.format(10.0**h if self._log else h)
        ):
            text.set_path_effects([patheffects.withStroke(linewidth=2.0, foreground=DARK)])
            text.set_color("white")
        return lines

    def draw_limit(self, limit: float, unit: str) -> None:
        """The requirement, in bold, with the sign of its unit."""
        words = f"{{:.3g}} {unit}"
        bold = self.draw(np.array([limit]), words, colors=_LIMIT, linewidths=2.2)
        if bold is not None:
            bold.set_path_effects([patheffects.withStroke(linewidth=3.6, foreground="white")])
            bold.set_gid(LIMIT)


def levels_of(values: Array, log: bool) -> Array:
    """Round values between the least and the greatest."""
    if not len(values) or np.ptp(values) == 0.0:
        return np.zeros(0)
    low, high = float(values.min()), float(values.max())
    if not log:
        return np.asarray(MaxNLocator(7).tick_values(low, high), float)
    decades = np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1.0)
    steps = steps_of(low, high)
    return np.array([step * 10.0**decade for decade in decades for step in steps])


def steps_of(low: float, high: float) -> tuple[float, ...]:
    """Where lines stand within a decade."""
    return next(steps for most, steps in _STEPS if np.log10(high / low) <= most)


def _finer(values: Array, log: bool) -> tuple[Array, Array]:
    """Where fine points stand among the coarse ones, counted from 0, and their values."""
    at = np.linspace(0.0, len(values) - 1.0, (len(values) - 1) * _FINER + 1)
    own = np.log(values) if log else values
    fine = np.interp(at, np.arange(len(values)), own)
    return at, np.exp(fine) if log else fine


def _interpolated(values: Array, x: Array, y: Array) -> Array:
    """Values (y, x) linearly between their points; unknown beside an unknown one."""
    points = [np.arange(float(count)) for count in values.shape]
    rows = np.array([np.interp(x, points[1], row) for row in values])
    return np.array([np.interp(y, points[0], column) for column in rows.T]).T
