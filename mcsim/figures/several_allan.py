"""Several logs, or stretches of one, in one Allan plot: Figure 5.2."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcsim.characterisation.analysis import ChannelResult, Characterisation
from mcsim.characterisation.sensor_file import SAMPLE
from mcsim.figures.allan import legend_of, scale
from mcsim.figures.style import LINE_STYLES, curve_colour, house_style, log_scale, set_title
from mcsim.logs.model import AXES

_WIDTH, _HEIGHT = 4.1, 3.4


def draw_several(names: Sequence[str], found: Sequence[Characterisation], title: str) -> Figure:
    """A panel per channel, a curve per log, one scale for the axes of an element."""
    elements = [e for e in SAMPLE if any(log.of(e) for log in found)]
    shown = {
        e: [a for a in AXES if any(r.channel.axis == a for log in found for r in log.of(e))]
        for e in elements
    }
    columns = max(map(len, shown.values()))
    with house_style():
        size = (max(_WIDTH * columns, 6.4), _HEIGHT * len(elements) + 0.9)
        figure = Figure(figsize=size, layout="constrained")
        grid = figure.subplots(len(elements), columns, squeeze=False, sharey="row", sharex=True)
        for row, element in zip(grid, elements, strict=True):
            for axes, axis in zip(row, shown[element], strict=False):
                _panel(axes, names, found, element, axis)
            for axes in row[len(shown[element]) :]:
                axes.set_axis_off()
        _scales(grid[:, 0], found, elements)
        for axes in grid[-1]:
            axes.set_xlabel("cluster time τ [s]")
        legend_of(figure)
        set_title(figure, title)
    return figure


def _panel(
    axes: Axes, names: Sequence[str], found: Sequence[Characterisation], element: str, axis: str
) -> None:
    unit = ""
    for k, (name, log) in enumerate(zip(names, found, strict=True)):
        for result in log.of(element):
            if result.channel.axis == axis:
                unit = _curve(axes, result, name, k, len(names))
    axes.set_title(f"{element} {axis} [{unit}]", loc="left")


def _curve(axes: Axes, result: ChannelResult, name: str, k: int, count: int) -> str:
    convert, unit = scale(result)
    one, curve, colour = convert(1.0), result.curve, curve_colour(k, count)
    axes.fill_between(
        curve.tau, result.low * one, result.high * one, color=colour, alpha=0.15, lw=0
    )
    style = LINE_STYLES[k % len(LINE_STYLES)]
    axes.plot(curve.tau, curve.deviation * one, style, color=colour, label=name)
    return unit


def _scales(
    first: Iterable[Axes], found: Sequence[Characterisation], elements: Sequence[str]
) -> None:
    """Ranges that hold every curve; ends of intervals of few clusters may leave them."""
    times = np.concatenate([r.curve.tau for log in found for r in log.channels])
    for axes, element in zip(first, elements, strict=True):
        results = [r for log in found for r in log.of(element)]
        convert, _ = scale(results[0])
        low = 0.5 * min(float(r.low.min()) for r in results) * convert(1.0)
        high = 2.0 * max(float(r.curve.deviation.max()) for r in results) * convert(1.0)
        log_scale(axes, "x", times.tolist())
        log_scale(axes, "y", [low, high])
        axes.set_ylim(low, high)
        axes.set_ylabel("Allan deviation")
