"""Statistics over time, and what a table knows of an instant carried back to those before.

What is known of the end is carried back by regression, with the end's error as a control:
``m(t) + b(t) (m_known - m(end))`` with the slope b of the error at t over that at the end, and so
for squares and all other statistics.  So a history ends in its table.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mcsim.statistics.choice import MOMENTS, estimated
from mcsim.statistics.statistic import Statistic

Array = NDArray[np.float64]

#: Percentiles that histories show.
_PERCENTILES = (0.05, 0.50, 0.95)


def history_statistics() -> dict[str, Statistic]:
    """The statistics of histories by name, in the order of their tables."""
    return estimated(_PERCENTILES)


def values_over_time(errors: Array) -> dict[str, Array]:
    """Statistics (n,) of errors (n, r) at n instants."""
    return {name: statistic.value(errors) for name, statistic in history_statistics().items()}


def carry_back(
    values: Mapping[str, Array],
    errors: Array,
    span: slice,
    end: int,
    known: Mapping[str, float],
) -> None:
    """Regress a span of the values (n,) of errors (n, r) on what is known of the sample ``end``."""
    own = {name: float(value[end]) for name, value in values.items()}
    slope, slope_of_squares = (
        _slopes(errors[span] ** power, errors[end] ** power) for power in (1, 2)
    )
    before = values["mean"][span]
    mean = before + slope * (known["mean"] - own["mean"])
    # Changes of the variance, so that a small one keeps its digits beside a large mean.
    change = slope_of_squares * (known["rms"] ** 2 - own["rms"] ** 2) - (mean**2 - before**2)
    values["mean"][span] = mean
    values["std"][span] = np.sqrt(np.maximum(values["std"][span] ** 2 + change, 0.0))
    values["rms"][span] = np.sqrt(mean**2 + values["std"][span] ** 2)
    joint = {moment.name for moment in MOMENTS}
    for name, statistic in history_statistics().items():
        if name in known and name not in joint:
            shifted = values[name][span] + slope * (known[name] - own[name])
            values[name][span] = np.maximum(shifted, 0.0) if statistic.never_negative else shifted
    for name in values.keys() & known.keys():
        values[name][end] = known[name]


def _slopes(errors: Array, end: Array) -> Array:
    """Least-squares slopes (n,) of errors (n, r) over the end's (r,); zero if these are equal."""
    deviation = end - end.mean()
    spread = float(deviation @ deviation)
    if not spread > 0.0:
        return np.zeros(len(errors))
    return np.asarray((errors - errors.mean(axis=-1, keepdims=True)) @ deviation / spread, float)
