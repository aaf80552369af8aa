"""The root mean square of an error."""

from __future__ import annotations

import numpy as np

from mcsim.statistics.statistic import Array, Distribution, Statistic


def _value(errors: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(errors**2, axis=-1)), float)


def _linear(distribution: Distribution) -> Array:
    return np.hypot(distribution.mean, distribution.std)


RMS = Statistic(
    "rms",
    "RMS",
    _value,
    never_negative=True,
    estimate=lambda evidence: evidence.moments.rms,
    linear=_linear,
)
