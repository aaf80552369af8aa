"""In-run noise as innovations of the samples, and what calibration leaves of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.process import Processes

Array = NDArray[np.float64]

#: Prior deviation of a bias that a Kalman filter is to find, in deviations of everything else.
_DIFFUSE = 1e4
#: Its name in budgets.
LEFT_OVER = "bias left by calibration"


@dataclass(frozen=True)
class Innovations:
    """Deviations (n,) of the samples' innovations and their gains (n, m); see the kernel."""

    deviations: Array
    gains: Array
    decay: Array


def innovations_of(processes: Processes, white: float, count: int) -> Innovations:
    """The channel's whole noise as innovations of ``count`` samples."""
    from mcsim.kernels.innovations import innovations

    deviations = np.empty(count)
    gains = np.empty((count, processes.count))
    innovations(
        processes.decay,
        processes.step_variance,
        white,
        processes.start.copy(),
        deviations,
        gains,
    )
    return Innovations(deviations, gains, processes.decay)


def with_mean(processes: Processes, white: float, samples: int) -> Array:
    """Covariance (m + 1, m + 1) of the processes one step after a rest, and of the mean over it.

    ``white`` is the deviation of one sample's white noise.  The sum of the samples is one more
    state; the transition of two steps follows from that of one, and so on.
    """
    m = processes.count
    step, noise = np.eye(m + 1), np.zeros((m + 1, m + 1))
    step[:m, :m] = np.diag(processes.decay)
    step[m, :m] = 1.0
    noise[:m, :m] = np.diag(processes.step_variance)
    noise[m, m] = white**2
    covariance = np.zeros((m + 1, m + 1))
    covariance[:m, :m] = processes.start
    left = samples
    while left:
        if left & 1:
            covariance = step @ covariance @ step.T + noise
        noise = step @ noise @ step.T + noise
        step = step @ step
        left >>= 1
    covariance[m] /= samples
    covariance[:, m] /= samples
    return covariance


def after_calibration(processes: Processes, white: float, samples: int, method: str) -> Processes:
    """What is left of a channel's bias after ``samples`` samples at rest.

    The sensor stands still and its constant bias, whatever it is, is estimated together
    with the in-run processes: by the ``mean`` of the samples, or by a ``kalman`` filter that
    knows the processes.  What the estimate misses goes on as one more process that stays
    constant, with its correlation to the others.
    """
    from mcsim.kernels.innovations import watched

    m = processes.count
    decay = np.append(processes.decay, 1.0)
    steps = np.append(processes.step_variance, 0.0)
    if method == "mean":
        start = with_mean(processes, white, samples)
        # The run's bias is the processes less the mean.
        start[m, :m] *= -1.0
        start[:m, m] *= -1.0
    else:
        start = np.zeros((m + 1, m + 1))
        start[:m, :m] = processes.start
        known = white**2 + float(np.trace(processes.start)) + float(np.sum(steps) * samples)
        start[m, m] = _DIFFUSE**2 * known
        watched(decay, steps, white, samples, start)
    return Processes(decay, steps, start, {LEFT_OVER: slice(None)})


def folded(weights: Array, innovations: Innovations) -> Array:
    """Weights (e, n) of a channel's samples as weights of their unit normals.

    A normal acts on its own sample and, through the processes, on all later ones.
    """
    return folded_with_start(weights, innovations)[0]


def folded_with_start(weights: Array, innovations: Innovations) -> tuple[Array, Array]:
    """The same, and the weights (e, m) of the processes' states at the first sample."""
    from mcsim.kernels.innovations import fold

    result = np.empty(weights.shape)
    of_start = np.empty((len(weights), len(innovations.decay)))
    fold(
        np.ascontiguousarray(weights),
        innovations.deviations,
        innovations.gains,
        innovations.decay,
        of_start,
        result,
    )
    return result, of_start
