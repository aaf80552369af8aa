"""The slowly varying bias: its Gauss-Markov parameters, and how well it can be tracked.

Table 5.8 of the thesis, with the parameters of Tables 5.2 and 5.7 (x axis, RMSE in
1e-4 m/s²): printed, the filter's own error in simulation (which is the closed form of
``kalman_rmse``), and its distance from a moving average over 30 s of the same log:

=========== ======= ====== ==============
sensor      printed error  from average
=========== ======= ====== ==============
MTI-300     7.1     3.8    4.3
MPU-9250    11      5.9    6.7
LSM9DS1     5.7     6.8    5.1
BNO055      20      5.0    3.9
LSM303DLHC  28      38     31
=========== ======= ====== ==============

The thesis knows no true bias: it compares with a moving average of the same log, whose
length it does not print.  That average shares the log's noise with the estimate, so a
distance from it may fall below the error of the best filter (LSM9DS1, LSM303DLHC), or
rise above it where the average is short (MTI-300: 6.2 with 1 s).  The BNO055's printed
value exceeds the deviation of its bias (13): an estimate of zero would do better, and
the thesis itself calls its noise not Gaussian.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.autocorrelation import autocovariance
from mcsim.characterisation.process import GaussMarkov
from mcsim.errors import InputError
from mcsim.kernels.gauss_markov import track

Array = NDArray[np.float64]

#: Length of the moving average that frees the bias from white noise (s).
SMOOTHING = 10.0
#: Smoothed values per smoothing length.
_VALUES_PER_LENGTH = 10
#: The smoothed bias must show this many lengths of the average.
_FEWEST_LENGTHS = 20.0


@dataclass(frozen=True)
class SmoothedBias:
    """Moving average of a log without its mean.

    ``values`` float64 (n,), ``interval`` between them and ``length`` of the average in
    s; the first average is centred at ``length / 2``.
    """

    values: Array
    interval: float
    length: float


@dataclass(frozen=True)
class BiasTracking:
    """A channel's bias and what is left of it after compensation, in SI units.

    ``expected``: root mean square errors of the fitted process in the fitted white
    noise, in closed form.  ``measured``: root mean square differences from the smoothed
    bias of this log, which is no truth: it holds white noise of its own, and lags less.
    """

    model: GaussMarkov
    smoothing: float
    mean_length: float
    kalman_expected: float
    mean_expected: float
    kalman_measured: float
    mean_measured: float


def smooth(samples: Array, rate: float, length: float = SMOOTHING) -> SmoothedBias:
    """Moving averages of ``samples`` (n,) over ``length`` s, ten to a length."""
    n = max(1, round(length * rate))
    step = max(1, n // _VALUES_PER_LENGTH)
    total = np.concatenate([[0.0], np.cumsum(samples - samples.mean())])
    starts = np.arange(0, len(samples) - n + 1, step)
    return SmoothedBias((total[starts + n] - total[starts]) / n, step / rate, n / rate)


def correlation_model(bias: SmoothedBias, white: float = 0.0) -> GaussMarkov:
    """Gauss-Markov parameters of a smoothed bias: σ² at lag 0, Tc where it has fallen to 1/e.

    ``white`` is Allan's N of the log: the part that the moving average leaves of it,
    a triangle of height N² / length, is taken off first.

    Raises
    ------
    InputError
        The bias is shorter than 20 averages, or none is left that stands out of the white
        noise and is slower than the average.
    """
    if len(bias.values) * bias.interval < _FEWEST_LENGTHS * bias.length:
        raise InputError(f"the log is shorter than {_FEWEST_LENGTHS:.0f} averages of the bias")
    correlation = autocovariance(bias.values)
    lags = np.arange(len(correlation)) * bias.interval
    correlation = correlation - white**2 / bias.length * np.maximum(0.0, 1.0 - lags / bias.length)
    peak = float(correlation[0])
    below = np.flatnonzero(correlation < peak / math.e)
    # The white noise's own variance scatters by √(2 length / duration).
    averages = len(bias.values) * bias.interval / bias.length
    if peak <= 4.0 * white**2 / bias.length * math.sqrt(2.0 / averages) or not len(below):
        raise InputError("no bias beside the white noise")
    k = int(below[0])
    fraction = (correlation[k - 1] - peak / math.e) / (correlation[k - 1] - correlation[k])
    time = float(lags[k - 1] + fraction * bias.interval)
    if time < bias.length:
        raise InputError(f"no bias that is slower than the moving average of {bias.length:.4g} s")
    return GaussMarkov(time, math.sqrt(peak))


def track_bias(samples: Array, rate: float, model: GaussMarkov, noise: float) -> Array:
    """Bias (n,) estimated by the Kalman filter of Eq. (3.34) and (3.35) after each sample.

    Parameters
    ----------
    samples : float64 (n,)
        Sensor output; the bias has the mean 0.
    rate : float
        Samples per second.
    model : GaussMarkov
        Correlation time (s) and deviation of the bias.
    noise : float
        Standard deviation of one sample's white noise, N √rate.
    """
    estimates = np.empty(len(samples))
    decay = math.exp(-1.0 / (rate * model.correlation_time))
    track(np.ascontiguousarray(samples, float), decay, model.deviation, noise, estimates)
    return estimates


def kalman_rmse(model: GaussMarkov, noise: float, rate: float) -> float:
    """Root mean square error of ``track_bias`` in its steady state: the Riccati equation.

    With a = e^(-dt/Tc), the variance p before an update solves
    p² + p (r - r a² - q) - q r = 0, q = σ² (1 - a²), r = noise².
    """
    a2 = math.exp(-2.0 / (rate * model.correlation_time))
    q = -(model.deviation**2) * math.expm1(-2.0 / (rate * model.correlation_time))
    r = noise**2
    half = 0.5 * (r * (1.0 - a2) - q)
    p = -half + math.sqrt(half * half + q * r)
    return math.sqrt(p * r / (p + r)) if r else 0.0


def mean_rmse(model: GaussMarkov, white: float, length: float) -> float:
    """Error of the mean of the last ``length`` s as an estimate of the present bias.

    White noise leaves N² / length.  With u = length / Tc the mean of the process has the
    variance 2 σ² (u - 1 + e^-u) / u², and the covariance σ² (1 - e^-u) / u with its end.
    """
    u = length / model.correlation_time
    fallen = -math.expm1(-u)
    mean = 2.0 * (u - fallen) / u**2 if u > 1e-4 else 1.0 - u / 3.0
    rest = 1.0 + mean - 2.0 * fallen / u
    return math.sqrt(white**2 / length + model.deviation**2 * max(rest, 0.0))


def best_mean_length(model: GaussMarkov, white: float, longest: float) -> float:
    """The calibration time (s) after which the mean is closest to the present bias."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda g: mean_rmse(model, white, math.exp(g)),
        bounds=(math.log(1e-3 * longest), math.log(longest)),
        method="bounded",
    )
    return float(math.exp(found.x))


def analyse_bias(
    samples: Array, rate: float, white: float, model: GaussMarkov | None = None
) -> BiasTracking:
    """A log's bias as a Gauss-Markov process, and the errors of two ways to track it.

    ``samples`` (n,) at ``rate`` Hz, ``white`` Allan's N, ``model`` the process if it is known;
    else it is taken from the autocorrelation (``correlation_model``).

    Raises
    ------
    InputError
        See ``correlation_model``.
    """
    duration = len(samples) / rate
    bias = smooth(samples, rate, min(SMOOTHING, duration / 100.0))
    if model is None:
        model = correlation_model(bias, white)
    noise = white * math.sqrt(rate)
    centred = samples - samples.mean()
    length = best_mean_length(model, white, min(duration / 2.0, 100.0 * model.correlation_time))
    n = max(1, round(length * rate))
    total = np.concatenate([[0.0], np.cumsum(centred)])
    # Where the smoothed values are centred, and the mean has a whole length behind it.
    places = np.arange(len(bias.values)) * round(bias.interval * rate)
    places += round(0.5 * bias.length * rate)
    known = places >= n
    places, truth = places[known], bias.values[known]
    filtered = track_bias(centred, rate, model, noise)[places - 1]
    means = (total[places] - total[places - n]) / n
    return BiasTracking(
        model=model,
        smoothing=bias.length,
        mean_length=n / rate,
        kalman_expected=kalman_rmse(model, noise, rate),
        mean_expected=mean_rmse(model, white, n / rate),
        kalman_measured=_rms(filtered - truth),
        mean_measured=_rms(means - truth),
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
