"""``mcsim table sensors``: Tables 5.1 and 5.2 of the vibration thesis beside simulated logs.

Table 5.1 prints the standard deviation of each sensor at rest, Table 5.2 the noise density
that follows from it by Eq. (5.1), ``ND = σ / √f_3dB``.  A log is simulated with the sensor's
noise, rate and resolution; its deviation, its density by Eq. (5.1) and the one read off the
flat part of a Welch spectrum stand beside the printed values.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from mcsim import catalogue
from mcsim.errors import InputError
from mcsim.papers import Computed, PaperTable, Setting
from mcsim.text_table import columns
from mcsim.units import (
    KINDS,
    STANDARD_GRAVITY,
    density_from_random_walk,
    parse,
    sample_deviation,
)

if TYPE_CHECKING:
    import pandas as pd

    from mcsim.sensor_terms.mechanisms.process import Processes
    from mcsim.sensors.error_model import ChannelErrors

Array = NDArray[np.float64]
Noise = Literal["allan", "density", "data_sheet"]

#: Sensors of the two tables, in their order.
SENSORS = ("MTN-1100", "MTI-300", "MPU-9250", "LSM9DS1", "BNO055", "LSM303DLHC")
AXES = ("x", "y", "z")
#: Where the noise of the simulated logs comes from.
NOISE = {
    "allan": "N, B and K of Tables 5.4 to 5.6",
    "density": "the measured densities of Table 5.2, with B and K of Tables 5.5 and 5.6",
    "data_sheet": "the data sheets' densities, with B and K of Tables 5.5 and 5.6",
}
#: The source gives no rate of MTN-1100; twice the 100 Hz that its density is taken over.
_RATE_OF_REFERENCE, _BAND_OF_REFERENCE = 200.0, 100.0
#: The flat part of the spectrum, in shares of the rate.
_FLAT = (0.05, 0.45)
#: Printed values that differ from each other by less may do so by rounding.
_AGREES = 0.05
#: Deviations that differ by less could have come from one sensor.
_NEAR = 1.25
_DEVIATION = "acceleration"
_MICRO_G = 1e6 / STANDARD_GRAVITY
_HEADS = {
    "std_printed [m/s^2]": "σ printed [m/s²]",
    "std_simulated [m/s^2]": "simulated",
    "density_printed [ug/sqrt(Hz)]": "density printed [µg/√Hz]",
    "density_by_bandwidth [ug/sqrt(Hz)]": "σ/√f_3dB",
    "density_by_spectrum [ug/sqrt(Hz)]": "Welch",
    "rate [Hz]": "rate [Hz]",
    "bandwidth [Hz]": "f_3dB [Hz]",
}


@dataclass(frozen=True)
class Printed:
    """What the source prints of one sensor, SI; arrays (axes,), nan where it prints nothing.

    ``rate`` is the measured one, ``bandwidth`` that of Table 5.2.
    """

    name: str
    axes: tuple[str, ...]
    deviation: Array
    density: Array
    random_walk: Array
    rate: float
    bandwidth: float


def printed(name: str) -> Printed:
    """The printed values of a sensor of the tables, from the catalogue."""
    records = catalogue.find(name).records["accelerometer"]
    values = {
        (record.source, record.origin, key): value
        for record in records
        for key, value in record.quantities.items()
    }

    def of(source: str, key: str, kind: str, origin: str = "measured") -> Array:
        for wanted in (key, f"{key}_z"):
            given = values.get((source, origin, wanted))
            if given is not None:
                texts = given if isinstance(given, list) else [given]
                return np.array([parse(text, KINDS[kind]) for text in texts])
        return np.array([math.nan])

    deviation = of("thesis-table-5.1", "standard_deviation", _DEVIATION)
    rate = of("thesis-table-5.2", "rate", "frequency")[0]
    bandwidth = of("thesis-table-5.2", "bandwidth", "frequency", "data sheet")[0]
    return Printed(
        name=name,
        axes=AXES if len(deviation) == 3 else ("z",),
        deviation=deviation,
        density=of("thesis-table-5.2", "noise_density", "acceleration noise density"),
        random_walk=of("thesis-tables-5.4-5.6", "velocity_random_walk", "velocity random walk"),
        rate=rate if math.isfinite(rate) else _RATE_OF_REFERENCE,
        bandwidth=bandwidth if math.isfinite(bandwidth) else _BAND_OF_REFERENCE,
    )


def simulated_log(source: Printed, noise: Noise, duration: float, seed: int) -> Array:
    """A log at rest (n, axes) with the noise of one sensor, mean removed."""
    from mcsim.sensors.simulated_log import SimulatedLog

    errors = _errors(source, noise, duration)
    log = SimulatedLog(errors, seed).measure(
        np.zeros((round(duration * source.rate), len(source.axes)))
    )
    centred: Array = log - log.mean(axis=0)
    return centred


def _errors(source: Printed, noise: Noise, duration: float) -> ChannelErrors:
    """What the catalogue says of a sensor, with the noise that is asked for."""
    from mcsim.scenario.document import Document
    from mcsim.scenario.sensor_file import SensorFile
    from mcsim.scenario.validation import validate
    from mcsim.sensor_terms.channel import ACCELEROMETER, Channel
    from mcsim.sensors.error_model import element_errors

    tree = {ACCELEROMETER: source.name}
    block = validate(Document(tree, source.name), SensorFile).accelerometer
    assert block is not None
    axes = len(source.axes)
    channels = [Channel(ACCELEROMETER, axis) for axis in range(axes)]
    errors = element_errors({ACCELEROMETER: block}, source.rate, channels, duration)
    if noise == "density":
        errors = _with_density(errors, source.density, source.rate)
    elif noise == "allan" and np.isfinite(source.random_walk).all():
        density = density_from_random_walk(1.0) * source.random_walk
        errors = _with_density(errors, density, source.rate)
    return replace(
        errors,
        processes=_in_run_noise(source, duration),
        # At rest the low-pass has nothing to pass on.
        filters=((),) * axes,
    )


def _with_density(errors: ChannelErrors, density: Array, rate: float) -> ChannelErrors:
    return replace(errors, white=sample_deviation(1.0, rate) * density)


def _in_run_noise(source: Printed, duration: float) -> tuple[Processes, ...]:
    """Flicker noise and random walk of each axis, as the thesis measured them."""
    from mcsim.sensor_terms import bias_instability, random_walk
    from mcsim.sensor_terms.mechanisms.process import processes_of

    axes = len(source.axes)
    in_run, none = _in_run(source.name, axes), np.zeros(axes)
    flicker = in_run.get("bias_instability", none)
    walk = in_run.get("acceleration_random_walk", none)
    return tuple(
        processes_of(
            {
                bias_instability.TERM.name: bias_instability.flicker(float(b)),
                random_walk.TERM.name: random_walk.walk(float(k)),
            },
            1.0 / source.rate,
            duration,
        )
        for b, k in zip(flicker, walk, strict=True)
    )


def _in_run(name: str, axes: int) -> dict[str, Array]:
    kinds = {
        "bias_instability": "acceleration",
        "acceleration_random_walk": "acceleration random walk",
    }
    for record in catalogue.find(name).records["accelerometer"]:
        if record.source == "thesis-tables-5.4-5.6":
            return {
                key: np.array([parse(text, KINDS[kind]) for text in record.quantities[key]])[:axes]
                for key, kind in kinds.items()
            }
    return {}


def flat_density(log: Array, rate: float) -> Array:
    """One-sided density (axes,) from the flat part of a Welch spectrum."""
    from mcsim.vibration.spectra import welch_spectrum

    spectrum = welch_spectrum(log, rate)
    flat = (spectrum.frequency > _FLAT[0] * rate) & (spectrum.frequency < _FLAT[1] * rate)
    density: Array = np.sqrt(spectrum.levels[flat].mean(axis=0))
    return density


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
                "density_printed [ug/sqrt(Hz)]": source.density[i] * _MICRO_G,
                "density_by_bandwidth [ug/sqrt(Hz)]": by_bandwidth[i] * _MICRO_G,
                "density_by_spectrum [ug/sqrt(Hz)]": by_spectrum[i] * _MICRO_G,
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
        f"{deviation:g} m/s² and {density * _MICRO_G:.5g} µg/√Hz need a bandwidth of "
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
    seconds = parse(duration, KINDS["time"])
    if not 1.0 <= seconds <= 3600.0:
        raise InputError(f'--duration "{duration}" must lie between 1 s and 1 h')
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
