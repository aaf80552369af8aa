"""Flicker noise, as a sum of Gauss-Markov processes whose correlation times span the run."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.process import FirstOrder, Process, gauss_markov
from mcsim.sensor_terms.term import SensorKey, SensorTerm

Array = NDArray[np.float64]

#: Largest ratio of neighbouring correlation times of flicker noise; the spectrum of the sum
#: ripples by ±0.3 % about 1/f.
_RATIO = 4.0
#: Shortest correlation time in sample intervals, longest in lengths of the log.  The Allan
#: deviation is then within 1 % of 0.664 B from five samples to a tenth of the log.
_SHORTEST, _LONGEST = 0.3, 10.0


def flicker_processes(step: float, duration: float) -> tuple[Array, float]:
    """Gauss-Markov processes that make up flicker noise of B = 1 over ``duration``.

    A continuum of correlation times of variance ``d(ln T) / π`` has the density of flicker
    noise between its ends.  It is cut into equal pieces of ``ln T``, so that its variance, and
    with it every error, goes smoothly with the rate and the length of the run.

    Returns
    -------
    ndarray (m,), float
        Correlation times (s), and the variance of each process.
    """
    shortest, longest = _SHORTEST * step, _LONGEST * max(duration, step)
    width = math.log(longest / shortest)
    count = math.ceil(width / math.log(_RATIO))
    piece = width / count
    times: Array = shortest * np.exp((np.arange(count) + 0.5) * piece)
    return times, piece / math.pi


def flicker(bias_instability: float) -> Process:
    """Noise of two-sided density ``(B²/2π)/f``: see ``flicker_processes``."""

    def parts(interval: float, duration: float) -> Sequence[FirstOrder]:
        if bias_instability == 0.0:
            return ()
        times, variance = flicker_processes(interval, duration)
        own = bias_instability**2 * variance
        return [gauss_markov(own, float(time), interval) for time in times]

    return Process(parts)


_TEXT = (
    "Flicker noise, Allan's B; the floor of the Allan deviation is 0.664 B. Its correlation times "
    "reach to ten times the run (with `calibration` or `levelling`, run and rests together"
)

TERM = SensorTerm(
    "bias instability",
    flicker,
    (
        SensorKey(
            "bias_instability",
            "{signal}",
            f"{_TEXT}; in the velocity case, the rest and all runs).",
        ),
    ),
    (SensorKey("bias_instability", "{signal}", f"{_TEXT})."),),
)
