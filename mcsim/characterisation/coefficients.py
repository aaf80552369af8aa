"""Intervals of fitted coefficients, from the covariance of the whole curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import allan_terms
from mcsim.characterisation.problem import TERMS, Problem, Q, R, Solution

Array = NDArray[np.float64]

#: An upper end beyond this multiple of the estimate's square is none.
_LARGEST_RATIO = 1e6


@dataclass(frozen=True)
class Coefficient:
    """A coefficient in SI units with its interval; 0 where the data show nothing of it."""

    value: float
    low: float
    high: float

    @property
    def seen(self) -> bool:
        """Whether the interval excludes zero."""
        return self.low > 0.0


def coefficients_of(
    problem: Problem, solution: Solution, terms: tuple[int, ...], confidence: float
) -> dict[str, Coefficient]:
    """Values and intervals of the fitted terms, by name."""
    weighted = allan_terms(problem.tau)[:, terms] * solution.weights[:, None]
    size = np.linalg.norm(weighted, axis=0)
    estimators = np.linalg.pinv(weighted / size) / size[:, None] * solution.weights
    found = {}
    for index, name in enumerate(TERMS):
        if index not in terms or (index == Q and problem.filtered):
            continue
        row = estimators[terms.index(index)]
        low, high = _interval(problem, solution.squares, index, row, confidence)
        found[name] = Coefficient(*np.sqrt([solution.squares[index], low, high]).tolist())
    return found


def _interval(
    problem: Problem,
    squares: Array,
    index: int,
    weights: Array,
    confidence: float,
) -> tuple[float, float]:
    """Values p of a squared coefficient that its estimate does not contradict.

    ``weights`` (k,) make the estimate's error out of the errors of the curve.  Under p
    its variance is a + b p + c p², and its skewness that of the part that scales with p:
    a Pearson III distribution, χ² where that part is all, normal where it is none.
    """
    from scipy.optimize import brentq
    from scipy.stats import pearson3

    def variance_of(p: float, rest: float) -> float:
        mix = rest * squares
        mix[index] = p
        return float(weights @ problem.covariance(mix) @ weights)

    constant = variance_of(0.0, 1.0)
    own = variance_of(1.0, 0.0) if index != R else 0.0
    step = max(float(squares[index]), np.sqrt(constant))
    slope = (variance_of(step, 1.0) - constant) / step - own * step
    estimate = float(squares[index])

    def above(p: float) -> float:
        """Probability of an estimate above the one found."""
        variance = max(constant + slope * p + own * p * p, 1e-300)
        skewness = 2.0 * np.sqrt(own) * (own * p * p / variance) ** 1.5
        return float(pearson3.sf(estimate, skewness, loc=p, scale=np.sqrt(variance)))

    tail = (1.0 - confidence) / 2.0
    low = 0.0 if above(0.0) >= tail else brentq(lambda p: above(p) - tail, 0.0, estimate)
    high = step
    while above(high) < 1.0 - tail and high < _LARGEST_RATIO * step:
        high *= 2.0
    if above(high) < 1.0 - tail:
        return float(low), float("inf")
    return float(low), float(brentq(lambda p: above(p) - (1.0 - tail), estimate, high))
