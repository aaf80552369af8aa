"""Models fitted to the logarithm of an Allan curve, its points independent of each other.

The logarithm has the deviation and the mean of a logarithm of χ², and the correlations of
the variances' covariance: Σ z C⁻¹ z is least.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import gauss_markov_variance
from mcsim.characterisation.problem import TERMS, Problem

Array = NDArray[np.float64]

#: Correlation times tried, per decade, and how finely the best of them is bracketed.
_PER_DECADE, _REFINED = 5, 9
#: Eigenvalues of the correlations below this are rounding and the neglect of far pairs.
_LEAST_EIGENVALUE = 1e-3
_ITERATIONS, _CONVERGED = 12, 1e-2


@dataclass(frozen=True)
class Candidate:
    """A fitted set of terms: ``squares`` (5,), ``drive`` the process's qc², 0 without one.

    ``expected`` (k,) is its Allan variance.
    """

    squares: Array
    expected: Array
    chi_square: float
    parameters: int
    drive: float = 0.0
    time: float = 0.0

    @property
    def criterion(self) -> float:
        return self.chi_square + 2.0 * self.parameters


class LogCurve:
    """The logarithm of a curve, and the factor that makes its errors independent.

    ``covariance`` (k, k) of the Allan variances, and what is ``expected`` (k,) of them.
    """

    def __init__(self, problem: Problem, covariance: Array, expected: Array) -> None:
        from scipy.linalg import solve_triangular
        from scipy.special import digamma, polygamma

        self.problem = problem
        self.design = problem.design
        deviation = np.sqrt(np.diagonal(covariance))
        half = (expected / deviation) ** 2  # half the degrees of freedom
        values, vectors = np.linalg.eigh(covariance / np.outer(deviation, deviation))
        correlation = (vectors * np.maximum(values, _LEAST_EIGENVALUE)) @ vectors.T
        scale = np.sqrt(polygamma(1, half) / np.diagonal(correlation))
        root = np.linalg.cholesky(correlation * np.outer(scale, scale))
        self.whitening = solve_triangular(root, np.eye(len(root)), lower=True)
        self.logarithm = np.log(problem.variance) - (digamma(half) - np.log(half))
        first, last = problem.tau[0], problem.tau[-1]
        self.times = np.geomspace(first, last, 3 + int(_PER_DECADE * np.log10(last / first)))

    def fit(
        self,
        terms: tuple[int, ...],
        time: float | None = None,
        start: Array | None = None,
        converged: float = _CONVERGED,
    ) -> Candidate:
        """Non-negative squares of the terms, and of a process of correlation time ``time``.

        Gauss-Newton, from the Allan variance ``start`` (k,): the logarithm is linear about the
        last solution.
        """
        from scipy.optimize import nnls

        columns = [self.design[:, term] for term in terms]
        if time is not None:
            columns.append(gauss_markov_variance(self.problem.tau, time))
        design = np.column_stack(columns)
        size = np.linalg.norm(design / self.problem.variance[:, None], axis=0)
        expected, last = self.problem.variance if start is None else start, np.inf
        for _ in range(_ITERATIONS):
            relative = self.whitening @ (design / size / expected[:, None])
            target = self.whitening @ (self.logarithm - np.log(expected) + 1.0)
            solution, _ = nnls(relative, target)
            expected = np.maximum(design / size @ solution, 1e-3 * expected)
            rest = self.whitening @ (self.logarithm - np.log(expected))
            chi_square = float(rest @ rest)
            if abs(last - chi_square) < converged:
                break
            last = chi_square
        squares = np.zeros(len(TERMS))
        squares[list(terms)] = (solution / size)[: len(terms)] * self.problem.signs[list(terms)]
        if time is None:
            return Candidate(squares, expected, chi_square, len(terms))
        drive = float(solution[-1] / size[-1])
        return Candidate(squares, expected, chi_square, len(terms) + 2, drive, time)

    def best_process(self, terms: tuple[int, ...]) -> Candidate:
        """The fit with the correlation time that suits best."""
        found: list[Candidate] = []
        for time in self.times:
            found.append(self.fit(terms, time, found[-1].expected if found else None))
        best = int(np.argmin([candidate.chi_square for candidate in found]))
        if not 0 < best < len(found) - 1:
            return found[best]
        near = np.geomspace(self.times[best - 1], self.times[best + 1], _REFINED + 2)[1:-1]
        start = found[best].expected
        return min((self.fit(terms, time, start) for time in near), key=lambda c: c.chi_square)
