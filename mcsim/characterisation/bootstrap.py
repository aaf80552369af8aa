"""Intervals of fitted coefficients from a moving-block bootstrap of the log.

Blocks of the log are drawn with replacement and put end to end (Künsch 1989, Annals of
Statistics 17, 1217).  The Allan variances of such a log, but for the differences across
the seams, are sums of what the blocks hold of them: no sample is touched again.  Each
resampled curve is fitted like the log's own, and the quantiles of the results are the
interval.

A block knows nothing of clusters longer than itself: there the resampled curves scatter
too little (K of the thesis's sensors would be covered in 80 to 94 % of the cases where
95 % are promised).  Where they scatter less than Gaussian noise of the fitted model
would, they are therefore spread to its scatter, each cluster time for itself.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import Stretches, allan_terms
from mcsim.characterisation.coefficients import Coefficient, coefficients_of
from mcsim.characterisation.nonnegative import nonnegative_squares
from mcsim.characterisation.problem import TERMS, Problem, R, Solution
from mcsim.kernels.allan import NOISES

Array = NDArray[np.float64]

#: Blocks to a log.
_BLOCKS = 32
#: Resampled logs: at least, at most, and beyond an end of the interval.
_FEWEST, _MOST, _BEYOND = 1000, 20_000, 10
_SEED = 1
#: Rounds of weights and squares: with two, two more in a hundred intervals of K miss.
_ROUNDS = 8
#: A resampled variance below this part of the log's own counts as this part.
_LEAST_RATIO = 1e-6


def largest_confidence() -> float:
    """The confidence (probability) up to which resampled logs are enough for an interval."""
    return 1.0 - 2.0 * _BEYOND / _MOST


def bootstrap_coefficients(
    problem: Problem,
    solution: Solution,
    terms: tuple[int, ...],
    stretches: Stretches,
    confidence: float,
) -> dict[str, Coefficient]:
    """Values and percentile intervals of the fitted terms, by name.

    The blocks drawn are the same for every log: the result depends on the log alone.
    """
    tail = (1.0 - confidence) / 2.0
    count = int(np.clip(np.ceil(_BEYOND / tail), _FEWEST, _MOST))
    curves = resampled_variances(stretches, drawn_blocks(count, stretches.counts.shape[1]))
    squares = _solve_all(problem, solution, terms, _spread(curves, problem, solution))
    low, high = np.quantile(squares, [tail, 1.0 - tail], axis=0)
    found = coefficients_of(problem, solution, terms, confidence)
    for index, name in enumerate(TERMS):
        if name in found:
            value, gaussian = found[name].value, found[name]
            ends = np.sqrt(np.maximum([low[index], high[index]], 0.0)).tolist()
            found[name] = Coefficient(
                value, min(ends[0], gaussian.low), max(ends[1], gaussian.high)
            )
    return found


@lru_cache(maxsize=2)
def drawn_blocks(count: int, stretches: int) -> Array:
    """How often each stretch is part of each resampled log, (count, stretches)."""
    length = max(1, stretches // _BLOCKS)
    random = np.random.default_rng(_SEED)
    starts = random.integers(0, stretches - length + 1, (count, -(-stretches // length)))
    # One more from each start on, one less from each end on.
    change = np.zeros((count, stretches + 1))
    rows = np.arange(count)[:, None]
    np.add.at(change, (rows, starts), 1.0)
    np.add.at(change, (rows, starts + length), -1.0)
    drawn = np.cumsum(change, axis=1)[:, :stretches]
    drawn.setflags(write=False)
    return drawn


def resampled_variances(stretches: Stretches, drawn: Array) -> Array:
    """Allan variances (r, k) of logs put together from blocks, drawn (r, stretches)."""
    differences = drawn @ stretches.counts.T
    # A log whose blocks hold no pair of the longest clusters says nothing new about them.
    known = differences > 0.0
    sums = drawn @ stretches.squares.T
    return np.where(known, sums / np.where(known, differences, 1.0), stretches.variance)


def _spread(curves: Array, problem: Problem, solution: Solution) -> Array:
    """Curves (r, k), on the logarithmic axis farther from the log's own where too close."""
    from scipy.special import polygamma

    expected = allan_terms(problem.tau) @ solution.squares
    degrees = 2.0 * expected**2 / np.diagonal(problem.covariance(solution.squares))
    # The deviation of the logarithm of χ².
    wanted = np.sqrt(polygamma(1, 0.5 * degrees))
    # Of a log with a few steps, some blocks hold none.
    away = np.log(np.maximum(curves / problem.variance, _LEAST_RATIO))
    scatter = np.maximum(away.std(axis=0), 1e-12)
    return np.asarray(problem.variance * np.exp(away * np.maximum(1.0, wanted / scatter)))


def _solve_all(
    problem: Problem, solution: Solution, terms: tuple[int, ...], curves: Array
) -> Array:
    """Squared coefficients (r, 5) of each curve: as ``solve`` finds them, all at once."""
    design, signs = problem.design, problem.signs
    products = np.einsum("abkk->abk", problem.scatter.products)
    ramps = np.einsum("akk->ak", problem.scatter.ramps)
    weights = np.broadcast_to(solution.weights, curves.shape)
    squares = np.zeros((len(curves), len(TERMS)))
    for _ in range(_ROUNDS):
        squares[:, terms] = nonnegative_squares(design[:, terms], curves, weights)
        noises = (squares * signs)[:, :NOISES]
        variance = np.einsum("ra,rb,abk->rk", noises, noises, products, optimize=True)
        variance += squares[:, [R]] * (noises @ ramps)
        variance += (problem.model_error * (squares @ design.T)) ** 2
        weights = 1.0 / np.sqrt(variance)
    return squares * signs
