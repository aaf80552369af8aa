"""A sensor at rest before the run: the mean of its noise, and what goes on from there.

A mean over a rest holds everything that stands in the output meanwhile: in-run noise as well as
white noise, spikes and rounding.  The run that follows shares the in-run noise with it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.process import Processes
from mcsim.sensors.coloured import (
    Innovations,
    folded_with_start,
    innovations_of,
    with_mean,
)

Array = NDArray[np.float64]

#: Share of a variance that is rounding, where all of it is known.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class MeanAtRest:
    """The mean of a channel's noise over a rest: its deviation, and how much more is known.

    ``gains`` (m,) is what a unit normal of the mean adds to the processes at the first sample
    after the rest; ``spread`` is the deviation of single samples about the mean, before rounding.
    """

    deviation: float
    gains: Array
    spread: float


def spread_at_rest(processes: Processes, white: float, samples: int) -> float:
    """Root of the mean square of a channel's samples about their mean over a rest."""
    ratio = np.outer(processes.decay, processes.decay)
    with np.errstate(divide="ignore", invalid="ignore"):
        log = np.log(ratio)
        sums = np.where(ratio < 1.0, np.expm1(samples * log) / np.expm1(log), samples)
    sums = np.where(ratio > 0.0, sums, 1.0)
    own, driven = np.diag(ratio), np.diag(sums)
    with np.errstate(divide="ignore", invalid="ignore"):
        twice = np.where(own < 1.0, (samples - driven) / (1.0 - own), samples * (samples - 1) / 2)
    total = np.sum(processes.start * sums) + np.sum(processes.step_variance * twice)
    mean = with_mean(processes, white, samples)[-1, -1]
    return math.sqrt(max(0.0, float(total / samples + white**2 - mean)))


def after_rest(
    processes: Processes, white: float, samples: int, watched: bool, spread: float = 0.0
) -> tuple[Processes, MeanAtRest]:
    """The processes after a rest, and the mean over it; unchanged without a rest.

    The mean is one normal of a realization; given it, the processes are expected somewhere,
    and scatter about that by what is left unknown.  Where nobody has ``watched``, they scatter
    by all that they are.
    """
    m = processes.count
    if samples == 0:
        return processes, MeanAtRest(0.0, np.zeros(m), 0.0)
    if m == 0:
        deviation = white / math.sqrt(samples) if watched else 0.0
        return processes, MeanAtRest(deviation, np.zeros(0), spread)
    covariance = with_mean(processes, white, samples)
    if not watched:
        start = covariance[:m, :m].copy()
        return replace(processes, start=start), MeanAtRest(0.0, np.zeros(m), spread)
    deviation = math.sqrt(covariance[m, m])
    gains = covariance[:m, m] / deviation if deviation > 0.0 else np.zeros(m)
    start = covariance[:m, :m] - np.outer(gains, gains)
    known = np.diag(start) <= _ROUNDING * np.diag(covariance)[:m]
    start[known, :] = 0.0
    start[:, known] = 0.0
    return replace(processes, start=start), MeanAtRest(deviation, gains, spread)


def rest_and_run(
    weights: Array, at_rest: Array, innovations: Innovations, mean: MeanAtRest
) -> tuple[Array, Array]:
    """Weights (e, n) and (e,) of the samples' unit normals, and of the mean's.

    ``weights`` (e, n) are those of the samples' errors, ``at_rest`` (e,) that of the mean.
    """
    normals, of_start = folded_with_start(weights, innovations)
    return normals, at_rest * mean.deviation + of_start @ mean.gains


def term_variances(
    weights: Array, at_rest: Array, processes: Processes, samples: int, watched: bool
) -> dict[str, Array]:
    """Variance (e,) that each term alone makes of errors with these weights (e, n).

    ``at_rest`` (e,) are the weights of the mean over ``samples`` before the run, if it is
    ``watched``.
    """
    variances = {}
    for term in processes.terms:
        alone, mean = after_rest(processes.only(term), 0.0, samples, watched)
        innovations = innovations_of(alone, 0.0, weights.shape[1])
        normals, of_mean = rest_and_run(weights, at_rest, innovations, mean)
        variances[term] = np.sum(normals**2, axis=1) + of_mean**2
    return variances
