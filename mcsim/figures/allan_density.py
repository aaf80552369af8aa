"""A power spectral density beside the Allan deviation that belongs to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mcsim.figures.style import LINE_STYLES, curve_colour, house_style, log_scale

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DensityCurve:
    """``density`` (k,) two-sided, SI, over ``frequency`` (k,) in Hz."""

    label: str
    frequency: Array
    density: Array


@dataclass(frozen=True)
class AllanCurveLine:
    """``deviation`` (k,) in SI units over cluster times ``tau`` (k,) in s; dots if ``points``."""

    label: str
    tau: Array
    deviation: Array
    points: bool = False


def draw_density_and_curve(
    densities: DensityCurve | Sequence[DensityCurve],
    curves: Sequence[AllanCurveLine],
    one: float,
    unit: str,
    title: str = "",
) -> Figure:
    """Roots of one-sided densities on the left, Allan deviations on the right.

    ``one`` is an SI unit in ``unit``.
    """
    given = [densities] if isinstance(densities, DensityCurve) else list(densities)
    with house_style():
        figure = Figure(figsize=(9.6, 4.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        for k, curve in enumerate(given):
            root = np.sqrt(2.0 * curve.density) * one
            colour, style = _look(k, len(given))
            left.plot(curve.frequency, root, color=colour, linestyle=style, label=curve.label)
        for k, line in enumerate(curves):
            colour, style = _look(k, len(curves))
            style = "none" if line.points else style
            marker = "o" if line.points else ""
            value = line.deviation * one
            looks = {"color": colour, "linestyle": style, "marker": marker}
            right.plot(line.tau, value, label=line.label, **looks)
        _finish(left, "frequency [Hz]", f"root of the one-sided density [{unit}/√Hz]")
        _finish(right, "cluster time τ [s]", f"Allan deviation [{unit}]")
        if title:
            figure.suptitle(title, fontsize=10)
    return figure


def _look(index: int, count: int) -> tuple[object, str]:
    return curve_colour(index, max(count, 2)), LINE_STYLES[index % len(LINE_STYLES)]


def _finish(axes: Axes, horizontal: str, vertical: str) -> None:
    lines = [line for line in axes.get_lines() if np.any(np.isfinite(line.get_ydata()))]
    log_scale(axes, "x", np.concatenate([line.get_xdata() for line in lines]).tolist())
    values = np.concatenate([np.asarray(line.get_ydata(), float) for line in lines])
    positive = values[np.isfinite(values) & (values > 0.0)]
    low = max(float(positive.min()), 1e-4 * float(positive.max()))
    log_scale(axes, "y", [low, float(positive.max())])
    axes.set_ylim(0.6 * low, 1.8 * float(positive.max()))
    axes.set(xlabel=horizontal, ylabel=vertical)
    axes.legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, fontsize=7.5, handlelength=1.6
    )
