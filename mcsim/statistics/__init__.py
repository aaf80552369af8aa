"""Statistics of an error's distribution: a module each, estimated with confidence intervals.

``mcsim.statistics.statistic`` tells what one must say; those that there are stand in ``choice``.
Realizations are collected (``collector``) and the statistics estimated from them (``estimates``);
``history`` has them over time.
"""

from mcsim.statistics.choice import METHOD, MOMENTS, STATISTICS, estimated, percentiles_of
from mcsim.statistics.collector import (
    KEPT,
    MOST_ITEMS,
    PERCENTILES,
    Collector,
    Rare,
    Reference,
)
from mcsim.statistics.estimates import Estimates, estimate, estimate_errors
from mcsim.statistics.evidence import Evidence
from mcsim.statistics.percentile import percentile
from mcsim.statistics.statistic import Distribution, Interval, Statistic

__all__ = [
    "KEPT",
    "METHOD",
    "MOMENTS",
    "MOST_ITEMS",
    "PERCENTILES",
    "STATISTICS",
    "Collector",
    "Distribution",
    "Estimates",
    "Evidence",
    "Interval",
    "Rare",
    "Reference",
    "Statistic",
    "estimate",
    "estimate_errors",
    "estimated",
    "percentile",
    "percentiles_of",
]
