"""Distribution, autocorrelation and bias of a characterised log: Figures 5.3 to 5.5."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcsim.characterisation.analysis import Characterisation
from mcsim.characterisation.noise_view import ChannelView, probability
from mcsim.figures.allan import legend_of, panels, scale
from mcsim.figures.style import curve_colour, house_style, log_scale

_DATA, _TRACKED = (curve_colour(i, 6) for i in (0, 3))
_MEASURED = "#9aa5b1"

#: The axis of an autocorrelation is linear below this, logarithmic beyond.
_LINEAR = 0.01

Draw = Callable[[ChannelView, Axes], None]


def draw_histogram(found: Characterisation, views: Sequence[ChannelView]) -> Figure:
    """Figure 5.3: counts on a logarithmic axis, where a normal distribution is a parabola."""
    sentence = (
        "Noise without its slow part (moving average of 10 s). K² test of skewness and kurtosis; "
        "correlation and rounding allowed for; ± 95 % of a normal noise."
    )
    return _drawn(found, views, [sentence], _histogram)


def draw_autocorrelation(found: Characterisation, views: Sequence[ChannelView]) -> Figure:
    """Figure 5.4: of the samples, and of the bias that a moving average leaves."""
    length = views[0].course.smoothing
    sentence = (
        f"Samples up to a lag of {length:.3g} s, beyond it the bias: their moving average over "
        "that time. Bands: 95 % of the values where the correlation has ended before (Bartlett)."
    )
    return _drawn(found, views, [sentence], _autocorrelation, same_scale=True)


def draw_bias(found: Characterisation, views: Sequence[ChannelView]) -> Figure:
    """Figure 5.5: the bias as a moving average shows it, and as a Kalman filter tracks it."""
    length = views[0].course.smoothing
    sentence = (
        f"Less the log's mean. Measured: moving average over {length:.3g} s. Tracked: Kalman "
        "filter; its band holds the bias in 95 % of the time, if it is of the process that the "
        "filter supposes. ±: 95 %."
    )
    return _drawn(found, views, [sentence], _bias, same_scale=True)


def _drawn(
    found: Characterisation,
    views: Sequence[ChannelView],
    sentences: list[str],
    draw: Draw,
    same_scale: bool = False,
) -> Figure:
    with house_style():
        figure, pairs = panels(found, sentences)
        rows: dict[str, list[Axes]] = {}
        for seen, (result, axes) in zip(views, pairs, strict=True):
            draw(seen, axes)
            rows.setdefault(result.channel.element, []).append(axes)
        if same_scale:
            for row in rows.values():
                _share(row)
        legend_of(figure)
    return figure


def _share(row: list[Axes]) -> None:
    """One scale for the axes of an element: they are compared."""
    ends = np.array([axes.get_ylim() for axes in row])
    for axes in row:
        axes.set_ylim(ends[:, 0].min(), ends[:, 1].max())


def _histogram(seen: ChannelView, axes: Axes) -> None:
    convert, unit = scale(seen.result)
    found = seen.histogram
    edges = found.edges * convert(1.0)
    axes.stairs(found.counts, edges, fill=True, color=_DATA, alpha=0.35, label="samples")
    axes.stairs(found.expected, edges, color="black", lw=0.9, label="normal distribution")
    axes.set_yscale("log")
    log_scale(axes, "y", [0.5, 1e3])
    axes.set_ylim(0.5, 2.0 * max(float(found.counts.max()), float(found.expected.max())))
    largest = 1.05 * max(abs(edges[0]), abs(edges[-1]))
    axes.set_xlim(-largest, largest)
    axes.set(xlabel=f"{seen.result.channel.name} [{unit}]", ylabel="samples in a bin")
    lines = [f"σ {convert(found.deviation):.3g} {unit}", "too coarse for a test", ""]
    if (test := seen.normality) is not None:
        lines[1:] = [
            f"skewness {test.skewness:.2g} ± {1.96 * test.u_skewness:.1g}, "
            f"excess kurtosis {test.excess:.2g} ± {1.96 * test.u_excess:.1g}",
            f"{'normal' if test.is_normal else 'not normal'}: p {probability(test.p)}",
        ]
    _title(axes, lines)


def _autocorrelation(seen: ChannelView, axes: Axes) -> None:
    for found, colour, name in (
        (seen.of_samples, _DATA, "samples"),
        (seen.of_bias, _TRACKED, "bias"),
    ):
        label = f"95 % of none, {name}"
        axes.fill_between(
            found.lags, -found.band, found.band, color=colour, alpha=0.18, lw=0, label=label
        )
        axes.plot(found.lags, found.values, ".-", ms=2.5, lw=0.9, color=colour, label=name)
    lines = ["no bias stands out of the white noise", ""]
    if (model := seen.course.model) is not None:
        convert, unit = scale(seen.result)
        lags = seen.of_bias.lags
        # The rest of the average's variance is white noise, whose correlation has ended here.
        falls = model.deviation**2 / seen.of_bias.variance * np.exp(-lags / model.correlation_time)
        axes.plot(lags, falls, "--", color="black", lw=0.9, label="Gauss-Markov bias")
        fitted = seen.result.fit.gauss_markov is not None
        lines = [
            f"bias: {convert(model.deviation):.3g} {unit}, Tc {model.correlation_time:.3g} s",
            "as fitted" if fitted else "a stand-in: the fit has no Gauss-Markov bias",
        ]
    axes.axhline(0.0, color="#6b7280", linewidth=0.8, zorder=1.5)
    log_scale(axes, "x", [seen.of_samples.lags[0], seen.of_bias.lags[-1]])
    axes.set_yscale("symlog", linthresh=_LINEAR)
    ticks = (-1.0, -0.3, -0.1, -0.03, -0.01, 0.0, 0.01, 0.03, 0.1, 0.3, 1.0)
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks], minor=False)
    axes.set_ylim(-1.05, 1.05)
    name = seen.result.channel.name
    axes.set(xlabel="lag [s]", ylabel=f"{name}, autocorrelation [1]")
    _title(axes, lines)


def _bias(seen: ChannelView, axes: Axes) -> None:
    convert, unit = scale(seen.result)
    one, course = convert(1.0), seen.course
    time, unit_of_time = _hours(course.time)
    axes.plot(time, course.measured * one, color=_MEASURED, lw=0.6, label="measured")
    white = f"white noise in the measured bias ± {course.measured_band * one:.3g} {unit}"
    lines = ["no bias stands out of the white noise", "", white]
    if course.tracked is not None and course.tracked_band is not None and course.model is not None:
        low, high = course.tracked - course.tracked_band, course.tracked + course.tracked_band
        axes.fill_between(
            time,
            low * one,
            high * one,
            color=_TRACKED,
            alpha=0.3,
            lw=0,
            label="band of 95 %",
            zorder=2.2,
        )
        axes.plot(time, course.tracked * one, color=_TRACKED, lw=0.9, label="tracked")
        kind = "fitted" if seen.result.fit.gauss_markov is not None else "stand-in"
        lines[0] = (
            f"{kind} process: {course.model.deviation * one:.3g} {unit}, "
            f"Tc {course.model.correlation_time:.3g} s"
        )
        lines[1] = f"tracked bias ± {course.tracked_band[-1] * one:.3g} {unit}"
    axes.set(xlabel=f"time [{unit_of_time}]", ylabel=f"{seen.result.channel.name}, bias [{unit}]")
    _title(axes, lines)


def _hours(time: np.ndarray) -> tuple[np.ndarray, str]:
    return (time / 3600.0, "h") if time[-1] > 2.0 * 3600.0 else (time, "s")


def _title(axes: Axes, lines: list[str]) -> None:
    axes.set_title("\n".join(lines), fontsize=7.8, loc="left", linespacing=1.25)
