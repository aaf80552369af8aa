"""The picture of a sweep: gain and phase of all sensors over frequency."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcsim.figures.style import (
    MARKERS,
    curve_colour,
    house_style,
    log_scale,
    set_title,
)
from mcsim.figures.vibration import legend_with_foot
from mcsim.vibration.comparison import Comparison

_FOOT = (
    "bars: 95 %, from what each fit leaves; "
    "bands that reach above half a sensor's rate are left out"
)


def draw_response(found: Comparison, title: str) -> Figure:
    """Amplitude over that of the truth with 95 % bars, above phase, over frequency."""
    table = found.response
    assert table is not None
    with house_style():
        figure = Figure(figsize=(7.6, 6.4), layout="constrained")
        gain, phase = figure.subplots(2, 1, sharex=True, height_ratios=[1.5, 1.0])
        names = list(dict.fromkeys(table["sensor"]))
        for i, name in enumerate(names):
            rows = table[table["sensor"] == name]
            colour = curve_colour(i, len(names))
            style = {"color": colour, "marker": MARKERS[i % len(MARKERS)], "markersize": 3.0}
            frequency = rows["frequency [Hz]"].to_numpy()
            gain.errorbar(
                frequency,
                rows["gain"].to_numpy(),
                1.96 * rows["u_gain"].to_numpy(),
                linewidth=1.0,
                label=name,
                **style,
            )
            phase.plot(frequency, rows["phase [deg]"].to_numpy(), linewidth=1.0, **style)
        gain.axhline(np.sqrt(0.5), color="#6b7280", linewidth=0.8, linestyle="--")
        gain.annotate(
            "−3 dB",
            (0.0, np.sqrt(0.5)),
            xycoords=("axes fraction", "data"),
            xytext=(3, 3),
            textcoords="offset points",
            fontsize=7.5,
            color="#6b7280",
        )
        log_scale(phase, "x", table["frequency [Hz]"].tolist())
        gain.set(ylabel="amplitude over the true one", ylim=(_lowest(table["gain"].min()), None))
        phase.set(xlabel="frequency [Hz]", ylabel="phase [°]")
        set_title(figure, f"{title}: frequency response of each sensor, unfiltered")
        legend_with_foot(figure, gain, _FOOT)
    return figure


def _lowest(gain: float) -> float:
    """Where the axis of gains begins: it holds −3 dB, and zero where much is lost."""
    return 0.6 if gain > 0.62 else 0.0
