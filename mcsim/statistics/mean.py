"""The mean of an error."""

from __future__ import annotations

from mcsim.statistics.statistic import Array, Statistic


def _value(errors: Array) -> Array:
    return errors.mean(axis=-1)


MEAN = Statistic(
    "mean",
    "mean",
    _value,
    log_axes=False,
    estimate=lambda evidence: evidence.moments.mean,
    linear=lambda distribution: distribution.mean,
)
