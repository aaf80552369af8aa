"""Annotated Allan deviations and spectra of a characterised log."""

from __future__ import annotations

import textwrap
from collections.abc import Callable

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcsim.characterisation.allan import allan_terms
from mcsim.characterisation.analysis import ChannelResult, Characterisation
from mcsim.characterisation.problem import TERMS, B, K, N, R
from mcsim.characterisation.sensor_file import SAMPLE, ramp
from mcsim.characterisation.spectrum import binned
from mcsim.characterisation.verdict import noise_density, number, verdict
from mcsim.figures.style import curve_colour, house_style, log_scale
from mcsim.units import KINDS, in_unit

_DATA, _CLEAN, _WHITE, _FLICKER, _WALK, _OTHER = (curve_colour(i, 6) for i in range(6))
_TERM_LOOKS = {"N": (_WHITE, ":"), "B": (_FLICKER, "--"), "K": (_FLICKER, "-."), "R": (_WALK, "--")}
_WIDTH, _HEIGHT = 4.1, 3.3
_VERDICT_SIGNS = 14.5  # characters of the verdict per inch


def draw_allan(found: Characterisation) -> Figure:
    """A panel per channel: curve and interval, model, its slopes with numbers; the verdict."""
    with house_style():
        figure, shown = panels(found, verdict(found))
        for result, axes in shown:
            _draw_curve(result, axes)
        legend_of(figure)
    return figure


def draw_psd(found: Characterisation) -> Figure:
    """A panel per channel: square root of the one-sided density, the model, the lines."""
    with house_style():
        figure, shown = panels(found, ["One-sided density: √2 N where the noise is white."])
        for result, axes in shown:
            _draw_spectrum(result, axes)
        legend_of(figure)
    return figure


def panels(
    found: Characterisation, sentences: list[str]
) -> tuple[Figure, list[tuple[ChannelResult, Axes]]]:
    """A panel per channel, elements one above the other, under the log's name and sentences."""
    rows = [results for element in SAMPLE if (results := found.of(element))]
    columns = max(map(len, rows))
    width = max(_WIDTH * columns, 6.4)
    lines = [
        line for text in sentences for line in textwrap.wrap(text, int(width * _VERDICT_SIGNS))
    ]
    figure = Figure(
        figsize=(width, _HEIGHT * len(rows) + 0.75 + 0.17 * len(lines)), layout="constrained"
    )
    grid = figure.subplots(len(rows), columns, squeeze=False)
    pairs = []
    for i, results in enumerate(rows):
        for j in range(columns):
            if j < len(results):
                pairs.append((results[j], grid[i, j]))
            else:
                grid[i, j].set_axis_off()
    log = found.log
    name = textwrap.shorten(log.path.name, 60)
    figure.suptitle(
        f"{name} – {log.duration / 3600.0:.3g} h at {log.rate:.4g} Hz\n" + "\n".join(lines),
        fontsize=9.5,
        x=0.01,
        ha="left",
    )
    return figure, pairs


def scale(result: ChannelResult) -> tuple[Callable[[float], float], str]:
    """What makes a channel's SI values those of the unit that figures show, and that unit."""
    kind, unit = SAMPLE[result.channel.element]
    return (lambda value: in_unit(value, unit, KINDS[kind])), unit


def _draw_curve(result: ChannelResult, axes: Axes) -> None:
    convert, unit = scale(result)
    one = convert(1.0)
    curve, fit = result.curve, result.fit
    tau, deviation = curve.tau, curve.deviation * one
    axes.fill_between(tau, result.low * one, result.high * one, color=_DATA, alpha=0.18, lw=0)
    axes.plot(tau, deviation, color=_DATA, label="Allan deviation with interval")
    if result.fitted is not curve and not np.array_equal(result.fitted.variance, curve.variance):
        axes.plot(
            tau,
            result.fitted.deviation * one,
            color=_CLEAN,
            linewidth=1.0,
            label="without spikes, lines, warm-up",
        )
    inside = (tau >= fit.tau_from) & (tau <= fit.tau_to)
    axes.plot(
        tau[inside], fit.deviation(tau[inside]) * one, color="black", lw=0.9, label="fitted model"
    )
    bottom = 0.4 * min(float(np.min(deviation)), float(np.min(result.fitted.deviation)) * one)
    for term, index, label in (
        ("N", N, "N: slope −1/2"),
        ("B", B, "B: level 0.664 B"),
        ("K", K, "K: slope +1/2"),
        ("R", R, "R: slope +1"),
    ):
        squares = fit.model_squares
        if squares[index] > 0.0:
            line = np.sqrt(allan_terms(tau)[:, index] * squares[index]) * one
            colour, style = _TERM_LOOKS[term]
            line = np.where(line > bottom, line, np.nan)
            axes.plot(tau, line, linestyle=style, color=colour, lw=1.0, label=label)
    if fit.gauss_markov is not None:
        line = np.sqrt(fit.gauss_markov.model.allan_variance(tau)) * one
        line = np.where(line > bottom, line, np.nan)
        axes.plot(tau, line, linestyle="--", color=_OTHER, lw=1.0, label="Gauss-Markov bias")
    log_scale(axes, "x", tau.tolist())
    axes.set_yscale("log")
    log_scale(axes, "y", [bottom, 2.0 * float(np.max(result.high)) * one])
    axes.set_ylim(bottom, 1.6 * max(float(deviation.max()), float(np.median(result.high)) * one))
    axes.set(xlabel="cluster time τ [s]", ylabel=f"{result.channel.name} [{unit}]")
    _numbers(result, axes)


def _numbers(result: ChannelResult, axes: Axes) -> None:
    element, fit = result.channel.element, result.fit
    process = fit.gauss_markov
    slow = [t for t in ("B", "K") if process is None or process.coefficient(TERMS.index(t))]
    lines = [f"{term} {number(fit, element, term)}" for term in ("N", *slow)]
    lines.insert(1, f"   = {noise_density(result)} one-sided")
    if process is not None:
        convert, unit = scale(result)
        model = process.model
        lines.append(
            f"Gauss-Markov bias: {convert(model.deviation):.3g} {unit}, "
            f"Tc {model.correlation_time:.3g} s"
        )
    if "Q" in fit.coefficients:
        lines.append("with Q in the model")
    if "R" in fit.coefficients:
        lines.append(f"R {ramp(element, fit['R']).split(' (')[0]}")
    if result.inspection.warm_up is not None:
        convert, unit = scale(result)
        warm_up = result.inspection.warm_up
        lines.append(
            f"warm-up of {convert(-warm_up.size):.3g} {unit} in {warm_up.time:.3g} s left out"
        )
    axes.set_title("\n".join(lines), fontsize=7.8, loc="left", linespacing=1.25)


def _draw_spectrum(result: ChannelResult, axes: Axes) -> None:
    convert, unit = scale(result)
    one = convert(1.0)
    frequency, density, _ = binned(result.inspection.spectrum, 60)
    axes.plot(frequency, np.sqrt(density) * one, color=_DATA, lw=0.9, label="density")
    squares, process = result.fit.model_squares, result.fit.gauss_markov
    model = 2.0 * (
        squares[N]
        + squares[B] / (2.0 * np.pi * frequency)
        + squares[K] / (2 * np.pi * frequency) ** 2
    )
    if process is not None:
        model += 2.0 * process.model.density(frequency)
    axes.plot(
        frequency, np.sqrt(model) * one, color="black", lw=0.9, label="model of the Allan fit"
    )
    white = float(np.sqrt(2.0)) * result.floor * one
    axes.axhline(white, color=_WHITE, linestyle=":", label="floor of the spectrum")
    strong = sorted(result.inspection.lines, key=lambda line: -line.raises)[:5]
    for k, line in enumerate([x for x in strong if x.raises > 1.01]):
        axes.axvspan(
            line.low, line.high, color=_FLICKER, alpha=0.3, lw=0, label="lines" if k == 0 else None
        )
    log_scale(axes, "x", frequency.tolist())
    log_scale(axes, "y", (np.sqrt(density) * one).tolist())
    axes.set(xlabel="frequency [Hz]", ylabel=f"{result.channel.name} [{unit}/√Hz]")


def legend_of(figure: Figure) -> None:
    """One legend for all panels: a term that only some of them show is in it once."""
    found: dict[str, Artist] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    columns = max(1, min(len(found), int(figure.get_figwidth() / 1.9)))
    figure.legend(list(found.values()), list(found), loc="outside lower center", ncols=columns)
