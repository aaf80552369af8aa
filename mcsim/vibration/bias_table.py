"""Table 5.8 of the thesis: tracking the bias of five sensors, printed and simulated."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mcsim import catalogue
from mcsim.characterisation.bias import kalman_rmse, smooth, track_bias
from mcsim.characterisation.process import GaussMarkov
from mcsim.sensor_terms.gauss_markov import drift
from mcsim.sensor_terms.mechanisms.process import process_noise, processes_of
from mcsim.units import KINDS, parse

#: RMSE that Table 5.8 prints for the x axis (m/s²).
PRINTED = {
    "MTI-300": 7.1e-4,
    "MPU-9250": 11e-4,
    "LSM9DS1": 5.7e-4,
    "BNO055": 20e-4,
    "LSM303DLHC": 28e-4,
}
#: Length of the logs (s), and their rate (Hz), of which the thesis says nothing here; a sensor's
#: own is up to 50 times as high, and the closed form is given for it too.
DURATION, RATE = 14 * 3600.0, 20.0
#: Length of the moving average that the estimate is compared with (s); the thesis prints none.
AVERAGE = 30.0


@dataclass(frozen=True)
class TrackedBias:
    """One sensor's x axis; root mean square errors in m/s².

    ``exact`` is that of the filter in closed form at ``RATE``, ``exact_own`` at the sensor's own
    ``own_rate`` (Hz), ``simulated`` that found on a simulated log, ``from_average`` the
    distance of the estimate from a moving average of the same log.
    """

    sensor: str
    model: GaussMarkov
    density: float
    printed: float
    exact: float
    own_rate: float
    exact_own: float
    simulated: float
    from_average: float


def tracked_biases(seed: int = 1) -> Iterator[TrackedBias]:
    """Simulate a 14 h log of each sensor of Table 5.8 and track its bias.

    Correlation times and deviations are those of Table 5.7, noise densities those of Table 5.2;
    the measurement noise is ND √Fs, as the thesis has it.
    """
    for sensor, printed in PRINTED.items():
        quantities = _measured(sensor)
        model = GaussMarkov(
            parse(quantities["gauss_markov_correlation_time"][0], KINDS["time"]),
            parse(quantities["gauss_markov_deviation"][0], KINDS["acceleration"]),
        )
        density = parse(quantities["noise_density"][0], KINDS["acceleration noise density"])
        noise = density * math.sqrt(RATE)
        rate = parse(quantities["rate"][0], KINDS["frequency"])
        rng = np.random.default_rng(seed)
        drifts = {"bias": drift(model.deviation, model.correlation_time)}
        bias = process_noise(processes_of(drifts, 1.0 / RATE, DURATION), rng)(
            round(DURATION * RATE)
        )
        log = bias + noise * rng.standard_normal(len(bias))
        estimate = track_bias(log, RATE, model, noise)
        average = smooth(log, RATE, AVERAGE)
        at = np.arange(len(average.values)) * average.interval + average.length / 2.0
        ends = np.round(at * RATE).astype(int) - 1
        yield TrackedBias(
            sensor=sensor,
            model=model,
            density=density,
            printed=printed,
            exact=kalman_rmse(model, noise, RATE),
            own_rate=rate,
            exact_own=kalman_rmse(model, density * math.sqrt(rate), rate),
            simulated=_rms(estimate - bias),
            from_average=_rms(estimate[ends] - average.values),
        )


def _measured(sensor: str) -> dict[str, list[str]]:
    """What the measured records of the sensor's accelerometer say, all together."""
    found: dict[str, list[str]] = {}
    for record in catalogue.find(sensor).records["accelerometer"]:
        if record.origin == "measured":
            found |= {
                key: value if isinstance(value, list) else [value]
                for key, value in record.quantities.items()
            }
    return found


def _rms(values: np.ndarray) -> float:
    return math.sqrt(float(np.mean(values**2)))
