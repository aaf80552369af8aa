"""Where the model begins: short clusters that a filter, a hold or an average has shaped.

The integral of low-passed, held or averaged white noise is that of white noise less an error
that stays bounded.  Clusters that outlast the filter's memory therefore have the Allan variance
N²/τ - 1.5 c N²/τ², whatever the filter; shorter ones have another one for each filter.  Those
are left out, one by one from the shortest on, as long as one contradicts what the next ones
say about it; the term in τ⁻² is kept, without which N would be low by 0.75 c/τ.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import allan_terms
from mcsim.characterisation.problem import B, K, N, Problem, Q, Solution, solve

Array = NDArray[np.float64]

#: Clusters that say what the shortest one should be, and those that a fit needs at least.
_NEIGHBOURS, FEWEST_TIMES = 10, 6
#: A contradiction (standard errors) that shows a filter: one in 2000 axes without one.  Where
#: there is one, the next clusters must follow more closely.
_CONTRADICTS, _FOLLOWS = 3.5, 1.5
#: The τ⁻² term of a filter is in the model from here on, and shows for certain (standard errors).
_SHOWS, CERTAIN = 2.0, 4.0
#: Relative error of the model at short clusters, on the variance.
_MODEL_ERROR = 0.001
#: Inside of a filter's memory the next Allan variance is no less than this part of the one
#: before (white noise: 0.6); a memory of more samples than these is a sensor's bias.
_RISES, _LONGEST_MEMORY = 0.85, 300
#: The fit begins at so many memories c.  Of a first-order low-pass the Allan variance differs
#: there from the two terms by 2 (c/τ) e^(-τ/c), 0.3 %: the model's own error.
_OUTLASTS = 5.0


def first_that_follows(problem: Problem) -> int:
    """How many of the shortest clusters are shaped by a filter, and contradict the others."""
    strict = replace(problem, model_error=_MODEL_ERROR)
    most = len(problem.tau) - FEWEST_TIMES - 4
    first = min(_inside_of_a_memory(problem), max(most, 0))
    shaped = first > 0 or filter_shown(problem, (N, B, K)) > CERTAIN
    while first < most:
        limit = _FOLLOWS if shaped else _CONTRADICTS
        if abs(_contradiction(strict.part(slice(first, None)))) < limit:
            break
        first, shaped = first + 1, True
    if not shaped:
        return 0
    filtered = replace(problem.part(slice(first, None)), filtered=True)
    outlast = _OUTLASTS * memory(solve(filtered, (Q, N, B, K)))
    outlast = min(outlast, _OUTLASTS * _LONGEST_MEMORY * problem.tau[0])
    return max(first, min(int(np.searchsorted(problem.tau, outlast)), most))


def _inside_of_a_memory(problem: Problem) -> int:
    """Number of clusters up to the maximum of a curve that does not fall at its beginning."""
    longest = int(np.searchsorted(problem.tau, _LONGEST_MEMORY * problem.tau[0]))
    ratios = (
        problem.variance[1 : longest + 1]
        / problem.variance[: len(problem.variance[1 : longest + 1])]
    )
    falls = ratios < _RISES
    return int(np.argmax(falls)) if np.any(falls) else 0


def _contradiction(problem: Problem) -> float:
    """Distance of the shortest cluster from what the next ones say, in standard errors."""
    from scipy.optimize import nnls

    near = problem.part(slice(0, 1 + _NEIGHBOURS))
    columns = allan_terms(near.tau)[:, [Q, Q, N, B, K]] * np.array([1.0, -1.0, 1.0, 1.0, 1.0])
    # White noise scatters by √τ; so far apart, the others hardly differ.
    weights = 1.0 / (np.sqrt(near.tau) * near.variance)
    weighted = columns * weights[:, None]
    size = np.linalg.norm(weighted, axis=0)
    found, _ = nnls((weighted / size)[1:], (weights * near.variance)[1:])
    used = found > 0.0
    amounts = found / size
    rows = np.linalg.pinv((weighted / size)[1:, used])
    from_others = (weighted / size)[0, used] @ rows * weights[1:] / weights[0]
    errors = np.concatenate([[1.0], -from_others])
    squares = np.array([amounts[0] - amounts[1], *amounts[2:], 0.0])
    covariance = near.covariance(squares) + _sampled(near, squares)
    deviation = float(np.sqrt(errors @ covariance @ errors))
    return float(errors @ near.variance) / max(deviation, 1e-300)


def _sampled(problem: Problem, squares: Array) -> Array:
    """Error (k, k) of slow noises at clusters of few samples, which are not continuous there."""
    interval = problem.tau[0]
    slow = allan_terms(problem.tau)[:, [B, K]] @ squares[[B, K]]
    return np.diag((slow * interval / problem.tau) ** 2)


def shows_a_filter(problem: Problem, terms: tuple[int, ...], errors: float = _SHOWS) -> bool:
    """Whether the curve bends below white noise at its shortest clusters, by standard errors."""
    return filter_shown(problem, terms) > errors


def filter_shown(problem: Problem, terms: tuple[int, ...]) -> float:
    """The τ⁻² term of a filter beside ``terms``, in standard errors."""
    filtered = replace(problem, filtered=True, model_error=_MODEL_ERROR)
    longer = tuple(sorted((Q, *terms)))
    solution = solve(filtered, longer)
    if not solution.squares[Q]:
        return 0.0
    used = tuple(term for term in longer if solution.squares[term])
    weighted = allan_terms(problem.tau)[:, used] * solution.weights[:, None]
    size = np.linalg.norm(weighted, axis=0)
    row = np.linalg.pinv(weighted / size)[used.index(Q)] / size[used.index(Q)] * solution.weights
    deviation = float(np.sqrt(row @ filtered.covariance(solution.squares) @ row))
    return abs(float(solution.squares[Q])) / max(deviation, 1e-300)


def memory(solution: Solution) -> float:
    """The memory c (s) of the filter in a solution, 0 without one."""
    white = float(solution.squares[N])
    return 2.0 * max(-float(solution.squares[Q]), 0.0) / white if white else 0.0
