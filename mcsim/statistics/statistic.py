"""What a statistic must say."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mcsim.statistics.resampling import resampled_interval

if TYPE_CHECKING:
    from mcsim.statistics.evidence import Evidence

Array = NDArray[np.float64]

#: Equally probable values that stand for a distribution where a statistic has no closed form.
_POINTS = 512


@dataclass(frozen=True)
class Interval:
    """A statistic of some errors and the ends of its confidence interval, (e,) each."""

    value: Array
    low: Array
    high: Array


@dataclass(frozen=True)
class Distribution:
    """The errors (e,) of a linear model: normal, but where ``quantiles`` has a row's function."""

    mean: Array
    std: Array
    quantiles: Mapping[int, Callable[[float], float]] = field(default_factory=dict)

    def quantile(self, p: float) -> Array:
        """The p-quantile of each error (e,)."""
        from scipy.special import ndtri

        value = np.asarray(self.mean + self.std * ndtri(p), float)
        for row, function in self.quantiles.items():
            value[row] = function(p)
        return value


@dataclass(frozen=True)
class Statistic:
    """A statistic of an error's distribution; a function of realizations is enough.

    Attributes
    ----------
    name : str
        In tables, and in the figure block of scenarios.
    words : str
        In figures: ``standard deviation``.
    value : callable
        ``value(errors)``: of realizations (…, r) along the last axis to (…), in the errors' SI
        units, and in them linear: twice the errors, twice the value.
    never_negative : bool
        So that intervals end at zero.
    log_axes : bool
        Whether figures may show it on a logarithmic axis, where its values span decades.
    summary : bool
        Whether it is among those that a single run prints and draws.
    estimate : callable, optional
        ``estimate(evidence) -> Interval`` of the errors ``evidence.rows``.  Without it the value is
        that of the realizations kept (the first ``KEPT``) and the interval the bootstrap's over
        them: for statistics that follow all realizations, not for extremes, of which few decide.
    linear : callable, optional
        ``linear(distribution)`` (e,): what the linear model says.  Without it, the value of
        equally probable errors.
    percentiles : tuple of float
        Percentiles that realizations are kept around, if its ``estimate`` needs some.
    bounded : callable, optional
        ``bounded(n, sigmas)``: whether n realizations bound it on both sides; any do without.
    """

    name: str
    words: str
    value: Callable[[Array], Array]
    never_negative: bool = False
    log_axes: bool = True
    summary: bool = True
    estimate: Callable[[Evidence], Interval] | None = None
    linear: Callable[[Distribution], Array] | None = None
    percentiles: tuple[float, ...] = ()
    bounded: Callable[[int, float], bool] | None = None

    def interval(self, evidence: Evidence) -> Interval:
        """Its value with its interval, from realizations."""
        if self.estimate is not None:
            return self.estimate(evidence)
        value, low, high = resampled_interval(evidence, self.value)
        return Interval(value, np.maximum(low, 0.0) if self.never_negative else low, high)

    def by_linear_model(self, distribution: Distribution) -> Array:
        """Its value (e,) by the linear model."""
        if self.linear is not None:
            return self.linear(distribution)
        shares = (np.arange(_POINTS) + 0.5) / _POINTS
        return self.value(np.stack([distribution.quantile(float(p)) for p in shares], axis=-1))

    def without_scatter(self, error: float) -> float:
        """Its value where every realization has the same error."""
        return float(self.value(np.array([error])))

    def bounds(self, n: int, sigmas: float) -> bool:
        """Whether n realizations bound it on both sides with the asked confidence."""
        return self.bounded is None or self.bounded(n, sigmas)
