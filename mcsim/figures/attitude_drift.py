"""Errors of a drifting attitude over time: level frame, round earth, simulated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mcsim.figures.style import curve_colour, house_style, log_scale, set_title
from mcsim.simulation.attitude_drift import (
    ANGLE_RANDOM_WALK,
    STATED,
    TILT,
    TURN_RATE,
    Drift,
    Growth,
    lasts,
    on_level_ground,
    on_round_earth,
)
from mcsim.simulation.limits import SMALL_TILT

#: What the panels show; each shades the times from which the level frame is off by that share.
_PANELS: tuple[tuple[str, tuple[str, ...], Growth], ...] = (
    ("tilt, constant or levelled", ("tilt", "levelled"), TILT),
    ("bias of the gyroscope", ("gyroscope bias",), TURN_RATE),
    ("angle random walk of the gyroscope", ("angle random walk",), ANGLE_RANDOM_WALK),
)
_TICKS = {1.0: "1 s", 10.0: "10 s", 60.0: "1 min", 600.0: "10 min", 3600.0: "1 h"}
_GREY = "#6b7280"
#: Vertical range (m), with room for the name of the shade; smaller errors matter to nobody.
_LEAST, _MOST = 1e-4, 3e7


def draw_drifts(entries: Sequence[Drift]) -> Figure:
    """Position error over time, a panel per kind of error of the attitude."""
    with house_style():
        figure = Figure(figsize=(13.0, 5.2), layout="constrained")
        panels = figure.subplots(1, len(_PANELS), sharex=True, sharey=True)
        for axes, (title, groups, growth) in zip(panels, _PANELS, strict=True):
            axes.set_title(title)
            _draw_panel(axes, [e for e in entries if e.source.group in groups], growth)
        panels[0].set_ylabel("position error, one standard deviation [m]")
        figure.legend(handles=_lines(), loc="outside lower center", ncols=4)
        set_title(figure, "A vehicle whose attitude drifts: gravity leaks into the position")
    return figure


def _draw_panel(axes: Axes, entries: Sequence[Drift], growth: Growth) -> None:
    drawn = [e for e in entries if e.flat > 0.0]
    names = list(dict.fromkeys(entry.source.name for entry in drawn))
    for k, name in enumerate(names):
        own = [entry for entry in drawn if entry.source.name == name]
        _draw_source(axes, own, curve_colour(k, len(names)))
    log_scale(axes, "x", [min(_TICKS), max(_TICKS)])
    log_scale(axes, "y", [_LEAST, _MOST])
    axes.set_xticks(list(_TICKS), list(_TICKS.values()))
    axes.set_xlim(0.9, 4000.0)
    axes.set_ylim(_LEAST, _MOST)
    axes.set_xlabel("time since the attitude was right" if growth is not TILT else "time")
    begins = lasts(growth, STATED)
    axes.axvspan(begins, 4000.0, color="#eef0f3", zorder=0.5)
    axes.annotate(
        f"flat model more\nthan {STATED:.0%} too large ",
        (begins, _LEAST),
        (-4, 6),
        textcoords="offset points",
        ha="right",
        fontsize=7.5,
        color=_GREY,
    )
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.14))


def _draw_source(axes: Axes, own: Sequence[Drift], colour: Any) -> None:
    """Closed forms for as long as the tilt is small; simulated values beyond are hollow."""
    source = own[0].source
    times = np.geomspace(min(_TICKS), max(_TICKS), 200)
    times = times[[source.size * source.growth.tilt(float(t)) <= SMALL_TILT for t in times]]
    for response, style in ((on_level_ground, "-"), (on_round_earth, "--")):
        values = [source.size * source.growth.position(response, float(t)) for t in times]
        label = source.name if style == "-" else None
        axes.plot(times, values, color=colour, linestyle=style, label=label)
    for entry in own:
        face = colour if entry.tilt <= SMALL_TILT else "white"
        axes.plot(entry.time, entry.simulated, marker="o", color=colour, markerfacecolor=face)


def _lines() -> list[Line2D]:
    """What the styles mean."""
    return [
        Line2D([], [], color=_GREY, label="flat, closed form"),
        Line2D([], [], color=_GREY, linestyle="--", label="round earth (Schuler), closed form"),
        Line2D([], [], color=_GREY, linestyle="none", marker="o", label="simulated, flat"),
        Line2D(
            [],
            [],
            color=_GREY,
            linestyle="none",
            marker="o",
            markerfacecolor="white",
            label=f"tilt beyond {np.degrees(SMALL_TILT):.0f}°",
        ),
    ]
