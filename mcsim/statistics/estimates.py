"""All statistics of all errors of one point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.statistics.choice import estimated
from mcsim.statistics.collector import Collector, Reference
from mcsim.statistics.evidence import Evidence
from mcsim.statistics.statistic import Interval, Statistic

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimates:
    """Values and interval ends, (e, statistics) each, in the errors' SI units.

    ``statistics`` are their names, in the order of every table.

    ``degenerate`` (e,) marks errors that do not scatter at all; ``few`` those whose scatter few
    realizations carry; ``unbounded`` names statistics whose interval more realizations would
    be needed to bound.
    """

    statistics: tuple[str, ...]
    value: Array
    low: Array
    high: Array
    degenerate: NDArray[np.bool_]
    few: NDArray[np.bool_] | None = None
    unbounded: tuple[str, ...] = ()

    def of(self, statistic: str) -> Interval:
        """One statistic of all errors."""
        column = self.statistics.index(statistic)
        return Interval(*(ends[:, column] for ends in (self.value, self.low, self.high)))


def estimate(
    collector: Collector,
    sigmas: float,
    resamples: int,
    key: int,
    statistics: Mapping[str, Statistic] | None = None,
) -> Estimates:
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
    statistics : mapping, optional
        Statistics by name, in the order of the estimates; their percentiles are the collector's.

    Notes
    -----
    Errors that are all equal have intervals of zero width.  From one realization
    no interval follows: its ends are NaN.  Undefined errors (NaN) stay undefined.
    """
    if statistics is None:
        statistics = estimated(collector.reference.percentiles)
    n_errors = len(collector.reference.centre)
    ends = np.full((3, n_errors, len(statistics)), np.nan)
    defined = np.isfinite(collector.sums[0]).all(axis=1)
    degenerate = defined & collector.degenerate
    few = np.zeros(n_errors, bool)
    rows = np.flatnonzero(defined & ~degenerate)
    if len(rows):
        evidence = Evidence(collector, rows, sigmas, resamples, key)
        for column, statistic in enumerate(statistics.values()):
            found = statistic.interval(evidence)
            ends[:, rows, column] = found.value, found.low, found.high
        few[rows] = evidence.moments.few
    for row in map(int, np.flatnonzero(degenerate)):
        same = float(collector.smallest[row])
        ends[:, row] = [statistic.without_scatter(same) for statistic in statistics.values()]
    if collector.count == 1:
        ends[1:] = np.nan
    unbounded = tuple(
        name
        for name, statistic in statistics.items()
        if len(rows) and not statistic.bounds(collector.count, sigmas)
    )
    value, low, high = ends
    return Estimates(tuple(statistics), value, low, high, degenerate, few, unbounded)


def estimate_errors(errors: Array, sigmas: float, resamples: int, key: int) -> Estimates:
    """Estimate from errors (e, r) that are at hand, without controls."""
    collector = Collector(errors.shape[1], Reference(np.zeros(len(errors))))
    step = max(4096, collector.cell)
    for first in range(0, errors.shape[1], step):
        piece = np.ascontiguousarray(errors[:, first : first + step])
        collector.add(first, piece, np.empty((len(errors), 0)))
    return estimate(collector, sigmas, resamples, key)
