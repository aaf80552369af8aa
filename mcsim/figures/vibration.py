"""The picture of a vibration: over time, spectra with engine orders, spectrogram."""

from __future__ import annotations

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mcsim.figures.style import house_style, log_scale, set_title
from mcsim.vibration.analysis import Analysis
from mcsim.vibration.excitations.excitation import Tone
from mcsim.vibration.filter_words import in_short
from mcsim.vibration.spectra import Spectrum

RAW, FILTERED = "#b8c0cc", "#1b4965"
ORDER = "#d1495b"
#: Points of a curve over time beyond which its envelope is drawn instead.
_MOST_POINTS = 4000
#: The spectra reach to this multiple of the low-pass, and show at most these many decades.
_FREQUENCIES, _DECADES = 2.0, 8.0
#: Share of a spectrum's values (%) that lies below its noise floor's lower edge.
_FLOOR = 10.0
#: Range of a spectrogram's colours (dB).
_COLOURS = 60.0


def draw_vibration(analysis: Analysis, title: str, channel: int | None = None) -> Figure:
    """One channel (the strongest if none is named): time, amplitude, Welch, spectrogram."""
    index = analysis.strongest if channel is None else channel
    with house_style():
        figure = Figure(figsize=(10.4, 7.4), layout="constrained")
        axes = figure.subplot_mosaic(
            [["time", "time"], ["amplitude", "density"], ["map", "map"]],
            height_ratios=[1.0, 1.25, 1.0],
        )
        _over_time(axes["time"], analysis, index)
        _spectrum(axes["amplitude"], analysis, analysis.amplitude, index)
        axes["amplitude"].set_ylabel("amplitude, Hann [m/s²]")
        _spectrum(axes["density"], analysis, analysis.welch, index)
        axes["density"].set_ylabel("density, Welch [(m/s²)²/Hz]")
        _spectrogram(figure, axes["map"], analysis, index)
        set_title(figure, f"{title} – {analysis.log.channels[index]} axis")
        legend_with_foot(figure, axes["time"], f"filtered: {in_short(analysis.filters)}")
    return figure


def legend_with_foot(figure: Figure, axes: Axes, text: str) -> None:
    """One legend below all panels, under a line that says how the picture was made."""
    handles, labels = axes.get_legend_handles_labels()
    width = 0.075 * max(map(len, labels)) + 0.55
    legend = figure.legend(
        handles,
        labels,
        loc="outside lower center",
        ncols=max(1, min(len(labels), int(figure.get_figwidth() / width))),
        title="\n".join(textwrap.wrap(text, int(15.0 * figure.get_figwidth()))),
    )
    legend.get_title().set(fontsize=7.5, color="#6b7280", ha="center")


def _over_time(axes: Axes, analysis: Analysis, channel: int) -> None:
    time = analysis.log.time
    for signal, colour, label in (
        (analysis.raw, RAW, "raw, mean removed"),
        (analysis.filtered, FILTERED, f"filtered, {_band(analysis)}"),
    ):
        draw_curve(axes, time, signal[:, channel], colour, label)
    axes.set(xlabel="time [s]", ylabel="acceleration [m/s²]")
    axes.set_xlim(time[0], time[-1])


def _band(analysis: Analysis) -> str:
    chain = analysis.filters.chain
    return f"{chain.high_pass:g} to {chain.low_pass:g} Hz (−6 dB)"


def draw_curve(
    axes: Axes, time: NDArray[np.float64], signal: NDArray[np.float64], colour: str, label: str
) -> None:
    """A curve; of a long one, the band between its extremes."""
    bins = len(signal) // (_MOST_POINTS // 2)
    if bins < 2:
        axes.plot(time, signal, color=colour, linewidth=0.8, label=label)
        return
    count = len(signal) // bins
    parts = signal[: count * bins].reshape(count, bins)
    axes.fill_between(
        time[: count * bins : bins],
        parts.min(axis=1),
        parts.max(axis=1),
        color=colour,
        linewidth=0.5,
        label=label,
    )


def _spectrum(
    axes: Axes, analysis: Analysis, pair: tuple[Spectrum, Spectrum], channel: int
) -> None:
    top = floor = 0.0
    highest = _highest(analysis)
    for spectrum, colour in zip(pair, (RAW, FILTERED), strict=True):
        shown = (spectrum.frequency > 0.0) & (spectrum.frequency <= highest)
        levels = spectrum.levels[shown, channel]
        axes.plot(spectrum.frequency[shown], levels, color=colour, linewidth=1.0)
        top = max(top, float(levels.max()))
        floor = max(floor, float(np.percentile(levels, _FLOOR)))
    # A decade below the noise of the raw signal, unless that is out of sight.
    lowest = max(0.1 * floor, top * 10.0**-_DECADES)
    log_scale(axes, "y", [lowest, top])
    axes.set_ylim(lowest, 3.0 * top)
    axes.set_xlim(0.0, highest)
    axes.set_xlabel("frequency [Hz]")
    _mark_orders(axes, analysis, highest)


def _highest(analysis: Analysis) -> float:
    nyquist = analysis.log.rate / 2.0
    wanted = _FREQUENCIES * analysis.filters.chain.low_pass
    return min(nyquist, wanted) if wanted > 0.0 else nyquist


def _mark_orders(axes: Axes, analysis: Analysis, highest: float) -> None:
    for tone in analysis.tones:
        frequency = tone.frequency
        if frequency > highest:
            continue
        axes.axvline(frequency, color=ORDER, linewidth=0.8, linestyle="--", zorder=1.5)
        axes.annotate(
            tone_words(tone),
            (frequency, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(3, -2),
            textcoords="offset points",
            color=ORDER,
            fontsize=7.5,
            rotation=90,
            va="top",
        )


def tone_words(tone: Tone) -> str:
    """A tone by name and frequency, which some have in their names."""
    return tone.name if tone.name.endswith("Hz") else f"{tone.name}: {tone.frequency:.4g} Hz"


def _spectrogram(figure: Figure, axes: Axes, analysis: Analysis, channel: int) -> None:
    shown = analysis.spectrogram(channel)
    keep = shown.frequency <= _highest(analysis)
    levels = 10.0 * np.log10(np.maximum(shown.density[keep], 1e-30))
    top = float(levels.max())
    image = axes.pcolormesh(
        shown.time,
        shown.frequency[keep],
        levels,
        cmap="viridis",
        vmin=top - _COLOURS,
        vmax=top,
        shading="nearest",
        rasterized=True,
    )
    axes.grid(visible=False)
    axes.set(xlabel="time [s]", ylabel="frequency [Hz]")
    axes.set_xlim(0.0, analysis.log.time[-1])
    figure.colorbar(image, ax=axes, label="raw density [dB re 1 (m/s²)²/Hz]", pad=0.01)
