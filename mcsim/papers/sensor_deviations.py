"""``mcsim table sensors``: Tables 5.1 and 5.2 of the vibration thesis beside simulated logs.

Table 5.1 prints the standard deviation of each sensor at rest, Table 5.2 the noise density
that follows from it by Eq. (5.1), ``ND = σ / √f_3dB``.  A log is simulated with the sensor's
noise, rate and resolution; its deviation, its density by Eq. (5.1) and the one read off the
flat part of a Welch spectrum stand beside the printed values.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mcsim.api.bounded import between
from mcsim.papers import Computed, PaperTable, Setting
from mcsim.papers.sensor_logs import (
    MICRO_G,
    NOISE,
    SENSORS,
    Array,
    Noise,
    Printed,
    flat_density,
    printed,
    simulated_log,
)
from mcsim.text_table import columns
from mcsim.units import KINDS, density_from_random_walk, sample_deviation

if TYPE_CHECKING:
    import pandas as pd

#: Printed values that differ from each other by less may do so by rounding.
_AGREES = 0.05
#: Deviations that differ by less could have come from one sensor.
_NEAR = 1.25
_HEADS = {
    "std_printed [m/s^2]": "σ printed [m/s²]",
    "std_simulated [m/s^2]": "simulated",
    "density_printed [ug/sqrt(Hz)]": "density printed [µg/√Hz]",
    "density_by_bandwidth [ug/sqrt(Hz)]": "σ/√f_3dB",
    "density_by_spectrum [ug/sqrt(Hz)]": "Welch",
    "rate [Hz]": "rate [Hz]",
    "bandwidth [Hz]": "f_3dB [Hz]",
}


def sensor_table(
    noise: Noise = "allan",
    duration: float = 20.0,
    seed: int = 1,
    names: Sequence[str] = SENSORS,
) -> pd.DataFrame:
    """Printed and simulated values, one row per sensor and axis.

    Parameters
    ----------
    noise : {"allan", "density", "data_sheet"}
        Where the noise of the simulated logs comes from, see ``NOISE``.
    duration : float
        Length of each log (s); the source's text says 20 s and, once, 20 minutes.
    seed : int
        Seed of all logs.
    names : sequence of str
        Sensors of the tables.
    """
    import pandas as pd

    rows: list[dict[str, Any]] = []
    for name in names:
        source = printed(name)
        log = simulated_log(source, noise, duration, seed)
        deviation = log.std(axis=0)
        by_bandwidth = deviation / math.sqrt(source.bandwidth)
        by_spectrum = flat_density(log, source.rate)
        rows += [
            {
                "sensor": name,
                "axis": axis,
                "std_printed [m/s^2]": source.deviation[i],
                "std_simulated [m/s^2]": deviation[i],
                "density_printed [ug/sqrt(Hz)]": source.density[i] * MICRO_G,
                "density_by_bandwidth [ug/sqrt(Hz)]": by_bandwidth[i] * MICRO_G,
                "density_by_spectrum [ug/sqrt(Hz)]": by_spectrum[i] * MICRO_G,
                "rate [Hz]": source.rate,
                "bandwidth [Hz]": source.bandwidth,
            }
            for i, axis in enumerate(source.axes)
        ]
    return pd.DataFrame(rows)


def remarks(names: Sequence[str] = SENSORS) -> list[str]:
    """Where the printed numbers cannot all hold, sensor by sensor; computed, not remembered."""
    return [f"{name}: {remark}" for name in names for remark in _remarks(printed(name))]


def _remarks(source: Printed) -> Iterator[str]:
    if source.name == "MTN-1100":
        yield from _of_reference(source)
        return
    half = source.rate / 2.0
    if source.bandwidth > half:
        yield (
            f"samples at {source.rate:g} Hz hold noise up to {half:g} Hz only, not to the "
            f"{source.bandwidth:g} Hz of Eq. (5.1): of white noise it finds "
            f"{math.sqrt(half / source.bandwidth):.2f} of the density"
        )
    implied = (source.deviation / source.density) ** 2
    if abs(math.sqrt(float(implied.mean()) / source.bandwidth) - 1.0) > _AGREES:
        low, high = float(implied.min()), float(implied.max())
        yield (
            f"the printed deviations and densities need a bandwidth of {low:.0f} to {high:.0f} Hz "
            f"in Eq. (5.1); {source.bandwidth:g} Hz is printed"
        )
    density = density_from_random_walk(1.0) * source.random_walk
    ratios = sample_deviation(1.0, source.rate) * density / source.deviation
    if not ((ratios > 1.0 / _NEAR) & (ratios < _NEAR)).all():
        ends = (source.deviation / density) ** 2
        yield (
            f"white noise of the printed N would have {_list(ratios)} times the printed deviations "
            f"at this rate; they fit if noise ends at {_list(ends)} Hz ({', '.join(source.axes)})"
        )


def _list(numbers: Array) -> str:
    return ", ".join(f"{number:.3g}" for number in numbers)


def _of_reference(source: Printed) -> Iterator[str]:
    deviation, density = float(source.deviation[0]), float(source.density[0])
    yield (
        f"{deviation:g} m/s² and {density * MICRO_G:.5g} µg/√Hz need a bandwidth of "
        f"{(deviation / density) ** 2:.3g} Hz, which is not printed (Table 4.2 has 10 kHz); "
        f"simulated at {source.rate:g} Hz"
    )
    ratios = {"MTI-300": 116.0, "MPU-9250": 318.0, "LSM9DS1": 383.0, "BNO055": 140.0}
    means = [float(printed(name).deviation[2]) / ratio for name, ratio in ratios.items()]
    yield (
        f"the printed ratios to the other sensors need {np.mean(means):.2g} m/s², "
        f"{deviation / np.mean(means):.0f} times less than the printed {deviation:g} m/s²"
    )


def deviations(noise: Noise, duration: str, seed: int) -> Computed:
    """The two tables as one, printed beside simulated."""
    seconds = between("--duration", duration, KINDS["time"], ("1 s", "1 h"), "20 s")
    frame = sensor_table(noise, seconds, seed)
    lines = [
        f"logs of {seconds:g} s, noise: {NOISE[noise]}",
        *columns(_rows(frame)),
        "\nwhere the printed values cannot all hold:",
        *(f"  {remark}" for remark in remarks()),
    ]
    return Computed({"sensors": frame}, "\n".join(lines), nine_digits=("sensors",))


def _rows(frame: pd.DataFrame) -> list[list[str]]:
    rows = [["sensor", "axis", *_HEADS.values()]]
    for _, row in frame.iterrows():
        rows.append([row["sensor"], row["axis"], *(f"{row[key]:.4g}" for key in _HEADS)])
    return rows


TABLE = PaperTable(
    "sensors",
    "Deviations and noise densities of the vibration thesis (Tables 5.1 and 5.2).",
    deviations,
    files=("sensors",),
    settings=(
        Setting(
            "noise",
            "allan",
            "Noise of the logs: Allan's N, B, K; measured densities; data sheets.",
            choices=tuple(NOISE),
        ),
        Setting("duration", "20 s", metavar="'20 s'"),
        Setting("seed", 1, least=0),
    ),
)
