"""The bias of a log over time: measured, and tracked by a Kalman filter with its band."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.bias import kalman_rmse, smooth, track_bias
from mcsim.characterisation.process import GaussMarkov

Array = NDArray[np.float64]

#: 95 % of a normal distribution lie within so many deviations.
_NORMAL = 1.959963984540054
#: Instants that are kept.
_MOST = 1000


@dataclass(frozen=True)
class BiasCourse:
    """Bias less the log's mean at ``time`` (k,) in s, in SI units.

    ``measured`` (k,) is the moving average over ``smoothing`` s, ± ``measured_band`` for the white
    noise in it; ``tracked`` (k,) the filter's estimate, ± ``tracked_band`` (k,): 95 % for a bias
    of the ``model``.  All three are None where no bias stands out of the white noise.
    """

    time: Array
    measured: Array
    measured_band: float
    smoothing: float
    tracked: Array | None
    tracked_band: Array | None
    model: GaussMarkov | None


def kalman_deviation(model: GaussMarkov, noise: float, rate: float, samples: Array) -> Array:
    """Deviation (k,) of ``track_bias``'s error after ``samples`` (k,), 1 the first of them.

    The Riccati recursion p' = a² p r / (p + r) + q is a Möbius map: with its fixed points u > 0
    > v, (p - u) / (p - v) shrinks by (a r / (u + r))² at each step.
    """
    a2 = math.exp(-2.0 / (rate * model.correlation_time))
    start = model.deviation**2
    q = -start * math.expm1(-2.0 / (rate * model.correlation_time))
    r = noise**2
    after = kalman_rmse(model, noise, rate) ** 2
    above = a2 * after + q
    below = -q * r / above
    ratio = (start - above) / (start - below) * (a2 * (r / (above + r)) ** 2) ** (samples - 1.0)
    before = (above - below * ratio) / (1.0 - ratio)
    return np.asarray(np.sqrt(before * r / (before + r)))


def bias_course(
    samples: Array, rate: float, white: float, length: float, model: GaussMarkov | None
) -> BiasCourse:
    """The course of a log's bias.

    Parameters
    ----------
    samples : float64 (n,)
        At ``rate`` Hz.
    white : float
        Allan's N.
    length : float
        Of the moving average (s).
    model : GaussMarkov or None
        The bias; None if there is none to track.
    """
    average = smooth(samples, rate, length)
    thin = -(-len(average.values) // _MOST)
    measured = average.values[::thin]
    places = np.arange(len(measured)) * thin * round(average.interval * rate)
    places += round(0.5 * average.length * rate)
    tracked = band = None
    if model is not None:
        noise = white * math.sqrt(rate)
        ends = np.maximum(places, 1)
        tracked = track_bias(samples - samples.mean(), rate, model, noise)[ends - 1]
        band = _NORMAL * kalman_deviation(model, noise, rate, ends.astype(float))
    return BiasCourse(
        time=places / rate,
        measured=measured,
        measured_band=_NORMAL * white / math.sqrt(average.length),
        smoothing=average.length,
        tracked=tracked,
        tracked_band=band,
        model=model,
    )
