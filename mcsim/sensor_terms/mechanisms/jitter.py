"""Sampling instants that err: to first order, the signal's slope times the error.

All channels of a sensor are sampled together, so it stands in the block ``sensors`` and not in
that of an element, whose errors a simulated log has.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Its name in budgets.
JITTER = "sample-time jitter"


def slopes(signals: Array, deviation: float, interval: float) -> Array:
    """What one deviation of the instants (s) adds to the samples (n, c)."""
    return np.asarray(np.gradient(signals, axis=0) * (deviation / interval))


def variance(weights: Array, jitter: Array) -> Array:
    """Variance (e,) of errors with ``weights`` (e, n, c); the channels of a sample err together."""
    common = np.einsum("enc,nc->en", weights, jitter)
    return np.asarray(np.sum(common**2, axis=1))
