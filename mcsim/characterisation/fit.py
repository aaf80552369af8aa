"""Noise coefficients Q, N, B, K and R from an Allan curve, with intervals.

The Allan variance is linear in the squares of the coefficients.  They are fitted by
non-negative least squares, each point weighted by the inverse of the deviation that it
has under the fitted model itself, which is iterated: relative weights.  Overlapping
clusters scatter together; the intervals follow from their whole covariance under the
model (Greenhall and Riley 2003).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import (
    AllanCurve,
    Covariances,
    allan_terms,
    covariances,
    gauss_markov_variance,
)
from mcsim.kernels.allan import NOISES

Array = NDArray[np.float64]

#: The terms of the model, in the order of all arrays here.
TERMS = ("Q", "N", "B", "K", "R")
Q, N, B, K, R = range(5)
#: Terms that every fit holds; the others must prove that the data need them.
_KEPT = (N, B, K)
#: Relative error of the model itself at each cluster time, on the variance: the least,
#: and the most that it is raised to when the curve does not follow the model.
_LEAST_MODEL_ERROR, _MOST_MODEL_ERROR, _MODEL_ERROR_STEP = 0.003, 0.5, 1.25
#: Reduction of χ² that a further term must bring (4 σ for one term).
_NEEDED = 16.0
#: The shortest cluster is left out when it lies off by so many standard errors, and by
#: this part, from what the next ones say.
_MISFIT, _VISIBLE, _NEIGHBOURS = 5.0, 0.04, 4
#: Probability of a χ² at which the model no longer explains the curve by scatter alone.
_UNLIKELY = 0.01
#: An upper end beyond this multiple of the estimate's square is none.
_LARGEST_RATIO = 1e6
#: A Gauss-Markov bias takes flicker's place when the model error with flicker is larger
#: than this, and χ² so many times that with the process.
_VISIBLE_MODEL_ERROR, _CLEARLY = 0.05, 4.0
_ITERATIONS = 30
_FEWEST_TIMES = 6


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


@dataclass(frozen=True)
class GaussMarkov:
    """First-order Gauss-Markov process, Eq. (3.27): correlation time (s), deviation."""

    correlation_time: float
    deviation: float


@dataclass(frozen=True)
class GaussMarkovFit:
    """White noise, random walk and a Gauss-Markov bias in flicker's place."""

    model: GaussMarkov
    time_low: float
    time_high: float
    white: float
    random_walk: float
    chi_square: float

    def allan_deviation(self, tau: Array) -> Array:
        """Allan deviation (k,) of white noise, random walk and the process."""
        qc2 = 2.0 * self.model.deviation**2 / self.model.correlation_time
        process = qc2 * gauss_markov_variance(tau, self.model.correlation_time)
        straight = allan_terms(tau)[:, [N, K]] @ [self.white**2, self.random_walk**2]
        return (straight + process) ** 0.5


@dataclass(frozen=True)
class NoiseFit:
    """Coefficients of the model over ``tau_from`` to ``tau_to`` (s).

    ``squares`` float64 (5,) are Q², N², B², K², R² in SI units.  ``model_error`` is the
    relative error of the variance at each cluster time that the model is allowed.
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
    gauss_markov: GaussMarkovFit | None = None

    @property
    def prefers_gauss_markov(self) -> bool:
        """Whether flicker visibly misses the curve, and a Gauss-Markov bias does not."""
        return (
            self.gauss_markov is not None
            and self.model_error > _VISIBLE_MODEL_ERROR
            and self.chi_square > _CLEARLY * self.gauss_markov.chi_square
        )

    def deviation(self, tau: Array) -> Array:
        """Allan deviation (k,) of the model that fits better."""
        if self.gauss_markov is not None and self.prefers_gauss_markov:
            return self.gauss_markov.allan_deviation(tau)
        return (allan_terms(tau) @ self.squares) ** 0.5

    def __getitem__(self, term: str) -> Coefficient:
        return self.coefficients[term]


@dataclass(frozen=True)
class _Problem:
    """The part of a curve that is fitted, and how its points scatter."""

    tau: Array
    variance: Array
    scatter: Covariances
    model_error: float = _LEAST_MODEL_ERROR

    def covariance(self, squares: Array) -> Array:
        expected = allan_terms(self.tau) @ squares
        mixed = self.scatter.of(squares[:NOISES], squares[R])
        return mixed + np.diag((self.model_error * expected) ** 2)

    def without_first(self) -> _Problem:
        rest = slice(1, None)
        return _Problem(self.tau[rest], self.variance[rest], self.scatter.part(rest))


@dataclass(frozen=True)
class _Solution:
    """``weights`` (k,) are inverse deviations; ``chi_square`` the weighted misfit squared."""

    squares: Array
    weights: Array
    chi_square: float


def fit_noise(
    curve: AllanCurve,
    tau_range: tuple[float, float] | None = None,
    confidence: float = 0.95,
) -> NoiseFit:
    """Fit Q, N, B, K and R to an overlapping Allan curve.

    Q and R enter only where χ² demands them.  Without a ``tau_range`` (s) the shortest
    clusters are left out as long as they contradict the model, as those of a sensor
    with a low-pass filter do.

    Raises
    ------
    ValueError
        Fewer than six cluster times in the range.
    """
    problem = _problem(curve, tau_range)
    free = tau_range is None
    while free and len(problem.tau) > _FEWEST_TIMES + _NEIGHBOURS and _first_misfits(problem):
        problem = problem.without_first()
    terms, solution = _choose_terms(problem)
    problem, solution = _allow_for_the_model(problem, terms, solution)
    fit = NoiseFit(
        coefficients=_coefficients(problem, solution, terms, confidence),
        squares=solution.squares,
        tau_from=float(problem.tau[0]),
        tau_to=float(problem.tau[-1]),
        chi_square=solution.chi_square,
        times=len(problem.tau),
        confidence=confidence,
        stated_range=not free,
        model_error=problem.model_error,
    )
    return replace(fit, gauss_markov=_fit_gauss_markov(problem, solution))


def _problem(curve: AllanCurve, tau_range: tuple[float, float] | None) -> _Problem:
    low, high = tau_range or (0.0, np.inf)
    # Five cluster times to a decade hold all that ten do.
    keep = np.flatnonzero((curve.tau >= low) & (curve.tau <= high))[::2]
    if len(keep) < _FEWEST_TIMES:
        raise ValueError(
            f"{len(keep)} cluster times between {low:.4g} s and {high:.4g} s; "
            f"a fit needs at least {_FEWEST_TIMES}"
        )
    part = replace(curve, factors=curve.factors[keep], variance=curve.variance[keep])
    return _Problem(part.tau, part.variance, covariances(part))


def _choose_terms(problem: _Problem) -> tuple[tuple[int, ...], _Solution]:
    """The kept terms, and those others that lower χ² by enough."""
    terms: tuple[int, ...] = _KEPT
    solution = _solve(problem, terms)
    for extra in (Q, R):
        longer = tuple(sorted((*terms, extra)))
        trial = _solve(problem, longer)
        # Compared under the same weights: a richer model must not win by wider errors.
        before = _misfit(problem, solution.squares, trial.weights)
        if before - trial.chi_square > _NEEDED and trial.squares[extra] > 0.0:
            terms, solution = longer, trial
    return terms, solution


def _allow_for_the_model(
    problem: _Problem, terms: tuple[int, ...], solution: _Solution
) -> tuple[_Problem, _Solution]:
    """Raise the error of the model until the curve's misfit is likely under it.

    Real noise is no exact sum of five powers of τ.  Without this the well known short
    clusters would bend the model away from the long ones, and the intervals would lie.
    """
    while (
        _likelihood(problem, terms, solution) < _UNLIKELY
        and problem.model_error < _MOST_MODEL_ERROR
    ):
        problem = replace(problem, model_error=problem.model_error * _MODEL_ERROR_STEP)
        solution = _solve(problem, terms)
    return problem, solution


def _likelihood(problem: _Problem, terms: tuple[int, ...], solution: _Solution) -> float:
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


def _solve(problem: _Problem, terms: tuple[int, ...]) -> _Solution:
    from scipy.optimize import nnls

    design = allan_terms(problem.tau)[:, terms]
    squares = np.zeros(len(TERMS))
    # To begin with, every point has the scatter of white noise alone.
    weights = 1.0 / (np.sqrt(problem.tau) * problem.variance)
    for iteration in range(_ITERATIONS):
        weighted = design * weights[:, None]
        size = np.linalg.norm(weighted, axis=0)
        solved, _ = nnls(weighted / size, weights * problem.variance)
        last = squares
        squares = np.zeros(len(TERMS))
        squares[list(terms)] = solved / size
        weights = 1.0 / np.sqrt(np.diagonal(problem.covariance(squares)))
        if iteration and np.allclose(squares, last, rtol=1e-6, atol=0.0):
            break
    return _Solution(squares, weights, _misfit(problem, squares, weights))


def _misfit(problem: _Problem, squares: Array, weights: Array) -> float:
    rest = weights * (problem.variance - allan_terms(problem.tau) @ squares)
    return float(rest @ rest)


def _first_misfits(problem: _Problem) -> bool:
    """Whether the shortest cluster contradicts what the next ones say about it."""
    after = slice(1, 1 + _NEIGHBOURS)
    next_ones = _Problem(problem.tau[after], problem.variance[after], problem.scatter.part(after))
    squares = _solve(next_ones, (Q, *_KEPT)).squares
    expected = float((allan_terms(problem.tau[:1]) @ squares)[0])
    scatter = float(np.sqrt(problem.covariance(squares)[0, 0]))
    return abs(problem.variance[0] - expected) > max(_MISFIT * scatter, _VISIBLE * expected)


def _coefficients(
    problem: _Problem, solution: _Solution, terms: tuple[int, ...], confidence: float
) -> dict[str, Coefficient]:
    weighted = allan_terms(problem.tau)[:, terms] * solution.weights[:, None]
    size = np.linalg.norm(weighted, axis=0)
    estimators = np.linalg.pinv(weighted / size) / size[:, None] * solution.weights
    found = {}
    for index, name in enumerate(TERMS):
        if index not in terms:
            continue
        row = estimators[terms.index(index)]
        low, high = _interval(problem, solution.squares, index, row, confidence)
        found[name] = Coefficient(*np.sqrt([solution.squares[index], low, high]).tolist())
    return found


def _interval(
    problem: _Problem,
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


def _fit_gauss_markov(problem: _Problem, solution: _Solution) -> GaussMarkovFit | None:
    """White noise, random walk and a Gauss-Markov process; the correlation time by search."""
    from scipy.optimize import minimize_scalar, nnls

    base = allan_terms(problem.tau)[:, [N, K]]
    target = solution.weights * problem.variance

    def solve(log_time: float) -> tuple[Array, float]:
        shape = gauss_markov_variance(problem.tau, float(np.exp(log_time)))
        design = np.column_stack([base, shape]) * solution.weights[:, None]
        size = np.linalg.norm(design, axis=0)
        solved, rest = nnls(design / size, target)
        return solved / size, float(rest**2)

    grid = np.log(np.geomspace(problem.tau[0], problem.tau[-1], 60))
    found = np.array([solve(g)[1] for g in grid])
    best = int(np.argmin(found))
    if best in (0, len(grid) - 1):
        return None
    refined = minimize_scalar(
        lambda g: solve(g)[1], bounds=(grid[best - 1], grid[best + 1]), method="bounded"
    )
    (white, walk, drive), chi_square = solve(float(refined.x))
    if drive <= 0.0:
        return None
    time = float(np.exp(refined.x))
    near = np.exp(grid[found <= chi_square + 4.0])
    ends = (float(near.min()), float(near.max())) if len(near) else (time, time)
    return GaussMarkovFit(
        # σ² = qc² Tc / 2: the variance of a process with the table's density.
        model=GaussMarkov(time, float(np.sqrt(drive * time / 2.0))),
        time_low=min(ends[0], time),
        time_high=max(ends[1], time),
        white=float(np.sqrt(white)),
        random_walk=float(np.sqrt(walk)),
        chi_square=chi_square,
    )
