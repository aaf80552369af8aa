"""Logs at rest of the vibration thesis' accelerometers, simulated from what it prints of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from mcsim import catalogue
from mcsim.units import KINDS, STANDARD_GRAVITY, density_from_random_walk, parse, sample_deviation

if TYPE_CHECKING:
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
MICRO_G = 1e6 / STANDARD_GRAVITY
#: The source gives no rate of MTN-1100; twice the 100 Hz that its density is taken over.
_RATE_OF_REFERENCE, _BAND_OF_REFERENCE = 200.0, 100.0
#: The flat part of the spectrum, in shares of the rate.
_FLAT = (0.05, 0.45)
_DEVIATION = "acceleration"


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
