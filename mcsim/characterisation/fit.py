"""Noise coefficients Q, N, B, K and R from an Allan curve, with intervals.

The Allan variance is linear in the squares of the coefficients.  They are fitted by
non-negative least squares, each point weighted by the inverse of the deviation that it
has under the fitted model itself, which is iterated: relative weights.  Overlapping
clusters scatter together.  The intervals come from a block bootstrap of the log, or from
the covariance of the whole curve under the model (Greenhall and Riley 2003).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import AllanCurve, allan_terms, covariances
from mcsim.characterisation.bootstrap import bootstrap_coefficients
from mcsim.characterisation.coefficients import Coefficient, coefficients_of
from mcsim.characterisation.comparison import Comparison, compare
from mcsim.characterisation.problem import (
    B,
    K,
    N,
    Problem,
    Q,
    R,
    Solution,
    likelihood,
    misfit,
    solve,
)
from mcsim.characterisation.process import GaussMarkovFit
from mcsim.characterisation.short_clusters import (
    CERTAIN,
    FEWEST_TIMES,
    first_that_follows,
    memory,
    shows_a_filter,
)

Array = NDArray[np.float64]
Intervals = Literal["bootstrap", "covariance"]

#: Terms that every fit holds; the others must prove that the data need them.
_KEPT = (N, B, K)
#: The error of the model is raised up to this, step by step, when the curve does not follow.
_MOST_MODEL_ERROR, _MODEL_ERROR_STEP = 0.5, 1.25
#: Reduction of χ² that a further term must bring (4 σ for one term).
_NEEDED = 16.0
#: Probability of a χ² at which the model no longer explains the curve by scatter alone.
_UNLIKELY = 0.01
_LEAST_VARIANCE = 1e-60


@dataclass(frozen=True)
class NoiseFit:
    """Coefficients of the model over ``tau_from`` to ``tau_to`` (s).

    ``squares`` float64 (5,) are Q², N², B², K², R² in SI units.  ``model_error`` is the
    relative error of the variance at each cluster time that the model is allowed.  ``memory``
    (s) is that of a filter in the output, 0 without one; Q² is negative then.  Where there is a
    Gauss-Markov bias, the coefficient N is that beside it.
    """

    coefficients: dict[str, Coefficient]
    squares: Array
    tau_from: float
    tau_to: float
    chi_square: float
    times: int
    confidence: float
    stated_range: bool
    model_error: float
    comparison: Comparison
    memory: float = 0.0

    @property
    def gauss_markov(self) -> GaussMarkovFit | None:
        """Noises and a Gauss-Markov bias, if the curve clearly holds one."""
        return self.comparison.process if self.comparison.is_gauss_markov else None

    @property
    def model_squares(self) -> Array:
        """Q², N², B², K², R² (5,) of the model that fits better, beside its process."""
        return self.squares if self.gauss_markov is None else self.gauss_markov.squares

    def deviation(self, tau: Array) -> Array:
        """Allan deviation (k,) of the model that fits better."""
        if self.gauss_markov is not None:
            return self.gauss_markov.allan_deviation(tau)
        return (allan_terms(tau) @ self.squares) ** 0.5

    def __getitem__(self, term: str) -> Coefficient:
        return self.coefficients[term]


def fit_noise(
    curve: AllanCurve,
    tau_range: tuple[float, float] | None = None,
    confidence: float = 0.95,
    intervals: Intervals = "bootstrap",
) -> NoiseFit:
    """Fit Q, N, B, K and R to an overlapping Allan curve.

    ``intervals`` come from a block bootstrap of the log, or from the covariance that the curve
    has under the fitted model.  Q and R enter only where χ² demands them.  Without a
    ``tau_range`` (s) the shortest clusters are left out as long as they contradict the model,
    as those of a sensor with a low-pass filter do.

    Raises
    ------
    ValueError
        Fewer than six cluster times in the range, or a bootstrap of a curve that does not
        overlap.
    """
    curve, problem = _problem(curve, tau_range)
    free = tau_range is None
    first = first_that_follows(problem) if free else 0
    problem = problem.part(slice(first, None))
    curve = curve.part(np.arange(first, len(curve.factors)))
    problem, terms, solution = _choose_terms(problem, first > 0)
    comparison = compare(problem, terms, solution.squares, confidence)
    doubtful = problem.filtered and first == 0 and not shows_a_filter(problem, _KEPT, CERTAIN)
    found = {}
    if comparison.is_gauss_markov and comparison.process is not None:
        white = _white_part(problem, comparison.process)
        beside = _allow_for_the_model(white, terms, solve(white, terms))
        whole = curve.part(np.arange(len(white.tau)))
        short = _coefficients(whole, *beside, terms, confidence, intervals)["N"]
        found["N"] = _white_beside(comparison.process, short)
    problem, solution = _allow_for_the_model(problem, terms, solution)
    found = _coefficients(curve, problem, solution, terms, confidence, intervals) | found
    if doubtful:
        plain = replace(problem, filtered=False)
        without = _coefficients(curve, plain, solve(plain, _KEPT), _KEPT, confidence, intervals)
        found["N"] = _both(found["N"], without["N"])
    return NoiseFit(
        coefficients=found,
        squares=solution.squares,
        tau_from=float(problem.tau[0]),
        tau_to=float(problem.tau[-1]),
        chi_square=solution.chi_square,
        times=len(problem.tau),
        confidence=confidence,
        stated_range=not free,
        model_error=problem.model_error,
        comparison=comparison,
        memory=memory(solution),
    )


def _both(one: Coefficient, other: Coefficient) -> Coefficient:
    """A coefficient with an interval that holds those of two models."""
    return Coefficient(one.value, min(one.low, other.low), max(one.high, other.high))


def _white_beside(process: GaussMarkovFit, short: Coefficient) -> Coefficient:
    """N of the fit with a process, and an interval no narrower than that of short clusters."""
    value, factor = process.coefficient(N), process.white_factor
    if not (value and short.value):
        return short
    low = min(1.0 / factor, short.low / short.value)
    return Coefficient(value, low * value, max(factor, short.high / short.value) * value)


def _white_part(problem: Problem, process: GaussMarkovFit) -> Problem:
    """The clusters that hold more white noise than process, which is a random walk there."""
    white = process.squares[N] / problem.tau
    less = white < process.model.allan_variance(problem.tau)
    count = int(np.argmax(less)) if np.any(less) else len(less)
    return problem.part(slice(0, max(count, FEWEST_TIMES)))


def _coefficients(
    curve: AllanCurve,
    problem: Problem,
    solution: Solution,
    terms: tuple[int, ...],
    confidence: float,
    intervals: Intervals,
) -> dict[str, Coefficient]:
    if intervals == "covariance":
        return coefficients_of(problem, solution, terms, confidence)
    if curve.stretches is None:
        raise ValueError("a bootstrap needs the overlapping Allan variance")
    return bootstrap_coefficients(problem, solution, terms, curve.stretches, confidence)


def _problem(
    curve: AllanCurve, tau_range: tuple[float, float] | None
) -> tuple[AllanCurve, Problem]:
    """The part of the curve that is fitted, and how it scatters."""
    low, high = tau_range or (0.0, np.inf)
    # Five cluster times to a decade hold all that ten do.
    keep = np.flatnonzero((curve.tau >= low) & (curve.tau <= high))[::2]
    if len(keep) < FEWEST_TIMES:
        raise ValueError(
            f"{len(keep)} cluster times between {low:.4g} s and {high:.4g} s; "
            f"a fit needs at least {FEWEST_TIMES}"
        )
    part = curve.part(keep)
    # A log without noise has variances of zero, which no logarithm and no weight takes.
    variance = np.maximum(part.variance, _LEAST_VARIANCE)
    return part, Problem(part.tau, variance, covariances(part))


def _choose_terms(problem: Problem, shaped: bool) -> tuple[Problem, tuple[int, ...], Solution]:
    """The kept terms, and those others that lower χ² by enough.

    A filter's term is in where short clusters were ``shaped`` by one, or where it shows.
    """
    terms: tuple[int, ...] = _KEPT
    if shaped or shows_a_filter(problem, terms):
        problem, terms = replace(problem, filtered=True), tuple(sorted((Q, *terms)))
    solution = solve(problem, terms)
    for extra in (R,) if Q in terms else (Q, R):
        longer = tuple(sorted((*terms, extra)))
        trial = solve(problem, longer)
        # Compared under the same weights: a richer model must not win by wider errors.
        before = misfit(problem, solution.squares, trial.weights)
        if before - trial.chi_square > _NEEDED and trial.squares[extra] > 0.0:
            terms, solution = longer, trial
    return problem, terms, solution


def _allow_for_the_model(
    problem: Problem, terms: tuple[int, ...], solution: Solution
) -> tuple[Problem, Solution]:
    """Raise the error of the model until the curve's misfit is likely under it.

    Real noise is no exact sum of five powers of τ.  Without this the well known short
    clusters would bend the model away from the long ones, and the intervals would lie.
    """
    while (
        likelihood(problem, terms, solution) < _UNLIKELY and problem.model_error < _MOST_MODEL_ERROR
    ):
        problem = replace(problem, model_error=problem.model_error * _MODEL_ERROR_STEP)
        solution = solve(problem, terms)
    return problem, solution
