"""The linear problem behind a fit: Allan variances, their scatter, and its solution."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import Covariances, allan_terms
from mcsim.kernels.allan import NOISES

Array = NDArray[np.float64]

#: The terms of the model, in the order of all arrays here.
TERMS = ("Q", "N", "B", "K", "R")
Q, N, B, K, R = range(5)
#: Relative error of the model itself at each cluster time, on the variance: the least.
LEAST_MODEL_ERROR = 0.003
_ITERATIONS = 30


@dataclass(frozen=True)
class Problem:
    """The part of a curve that is fitted: ``tau``, ``variance`` (k,), and how they scatter.

    ``filtered``: the output is low-passed, held or averaged.  A filter whose memory is c takes
    1.5 c N² / τ² off the Allan variance of clusters that outlast it (the integral of its output
    lags behind that of white noise by a bounded error): a negative Q².
    """

    tau: Array
    variance: Array
    scatter: Covariances
    model_error: float = LEAST_MODEL_ERROR
    filtered: bool = False

    @property
    def signs(self) -> Array:
        """Sign (5,) of each squared coefficient."""
        return np.array([-1.0 if self.filtered else 1.0, 1.0, 1.0, 1.0, 1.0])

    @property
    def design(self) -> Array:
        """Allan variance (k, 5) of each term, signed: what non-negative amounts are sought of."""
        return allan_terms(self.tau) * self.signs

    def covariance(self, squares: Array) -> Array:
        """Covariance (k, k) of the variances, and the model's own error, under a model."""
        expected = allan_terms(self.tau) @ squares
        mixed = self.scatter.of(squares[:NOISES], squares[R])
        return mixed + np.diag((self.model_error * expected) ** 2)

    def part(self, which: slice) -> Problem:
        """The problem of some of the cluster times."""
        return replace(
            self,
            tau=self.tau[which],
            variance=self.variance[which],
            scatter=self.scatter.part(which),
        )


@dataclass(frozen=True)
class Solution:
    """``squares`` (5,) of the coefficients, ``weights`` (k,) the inverse deviations.

    Q² is negative where the problem is ``filtered``.

    ``chi_square`` is the weighted misfit squared.
    """

    squares: Array
    weights: Array
    chi_square: float


def likelihood(problem: Problem, terms: tuple[int, ...], solution: Solution) -> float:
    """Probability of a misfit as large as this one, if the model were right.

    The points scatter together, so that the misfit is a sum of χ² with weights; a scaled
    χ² with its mean and variance stands for it (Satterthwaite).
    """
    from scipy.stats import chi2

    covariance = problem.covariance(solution.squares)
    design = allan_terms(problem.tau)[:, terms] * solution.weights[:, None]
    size = np.linalg.norm(design, axis=0)
    left = np.eye(len(problem.tau)) - (design / size) @ np.linalg.pinv(design / size)
    spread = left @ (covariance * np.outer(solution.weights, solution.weights)) @ left.T
    mean, half_variance = float(np.trace(spread)), float(np.sum(spread**2))
    freedom = mean**2 / half_variance
    return float(chi2.sf(solution.chi_square * freedom / mean, freedom))


def solve(problem: Problem, terms: tuple[int, ...]) -> Solution:
    """Non-negative least squares with relative weights, iterated until they fit the model."""
    from scipy.optimize import nnls

    design = problem.design[:, terms]
    squares = np.zeros(len(TERMS))
    # To begin with, every point has the scatter of white noise alone.
    weights = 1.0 / (np.sqrt(problem.tau) * problem.variance)
    for iteration in range(_ITERATIONS):
        weighted = design * weights[:, None]
        size = np.linalg.norm(weighted, axis=0)
        solved, _ = nnls(weighted / size, weights * problem.variance)
        last = squares
        squares = np.zeros(len(TERMS))
        squares[list(terms)] = solved / size * problem.signs[list(terms)]
        weights = 1.0 / np.sqrt(np.diagonal(problem.covariance(squares)))
        if iteration and np.allclose(squares, last, rtol=1e-6, atol=0.0):
            break
    return Solution(squares, weights, misfit(problem, squares, weights))


def misfit(problem: Problem, squares: Array, weights: Array) -> float:
    """Sum of the squared, weighted distances of the curve from a model."""
    rest = weights * (problem.variance - allan_terms(problem.tau) @ squares)
    return float(rest @ rest)
