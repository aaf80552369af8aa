"""``mcsim table bias-tracking``: Table 5.8 of the vibration thesis, biases of five sensors."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mcsim import catalogue
from mcsim.papers import Computed, PaperTable, Setting
from mcsim.text_table import columns
from mcsim.units import KINDS, parse

if TYPE_CHECKING:
    import pandas as pd

    from mcsim.characterisation.process import GaussMarkov

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
_CONCLUSION = """\
RMSE in 1e-4 m/s². exact, simulated: error of the Kalman filter against the true bias of {hours:g} h
logs at {rate:g} Hz, with Tc and σ of Table 5.7 and noise densities of Table 5.2 (one sample's noise
is ND √Fs, as the thesis has it); at own rate: exact at the rate of Table 5.2; from average:
distance of the estimate from a moving average of the same log over {average:g} s. The thesis knows
no true bias; it compares with such an average, whose length it does not print, nor the rate. From
{rate:g} Hz to the own rates the exact value changes by up to {change:.1%}."""


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
    from mcsim.characterisation.bias import kalman_rmse, smooth, track_bias
    from mcsim.characterisation.process import GaussMarkov
    from mcsim.sensor_terms.gauss_markov import drift
    from mcsim.sensor_terms.mechanisms.process import process_noise, processes_of

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


def bias_tracking(seed: int) -> Computed:
    """The table, printed, in closed form, and simulated."""
    entries = list(tracked_biases(seed))
    change = max(abs(entry.exact_own / entry.exact - 1.0) for entry in entries)
    conclusion = _CONCLUSION.format(
        average=AVERAGE, rate=RATE, hours=DURATION / 3600.0, change=change
    )
    text = "\n".join([*columns(_rows(entries)), conclusion, useless_words(entries)])
    return Computed({"bias-tracking": _frame(entries)}, text)


def _rows(entries: Sequence[TrackedBias]) -> list[list[str]]:
    head = ["sensor", "Tc [s]", "σ", "printed", f"exact ({RATE:g} Hz)", "at own rate"]
    rows = [[*head, "simulated", "from average"]]
    for entry in entries:
        errors = (entry.model.deviation, entry.printed, entry.exact)
        time = f"{entry.model.correlation_time:g}"
        own = f"{1e4 * entry.exact_own:.3g} ({entry.own_rate:g} Hz)"
        found = (f"{1e4 * value:.3g}" for value in (entry.simulated, entry.from_average))
        rows.append([entry.sensor, time, *(f"{1e4 * e:.3g}" for e in errors), own, *found])
    return rows


def _frame(entries: Sequence[TrackedBias]) -> pd.DataFrame:
    """One row per sensor; root mean square errors in m/s²."""
    import pandas as pd

    return pd.DataFrame(
        {
            "sensor": [e.sensor for e in entries],
            "correlation time [s]": [e.model.correlation_time for e in entries],
            "deviation [m/s^2]": [e.model.deviation for e in entries],
            "printed [m/s^2]": [e.printed for e in entries],
            "exact [m/s^2]": [e.exact for e in entries],
            "own rate [Hz]": [e.own_rate for e in entries],
            "exact at own rate [m/s^2]": [e.exact_own for e in entries],
            "simulated [m/s^2]": [e.simulated for e in entries],
            "from average [m/s^2]": [e.from_average for e in entries],
        }
    )


def useless_words(entries: Sequence[TrackedBias]) -> str:
    """Whose printed error exceeds the deviation of the bias itself."""
    worse = [e.sensor for e in entries if e.printed > e.model.deviation]
    if not worse:
        return "No printed value exceeds the deviation of its sensor's bias."
    return (
        f"Printed values above the deviation of the bias itself: {', '.join(worse)}; an estimate "
        "of zero would do better."
    )


TABLE = PaperTable(
    "bias-tracking",
    "Tracking a sensor's bias (Table 5.8), printed, in closed form, and simulated.",
    bias_tracking,
    files=("bias-tracking",),
    settings=(Setting("seed", 1, least=0),),
)
