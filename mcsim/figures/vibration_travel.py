"""The picture of a run: velocity and height by integration, of all sensors beside the truth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcsim.figures.style import curve_colour, house_style, set_title
from mcsim.figures.vibration import legend_with_foot
from mcsim.vibration.comparison import Comparison
from mcsim.vibration.travel import HIGH_PASS, Motion

_TRUE = "#111827"
_FOOT = (
    "the high-pass acts on acceleration, velocity and height: it takes the run away with the "
    "drift, and leaves the hum"
)
#: A sensor whose height errs by more than this part of the way does not see the run.
_BLIND = 0.2


def draw_travel(found: Comparison, title: str) -> Figure:
    """A column per way of removing the drift: velocity, height, and what is wrong with both.

    Behind a high-pass, which leaves nothing of the run, what remains takes the errors' place.
    """
    assert found.motions is not None
    ways = list(dict.fromkeys(m.drift for motions in found.motions for m in motions))
    with house_style():
        figure = Figure(figsize=(1.6 + 3.2 * len(ways), 8.6), layout="constrained")
        panels = figure.subplots(4, len(ways), sharex=True, squeeze=False)
        for column, way in zip(panels.T, ways, strict=True):
            _draw(column, found, way)
            column[0].set_title(f"drift removed by {way}")
            column[3].set_xlabel("time [s]")
        _share(panels, ways)
        set_title(figure, f"{title}: velocity and height by integration")
        passed = any(map(_is_high_pass, ways))
        feet = [_FOOT] if passed else []
        blind = [
            s.seen.name for s, m in zip(found.sensors, found.motions, strict=True) if _blind(m)
        ]
        if blind:
            feet.append(f"{', '.join(blind)} does not see the run; its errors are left out")
        legend_with_foot(figure, panels[0, 0], ". ".join(feet))
    return figure


def _is_high_pass(way: str) -> bool:
    return way.startswith(HIGH_PASS)


def _blind(motions: Sequence[Motion]) -> bool:
    """Whether a sensor misses the run, as one that is AC-coupled does; its errors dwarf others'."""
    return any(
        np.max(np.abs(m.height - m.true_height)) > _BLIND * np.max(np.abs(m.true_height))
        for m in motions
        if not _is_high_pass(m.drift)
    )


def _share(panels: Any, ways: list[str]) -> None:
    """One scale per row; a column of its own for the errors' place behind a high-pass."""
    panels[0, 0].set_ylabel("velocity [m/s]")
    panels[1, 0].set_ylabel("height [m]")
    plain = [j for j, way in enumerate(ways) if not _is_high_pass(way)]
    for row in range(4):
        for j in range(1, len(ways)):
            if row < 2 or j in plain:
                panels[row, j].sharey(panels[row, 0])
                panels[row, j].tick_params(labelleft=False)
        panels[row, 0].autoscale()
    for j, way in enumerate(ways):
        if _is_high_pass(way):
            panels[2, j].set_ylabel("velocity left [mm/s]")
            panels[3, j].set_ylabel("height left [mm]")
        elif j == 0:
            panels[2, j].set_ylabel("error of velocity [mm/s]")
            panels[3, j].set_ylabel("error of height [mm]")


def _draw(column: Any, found: Comparison, way: str) -> None:
    assert found.motions is not None
    truth: Motion | None = None
    for i, (sensor, motions) in enumerate(zip(found.sensors, found.motions, strict=True)):
        for motion in motions:
            if motion.drift == way:
                truth = truth or motion
                colour = curve_colour(i, len(found.sensors))
                shown = column[:2] if _blind(motions) and not _is_high_pass(way) else column
                _draw_sensor(shown, motion, colour, sensor.seen.name)
    if truth is not None:
        style = {"color": _TRUE, "linewidth": 1.0, "linestyle": (0, (4, 3)), "label": "true"}
        column[0].plot(truth.time, truth.true_velocity, **style)
        column[1].plot(truth.time, truth.true_height, **style)


def _draw_sensor(column: Any, motion: Motion, colour: object, name: str) -> None:
    left = _is_high_pass(motion.drift)
    nothing = np.zeros_like(motion.time)
    curves = (
        motion.velocity,
        motion.height,
        1e3 * (motion.velocity - (nothing if left else motion.true_velocity)),
        1e3 * (motion.height - (nothing if left else motion.true_height)),
    )
    axes: Axes
    for axes, curve in zip(column, curves, strict=False):
        axes.plot(motion.time, curve, color=colour, linewidth=0.9, label=name)
