"""Gauss-Markov bias, or flicker and random walk?  Models of a curve compared.

Every set of terms that holds N is fitted to the logarithm of the Allan variance, which has
the deviation and the mean of a logarithm of χ², and the correlations of the fit's own
covariance: Σ z C⁻¹ z.  Akaike's criterion adds two for each parameter.  The best set with a
Gauss-Markov process and the best without are compared.

A process whose correlation time nears the log's longest clusters is a random walk as far as
the log can show: then neither wins, and ``shortest_alike`` says from where on.  How often
each is found is in ``benchmarks/bias_models.txt``.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import allan_terms, gauss_markov_variance
from mcsim.characterisation.problem import TERMS, B, K, N, Problem
from mcsim.characterisation.process import GaussMarkov, GaussMarkovFit

Array = NDArray[np.float64]

#: A difference of Akaike's criterion that decides, and one that is worth a word.
DECIDES, SUGGESTS = 4.0, 2.0
#: Correlation times tried, per decade, and how finely the best of them is bracketed.
_PER_DECADE, _REFINED = 5, 9
#: Correlation times whose χ² lies this far above the least fit as well (95 %).
_AS_WELL = 4.0
#: Eigenvalues of the correlations below this are rounding and the neglect of far pairs.
_LEAST_EIGENVALUE = 1e-3
_ITERATIONS, _CONVERGED = 12, 1e-2
#: Relative error of any model at each cluster time, on the variance: what real noise differs
#: by from a sum of powers is no process.  The misfit (χ² per cluster time) at which even the
#: best model needs more, the step that raises it, and its end.
_MODEL_ERROR, _MISFITS, _STEP, _MOST_MODEL_ERROR = 0.1, 2.0, 1.5, 0.5


@dataclass(frozen=True)
class Comparison:
    """What the log says about the kind of its bias.

    ``gain`` is how much lower Akaike's criterion is with the ``process`` than without.
    ``shortest_alike`` (s): a process of any longer correlation time in random walk's place fits
    as well as random walk does; None where there is no random walk.
    """

    gain: float
    process: GaussMarkovFit | None
    shortest_alike: float | None

    @property
    def is_gauss_markov(self) -> bool:
        return self.process is not None and self.gain > DECIDES

    @property
    def is_undecided(self) -> bool:
        """Whether the process fits better, but not by enough."""
        return self.process is not None and SUGGESTS < self.gain <= DECIDES


@dataclass(frozen=True)
class _Candidate:
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


def compare(problem: Problem, terms: tuple[int, ...], squares: Array) -> Comparison:
    """Compare models of a curve with and without a Gauss-Markov process.

    Parameters
    ----------
    problem : Problem
        What is fitted, with the covariance of its points.
    terms : tuple of int
        Terms of the fit; B and K are tried with and without.
    squares : float64 (5,)
        The fit, under which the points scatter.
    """
    whole = _Curve(replace(problem, model_error=_MODEL_ERROR), squares)
    while True:
        least = min(whole.fit(terms), whole.best_process(terms), key=lambda c: c.chi_square)
        error = whole.problem.model_error
        if least.chi_square < _MISFITS * len(problem.tau) or error * _STEP > _MOST_MODEL_ERROR:
            break
        whole = _Curve(replace(problem, model_error=error * _STEP), squares)
    sets = list(_sets(terms))
    without = min((whole.fit(s) for s in sets), key=lambda c: c.criterion)
    bests = [whole.best_process(s) for s in sets]
    process = min(bests, key=lambda c: c.criterion)
    found = None
    times = whole.times
    if process.drive > 0.0 and times[0] < process.time < times[-1]:
        found = _process_fit(whole, process)
    return Comparison(
        gain=without.criterion - process.criterion,
        process=found,
        shortest_alike=_shortest_alike(whole, without),
    )


def _sets(terms: tuple[int, ...]) -> Iterable[tuple[int, ...]]:
    """The terms with both, one or none of B and K."""
    always = [term for term in terms if term not in (B, K)]
    for count in range(3):
        for chosen in combinations((B, K), count):
            yield tuple(sorted((*always, *chosen)))


def _process_fit(curve: _Curve, best: _Candidate) -> GaussMarkovFit:
    terms = tuple(np.flatnonzero(best.squares).tolist()) or (N,)
    near = [
        time
        for time in curve.times
        if curve.fit(terms, time).chi_square <= best.chi_square + _AS_WELL
    ]
    return GaussMarkovFit(
        model=GaussMarkov(best.time, float(np.sqrt(best.drive * best.time / 2.0))),
        time_low=min([best.time, *near]),
        time_high=max([best.time, *near]),
        squares=best.squares,
        chi_square=best.chi_square,
    )


def _shortest_alike(curve: _Curve, without: _Candidate) -> float | None:
    """The shortest correlation time of a process that stands in for random walk as well."""
    if not without.squares[K] > 0.0:
        return None
    others = tuple(term for term in np.flatnonzero(without.squares).tolist() if term != K)
    for time in curve.times[::-1]:
        if curve.fit(others, time).chi_square > without.chi_square + _AS_WELL:
            return float(time)
    return float(curve.times[0])


class _Curve:
    """The logarithm of a curve, and the factor that makes its errors independent."""

    def __init__(self, problem: Problem, squares: Array) -> None:
        from scipy.linalg import solve_triangular
        from scipy.special import digamma, polygamma

        self.problem = problem
        self.design = problem.design
        covariance = problem.covariance(squares)
        deviation = np.sqrt(np.diagonal(covariance))
        half = (allan_terms(problem.tau) @ squares / deviation) ** 2  # half the degrees of freedom
        values, vectors = np.linalg.eigh(covariance / np.outer(deviation, deviation))
        correlation = (vectors * np.maximum(values, _LEAST_EIGENVALUE)) @ vectors.T
        scale = np.sqrt(polygamma(1, half) / np.diagonal(correlation))
        root = np.linalg.cholesky(correlation * np.outer(scale, scale))
        self.whitening = solve_triangular(root, np.eye(len(root)), lower=True)
        self.logarithm = np.log(problem.variance) - (digamma(half) - np.log(half))
        first, last = problem.tau[0], problem.tau[-1]
        self.times = np.geomspace(first, last, 3 + int(_PER_DECADE * np.log10(last / first)))

    def fit(
        self, terms: tuple[int, ...], time: float | None = None, start: Array | None = None
    ) -> _Candidate:
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
            if abs(last - chi_square) < _CONVERGED:
                break
            last = chi_square
        squares = np.zeros(len(TERMS))
        squares[list(terms)] = (solution / size)[: len(terms)] * self.problem.signs[list(terms)]
        if time is None:
            return _Candidate(squares, expected, chi_square, len(terms))
        drive = float(solution[-1] / size[-1])
        return _Candidate(squares, expected, chi_square, len(terms) + 2, drive, time)

    def best_process(self, terms: tuple[int, ...]) -> _Candidate:
        """The fit with the correlation time that suits best."""
        found: list[_Candidate] = []
        for time in self.times:
            found.append(self.fit(terms, time, found[-1].expected if found else None))
        best = int(np.argmin([candidate.chi_square for candidate in found]))
        if not 0 < best < len(found) - 1:
            return found[best]
        near = np.geomspace(self.times[best - 1], self.times[best + 1], _REFINED + 2)[1:-1]
        start = found[best].expected
        return min((self.fit(terms, time, start) for time in near), key=lambda c: c.chi_square)
