"""The standard deviation of an error, that of the population."""

from __future__ import annotations

from mcsim.statistics.statistic import Array, Statistic


def _value(errors: Array) -> Array:
    return errors.std(axis=-1)


DEVIATION = Statistic(
    "std",
    "standard deviation",
    _value,
    never_negative=True,
    estimate=lambda evidence: evidence.moments.std,
    linear=lambda distribution: distribution.std,
)
