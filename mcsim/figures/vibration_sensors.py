"""The picture of sensors beside each other: a stretch of time and the spectrum of each."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcsim.figures.style import house_style, log_scale, set_title
from mcsim.figures.vibration import FILTERED, ORDER, RAW, draw_curve, legend_with_foot, tone_words
from mcsim.vibration.comparison import Comparison, Filtered
from mcsim.vibration.filter_words import band, design

#: A steady vibration is shown for so many periods of its lowest tone.
_PERIODS = 10.0
#: Spectra reach to this multiple of the low-pass or of the highest tone, over so many decades.
_OF_LOW_PASS, _OF_TONE, _DECADES = 2.0, 1.25, 6.0
_IDEAL = "#d1495b"


def draw_sensors(found: Comparison, title: str) -> Figure:
    """A row per sensor on shared axes: acceleration over time, and amplitude over frequency."""
    count = len(found.sensors)
    first, last = _stretch(found)
    with house_style():
        figure = Figure(figsize=(10.4, 1.4 + 1.25 * count), layout="constrained")
        panels = figure.subplots(count, 2, sharex="col", sharey="col", squeeze=False)
        for (time, spectrum), sensor in zip(panels, found.sensors, strict=True):
            _over_time(time, sensor, first, last)
            if _is_short(found):
                _draw_truth(time, sensor, first, last)
            _over_frequency(spectrum, sensor)
            time.set_title(_name(found, sensor), loc="left", fontsize=8.5)
            spectrum.set_title(_chain(sensor), loc="left", fontsize=8.5)
        panels[-1, 0].set(xlabel="time [s]", xlim=(first, last))
        panels[-1, 1].set(xlabel="frequency [Hz]")
        _share_spectra(panels[:, 1], found)
        # In the middle of all rows: the upper edge of one of them where their number is even.
        height = 1.0 if count % 2 == 0 else 0.5
        panels[count // 2, 0].set_ylabel("acceleration [m/s²]", y=height)
        panels[count // 2, 1].set_ylabel("amplitude, Hann [m/s²]", y=height)
        set_title(figure, f"{title}, seen by {count} sensors" if count > 1 else title)
        legend_with_foot(figure, panels[0, 0], _explained(found))
    return figure


def _stretch(found: Comparison) -> tuple[float, float]:
    """The stretch of time (s) that is shown: all of a run or a sweep, some periods of tones."""
    first = max(float(s.seen.time[0]) for s in found.sensors)
    last = min(float(s.seen.time[-1]) for s in found.sensors)
    if not _is_short(found):
        return first, last
    length = min(last - first, _PERIODS / min(tone.frequency for tone in found.tones))
    middle = (first + last) / 2.0
    return middle - length / 2.0, middle + length / 2.0


def _is_short(found: Comparison) -> bool:
    """Whether some periods of steady tones are shown."""
    return bool(found.tones) and found.motions is None and found.response is None


def _name(found: Comparison, sensor: Filtered) -> str:
    place = found.sensors.index(sensor)
    role = " (reference)" if place == found.reference else ""
    width = sensor.seen.bandwidth
    limited = f", bandwidth {width:,.6g} Hz" if np.isfinite(width) else ""
    return f"{sensor.seen.name}{role}: {sensor.seen.log.rate:.4g} Hz{limited}"


def _chain(sensor: Filtered) -> str:
    lower, upper = band(sensor.filters)
    if np.isnan(lower):
        return "filters leave less than −3 dB"
    return f"filters −3 dB at {lower:.3g} and {upper:.3g} Hz"


def _over_time(axes: Axes, sensor: Filtered, first: float, last: float) -> None:
    time = sensor.seen.time
    inside = (time >= first) & (time <= last)
    for signal, colour, label in (
        (sensor.raw, RAW, "raw, mean removed"),
        (sensor.filtered, FILTERED, "filtered"),
    ):
        draw_curve(axes, time[inside], signal[inside], colour, label)


def _draw_truth(axes: Axes, sensor: Filtered, first: float, last: float) -> None:
    if sensor.ideal is None:
        return
    time = sensor.seen.time
    inside = (time >= first) & (time <= last)
    style = {"color": _IDEAL, "linewidth": 0.7, "linestyle": ":", "label": "true"}
    axes.plot(time[inside], sensor.ideal[inside], **style)  # type: ignore[arg-type]


def _over_frequency(axes: Axes, sensor: Filtered) -> None:
    spectrum = sensor.spectrum()
    shown = spectrum.frequency > 0.0
    for column, colour in enumerate((RAW, FILTERED)):
        levels = spectrum.levels[shown, column]
        axes.plot(spectrum.frequency[shown], levels, color=colour, linewidth=0.8)


def _share_spectra(panels: Any, found: Comparison) -> None:
    """One scale for all spectra, and the tones marked."""
    highest, levels = _highest(found), []
    for sensor in found.sensors:
        spectrum = sensor.spectrum()
        inside = (spectrum.frequency > 0.0) & (spectrum.frequency <= highest)
        levels.append(spectrum.levels[inside, 0])
    top = max(float(level.max()) for level in levels)
    floor = min(float(np.median(level)) for level in levels)
    lowest = max(0.1 * floor, top * 10.0**-_DECADES)
    for axes in panels:
        log_scale(axes, "y", [lowest, top])
        axes.set(ylim=(lowest, 3.0 * top), xlim=(0.0, highest))
        for tone in found.tones:
            axes.axvline(tone.frequency, color=ORDER, linewidth=0.6, linestyle="--", zorder=1.2)


def _highest(found: Comparison) -> float:
    half = max(s.seen.log.rate for s in found.sensors) / 2.0
    low_pass = _OF_LOW_PASS * found.sensors[0].filters.chain.low_pass
    tones = [_OF_TONE * tone.frequency for tone in found.tones]
    swept = [] if found.response is None else [1.1 * found.response["frequency [Hz]"].max()]
    wanted = max([low_pass, *tones, *swept])
    return min(half, wanted) if wanted > 0.0 else half


def _explained(found: Comparison) -> str:
    tones = ", ".join(map(tone_words, found.tones))
    marked = f"; dashed – {tones}" if tones else ""
    return f"filtered: {design(found.sensors[0].filters.chain)}{marked}"
