"""Percentiles with distribution-free intervals.

They need no resampling: the order statistics that bound them with the asked confidence are
known (Hahn & Meeker, *Statistical Intervals*, sect. 5.2).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mcsim.statistics.collector import Collector

Array = NDArray[np.float64]


def quantiles(collector: Collector, error: int, sigmas: float) -> tuple[Array, Array, Array]:
    """Percentiles of one error with distribution-free intervals.

    The number of errors below the true p-quantile is binomial(n, p), whatever the
    distribution: so the order statistics at its quantiles bound the p-quantile.  In a Sobol net
    realizations depend on each other: where the nets' numbers scatter more, so much further apart
    are the bounds; where they scatter less, this is not made use of.
    """
    n = collector.count
    values, lows, highs = [], [], []
    for i, p in enumerate(collector.reference.percentiles):
        position = p * (n - 1)
        rank = int(position)
        a, b = collector.order_statistics(error, i, [rank + 1, min(rank + 2, n)])
        value = a + (b - a) * (position - rank)
        reach = sigmas * collector.scatter_below(error, value)
        low, high = collector.order_statistics(error, i, list(_bounding_ranks(n, p, reach)))
        values.append(value)
        lows.append(min(low, value))
        highs.append(max(high, value))
    return np.array(values), np.array(lows), np.array(highs)


def bounded(n: int, p: float, sigmas: float) -> bool:
    """Whether n realizations bound the p-quantile on both sides with the asked confidence.

    All of them lie below it with the probability p^n, all above it with (1 - p)^n.
    """
    from scipy.special import ndtr

    return bool(max(p, 1.0 - p) ** n <= ndtr(-sigmas))


@lru_cache(maxsize=256)
def _bounding_ranks(n: int, p: float, sigmas: float) -> tuple[int, int]:
    """Ranks of the order statistics that bound the p-quantile with the asked confidence."""
    from scipy.special import bdtrik, ndtr

    below_low, below_high = np.ceil(np.nan_to_num(bdtrik(ndtr([-sigmas, sigmas]), n, p)))
    return max(int(below_low), 1), min(int(below_high) + 1, n)
