"""Estimates of an error's distribution, each with a confidence interval.

Realizations are collected (``collector``), and mean, deviation and RMS (``moments``) and
percentiles (``quantiles``) estimated from them (``estimates``).
"""

from mcsim.statistics.collector import KEPT, MOST_ITEMS, PERCENTILES, Collector, Rare, Reference
from mcsim.statistics.estimates import (
    MOMENTS,
    Estimates,
    estimate,
    estimate_errors,
    statistic_names,
)

__all__ = [
    "KEPT",
    "MOMENTS",
    "MOST_ITEMS",
    "PERCENTILES",
    "Collector",
    "Estimates",
    "Rare",
    "Reference",
    "estimate",
    "estimate_errors",
    "statistic_names",
]
