"""All statistics of all errors of one point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.statistics.collector import Collector, Reference
from mcsim.statistics.moments import moments, student_sigmas
from mcsim.statistics.quantiles import bounded, quantiles

Array = NDArray[np.float64]

#: Statistics estimated from realizations, in the order of every table; percentiles follow.
MOMENTS = ("mean", "std", "rms")


def statistic_names(percentiles: tuple[float, ...]) -> tuple[str, ...]:
    """Names of the estimated statistics, in the order of every table: ``mean`` … ``p95``."""
    return (*MOMENTS, *(f"p{100.0 * p:g}" for p in percentiles))


@dataclass(frozen=True)
class Estimates:
    """Values and interval ends, (e, statistics) each, in the errors' SI units.

    The statistics are those of ``statistic_names``.

    ``degenerate`` (e,) marks errors that do not scatter at all; ``few`` those whose scatter few
    realizations carry; ``unbounded`` names percentiles whose interval more realizations would
    be needed to bound.
    """

    value: Array
    low: Array
    high: Array
    degenerate: NDArray[np.bool_]
    few: NDArray[np.bool_] | None = None
    unbounded: tuple[str, ...] = ()


def estimate(collector: Collector, sigmas: float, resamples: int, key: int) -> Estimates:
    """Estimate all statistics of all errors.

    Parameters
    ----------
    collector : Collector
        With all its realizations added.
    sigmas : float
        Confidence of the two-sided intervals as a number of standard deviations.
    resamples : int
        Number of bootstrap resamples.
    key : int
        64-bit key of the resampling's random numbers.

    Notes
    -----
    Errors that are all equal have intervals of zero width.  From one realization
    no interval follows: its ends are NaN.  Undefined errors (NaN) stay undefined.
    """
    n_errors = len(collector.reference.centre)
    percentiles = collector.reference.percentiles
    value = np.full((n_errors, len(MOMENTS) + len(percentiles)), np.nan)
    low, high = value.copy(), value.copy()
    defined = np.isfinite(collector.sums[0]).all(axis=1)
    degenerate = defined & collector.degenerate
    few = np.zeros(n_errors, bool)
    rows = np.flatnonzero(defined & ~degenerate)
    if len(rows):
        reach = student_sigmas(sigmas, len(collector.sizes)) if collector.nets else sigmas
        found = moments(collector, rows, reach, resamples, key)
        value[rows, :3], low[rows, :3], high[rows, :3] = found.value, found.low, found.high
        few[rows] = found.few
        for row in map(int, rows):
            value[row, 3:], low[row, 3:], high[row, 3:] = quantiles(collector, row, sigmas)
    for row in map(int, np.flatnonzero(degenerate)):
        same = float(collector.smallest[row])
        value[row] = low[row] = high[row] = [same, 0.0, abs(same), *(same for _ in percentiles)]
    if collector.count == 1:
        low[:], high[:] = np.nan, np.nan
    unbounded = tuple(
        name
        for name, p in zip(statistic_names(percentiles)[len(MOMENTS) :], percentiles, strict=True)
        if len(rows) and not bounded(collector.count, p, sigmas)
    )
    return Estimates(value, low, high, degenerate, few, unbounded)


def estimate_errors(errors: Array, sigmas: float, resamples: int, key: int) -> Estimates:
    """Estimate from errors (e, r) that are at hand, without controls."""
    collector = Collector(errors.shape[1], Reference(np.zeros(len(errors))))
    step = max(4096, collector.cell)
    for first in range(0, errors.shape[1], step):
        piece = np.ascontiguousarray(errors[:, first : first + step])
        collector.add(first, piece, np.empty((len(errors), 0)))
    return estimate(collector, sigmas, resamples, key)
