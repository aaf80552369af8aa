"""Which estimator serves a point, and which points of space: what its limits allow.

A linear model as control, and Sobol points, gain where errors follow what disturbs them smoothly.
Where few realizations may do what neither follows, plain random ones serve instead.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from mcsim.scenario.error_quantities import UNITS
from mcsim.scenario.run import MonteCarlo
from mcsim.simulation.limits import may_wrap
from mcsim.simulation.problem import Limit, Problem
from mcsim.statistics import Rare, Reference, estimated, percentiles_of

#: With fewer realizations the fitted coefficients of control variates would pretend
#: a precision that is not there; the plain estimator serves them.
FEWEST_CONTROLLED = 500
#: Realizations that limits are looked for in, at most.
LOOKED_AT = 1000
#: Realizations beyond an abrupt limit that must be there before a control is trusted to
#: follow them, and events of a rare kind before they count as seen.
SEEN = 50


def limit_texts(limits: Iterable[Limit]) -> tuple[str, ...]:
    """What is said of limits: those that are reached."""
    return tuple(limit.text for limit in limits if limit.text)


def takes_nets(problem: Problem, settings: MonteCarlo, limits: Sequence[Limit]) -> bool:
    """Whether what realizations draw once comes from Sobol nets.

    Not where an angle may wrap or an abrupt limit is in reach: there the nets' few means tell
    neither their own scatter nor what a net that holds no such realization misses.
    """
    return settings.offsets == "sobol" and not unsmooth(problem, limits)


def unsmooth(problem: Problem, limits: Sequence[Limit]) -> bool:
    """Whether errors may jump: an angle's by a turn, or all of them at an abrupt limit."""
    return any(limit.abrupt for limit in limits) or bool(np.any(_may_wrap(problem)))


def reference(
    problem: Problem, settings: MonteCarlo, count: int, limits: Sequence[Limit]
) -> Reference:
    """What the estimator may use: the method errors, and the linear model's moments."""
    method, rare = problem.method_errors(), rare_events(problem)
    percentiles = percentiles_of(estimated(problem.percentiles))
    if settings.estimator == "plain" or count < FEWEST_CONTROLLED:
        return Reference(method, percentiles=percentiles, rare=rare)
    linear, trusted = problem.linear, _trusted(problem, count, limits)
    return Reference(
        method,
        np.where(trusted, linear.control_mean, np.nan),
        np.where(trusted, linear.control_second_moment, np.nan),
        percentiles,
        rare,
    )


def rare_events(problem: Problem) -> Rare | None:
    """Spikes and flips of angles, if there are any."""
    linear = problem.linear
    none = np.zeros(len(problem.error_names))
    spikes = linear.spike_events if len(linear.spike_events) else none
    flips = linear.flips if len(linear.flips) else none
    if not (np.any(spikes) or np.any(flips)):
        return None
    variance = linear.spike_variance() + flips * np.pi**2
    return Rare(variance, np.where(flips > 0.0, flips, spikes))


def _trusted(problem: Problem, count: int, limits: Sequence[Limit]) -> NDArray[np.bool_]:
    """Whether the linear model is a control of each error.

    Not where a realization may do, and so few do that the run would not show it, what no linear
    model follows: an angle wraps, or a range is reached.
    """
    trusted = ~_may_wrap(problem)
    for limit in limits:
        hardly = limit.looked_at and limit.reached * count < SEEN * limit.looked_at
        if limit.abrupt and not limit.certain and hardly:
            trusted[:] = False
    return trusted


def _may_wrap(problem: Problem) -> NDArray[np.bool_]:
    """Angles (e,) whose error may lie beyond half a turn by the linear model."""
    method, spread = problem.method_errors(), problem.linear.spread
    return np.array(
        [
            UNITS.get(name) == "deg" and may_wrap(method[i], spread[i])
            for i, name in enumerate(problem.error_names)
        ],
        bool,
    )
