"""Coloured noise of one channel as innovations: one normal per sample makes all of it.

The noise is a sum of first-order processes, ``x_s[k+1] = decay_s x_s[k] + w_s[k]``, and white
noise.  A Kalman filter that watches it turns it into its own one-step prediction plus
an independent normal, with the same distribution (Anderson & Moore, *Optimal Filtering*,
sect. 9.2; in matrix words the Cholesky factor of its covariance).  So a kernel needs one
normal per sample and channel however many processes there are, and no process needs a start.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel, scalar

Array = NDArray[np.float64]


@scalar
def _predict(decay, step_variance, covariance):
    """Covariance of the states one step on."""
    m = len(decay)
    for a in range(m):
        for b in range(m):
            covariance[a, b] *= decay[a] * decay[b]
        covariance[a, a] += step_variance[a]


@scalar
def _watch(white, covariance, gain):
    """Take in a measurement of the sum with white noise: variance of the innovation."""
    m = len(gain)
    total = white * white
    for a in range(m):
        gain[a] = 0.0
        for b in range(m):
            gain[a] += covariance[a, b]
        total += gain[a]
    if total <= 0.0:
        for a in range(m):
            gain[a] = 0.0
        return 0.0
    for a in range(m):
        gain[a] /= total
    for a in range(m):
        for b in range(m):
            covariance[a, b] -= gain[a] * gain[b] * total
    return total


@kernel
def innovations(
    decay: Array,
    step_variance: Array,
    white: float,
    covariance: Array,
    deviations: Array,
    gains: Array,
) -> None:
    """Deviation of every sample's innovation, and what it adds to the predicted processes.

    Parameters
    ----------
    decay, step_variance : float64 (m,)
        Of the processes, per sample.
    white : float
        Deviation of the white noise of a sample.
    covariance : float64 (m, m), overwritten
        Of the processes at the first sample; at the return, one step after the last.
    deviations : float64 (n,), written
        Standard deviations of the innovations.
    gains : float64 (n, m), written
        What a unit normal adds to each process' prediction for the next sample.
    """
    m = len(decay)
    gain = np.empty(m)
    for k in range(len(deviations)):
        deviations[k] = math.sqrt(_watch(white, covariance, gain))
        for a in range(m):
            gains[k, a] = decay[a] * gain[a] * deviations[k]
        _predict(decay, step_variance, covariance)


@kernel
def fold(
    weights: Array, deviations: Array, gains: Array, decay: Array, later: Array, folded: Array
) -> None:
    """Weights of a channel's samples as weights of their unit normals.

    A normal acts on its own sample and, through the processes, on all later ones.

    Parameters
    ----------
    weights : float64 (e, n)
        Of the samples, for each of e errors.
    deviations, gains, decay : float64 (n,), (n, m), (m,)
        As ``innovations`` writes them.
    later : float64 (e, m), written
        Weights of the processes' states at the first sample.
    folded : float64 (e, n), written
    """
    later[:] = 0.0
    for e in range(weights.shape[0]):
        for k in range(weights.shape[1] - 1, -1, -1):
            total = weights[e, k] * deviations[k]
            for s in range(len(decay)):
                # ``later`` sums decay^(distance) weight over the samples after this one.
                total += later[e, s] * gains[k, s]
                later[e, s] = weights[e, k] + decay[s] * later[e, s]
            folded[e, k] = total


@kernel
def watched(
    decay: Array, step_variance: Array, white: float, samples: int, covariance: Array
) -> None:
    """Covariance of the processes after a Kalman filter has watched their noisy sum.

    Parameters are those of ``innovations``; ``covariance`` is that one step after the last
    of ``samples`` samples.
    """
    gain = np.empty(len(decay))
    for _ in range(samples):
        _watch(white, covariance, gain)
        _predict(decay, step_variance, covariance)
