"""Figure of a body that swings back after braking."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mcsim.figures.style import MARKERS, curve_colour, house_style, log_scale, set_title

Array = NDArray[np.float64]

_WHEELS, _MEASURED, _GRAVITY, _OWN = "#d1495b", "#1b4965", "#e9a03b", "#2a9d8f"


class Course(Protocol):
    """What is drawn over time (s): velocities and their error (m/s), and the pitch (rad)."""

    @property
    def time(self) -> Array: ...
    @property
    def wheels(self) -> Array: ...
    @property
    def error(self) -> Array: ...
    @property
    def by_gravity(self) -> Array: ...
    @property
    def uncertainty(self) -> Array: ...
    @property
    def pitch(self) -> Array: ...


def draw_braking(
    course: Course, frequencies: Array, lowest: Mapping[float, Array], title: str
) -> Figure:
    """Velocity, its error and the pitch over time; the lowest velocity over natural frequency.

    ``lowest`` holds velocities (k,) in m/s over ``frequencies`` (k,) in Hz by height (m).
    """
    with house_style():
        figure = Figure(figsize=(11.0, 6.2), layout="constrained")
        grid = figure.add_gridspec(3, 2, width_ratios=(1.5, 1.0), height_ratios=(1.0, 1.3, 0.8))
        first = figure.add_subplot(grid[0, 0])
        second, third = (figure.add_subplot(grid[i, 0], sharex=first) for i in (1, 2))
        _draw_velocity(first, course)
        _draw_error(second, course)
        _draw_pitch(third, course)
        for axes in (first, second):
            axes.tick_params(labelbottom=False)
        _draw_lowest(figure.add_subplot(grid[:, 1]), frequencies, lowest)
        set_title(figure, title)
    return figure


def _draw_velocity(axes: Axes, course: Course) -> None:
    measured = course.wheels + course.error
    axes.plot(course.time, course.wheels, color=_WHEELS, ls="--", label="wheels")
    axes.plot(course.time, measured, color=_MEASURED, label="by the accelerometer")
    axes.set_ylabel("velocity [m/s]")
    axes.legend(loc="upper right")


def _draw_error(axes: Axes, course: Course) -> None:
    u = course.uncertainty
    axes.fill_between(
        course.time, -u, u, color=_MEASURED, alpha=0.12, linewidth=0, label="± uc of the mean"
    )
    axes.plot(course.time, course.error, color=_MEASURED, label="whole error")
    axes.plot(course.time, course.by_gravity, color=_GRAVITY, ls="--", label="gravity on axis x")
    own = course.error - course.by_gravity
    axes.plot(course.time, own, color=_OWN, ls=":", label="the sensor's own swing")
    axes.set_ylabel("error against the wheels [m/s]")
    axes.legend(loc="lower left", ncols=2)
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.35 * (high - low), high)


def _draw_pitch(axes: Axes, course: Course) -> None:
    axes.plot(course.time, np.degrees(course.pitch), color=_MEASURED)
    axes.set_ylabel("pitch, nose up [°]")
    axes.set_xlabel("time after the start [s]")


def _draw_lowest(axes: Axes, frequencies: Array, lowest: Mapping[float, Array]) -> None:
    for i, (height, values) in enumerate(lowest.items()):
        colour = curve_colour(i, len(lowest))
        every = max(1, len(frequencies) // 9)
        label = f"sensor {height:g} m above the pitch axis"
        axes.plot(
            frequencies, values, color=colour, marker=MARKERS[i], markevery=every, label=label
        )
    log_scale(axes, "x", frequencies.tolist())
    axes.set_xlabel("natural frequency of the body [Hz]")
    axes.set_ylabel("lowest velocity after braking [m/s]")
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.3 * (high - low), min(high, 0.0))
    axes.legend(loc="lower right")
