"""Percentiles of an error, with distribution-free intervals.

They need no resampling: the order statistics that bound them with the asked confidence are
known (Hahn & Meeker, *Statistical Intervals*, sect. 5.2).
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from mcsim.errors import InputError
from mcsim.statistics.statistic import Array, Distribution, Interval, Statistic

if TYPE_CHECKING:
    from mcsim.statistics.evidence import Evidence

#: The percentile that summaries show.
_SUMMARY = 0.95
_ORDINALS = {1: "st", 2: "nd", 3: "rd"}


def percentile(p: float) -> Statistic:
    """The p-quantile as a statistic: ``percentile(0.975)`` is ``p97.5``.

    Parameters
    ----------
    p : float
        Between 0 and 1.

    Returns
    -------
    Statistic

    Raises
    ------
    InputError
        Not strictly between 0 and 1.
    """
    if not 0.0 < p < 1.0:
        raise InputError(f"percentile({p:g}): a share between 0 and 1 is needed, such as 0.95")
    return _made(p)


@lru_cache
def _made(p: float) -> Statistic:
    """One object for each p: statistics are compared."""

    def value(errors: Array) -> Array:
        return np.asarray(np.quantile(errors, p, axis=-1), float)

    def estimate(evidence: Evidence) -> Interval:
        rows = [_estimate(evidence, int(row), p) for row in evidence.rows]
        return Interval(*np.array(rows).T)

    def linear(distribution: Distribution) -> Array:
        return distribution.quantile(p)

    return Statistic(
        percentile_name(p),
        _words(p),
        value,
        summary=p == _SUMMARY,
        estimate=estimate,
        linear=linear,
        percentiles=(p,),
        bounded=lambda n, sigmas: _bounded(n, p, sigmas),
    )


def percentile_name(p: float) -> str:
    """What tables call it: ``p05``, ``p50``, ``p97.5``."""
    return f"p{100.0 * p:02g}"


def _words(p: float) -> str:
    if p == 0.5:
        return "median"
    number = f"{100.0 * p:g}"
    teens = number[-2:] in ("11", "12", "13")
    ending = "th" if teens or "." in number else _ORDINALS.get(int(number[-1]), "th")
    return f"{number}{ending} percentile"


def _estimate(evidence: Evidence, error: int, p: float) -> tuple[float, float, float]:
    """The percentile of one error and its interval's ends.

    The number of errors below the true p-quantile is binomial(n, p), whatever the
    distribution: so the order statistics at its quantiles bound the p-quantile.  In a Sobol net
    realizations depend on each other: where the nets' numbers scatter more, so much further apart
    are the bounds; where they scatter less, this is not made use of.
    """
    collector = evidence.collector
    n = collector.count
    position = p * (n - 1)
    rank = int(position)
    a, b = collector.order_statistics(error, p, [rank + 1, min(rank + 2, n)])
    value = a + (b - a) * (position - rank)
    reach = evidence.sigmas * collector.scatter_below(error, value)
    low, high = collector.order_statistics(error, p, list(_bounding_ranks(n, p, reach)))
    return value, min(low, value), max(high, value)


def _bounded(n: int, p: float, sigmas: float) -> bool:
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
