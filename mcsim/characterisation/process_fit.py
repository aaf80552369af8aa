"""The Gauss-Markov process of a curve, with intervals of its correlation time and deviation.

A comparison of models takes the scatter of the curve from the noises that stand in the
process's place; here it is that of the process itself.  The interval of the correlation time
is where Σ z C⁻¹ z, least over everything else, exceeds its minimum by less than the quantile of
χ² (profile likelihood); that of the deviation is symmetric on the logarithmic axis.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import allan_terms, gauss_markov_variance
from mcsim.characterisation.log_curve import Candidate, LogCurve
from mcsim.characterisation.problem import LEAST_MODEL_ERROR, N, Problem
from mcsim.characterisation.process import GaussMarkov, GaussMarkovFit

Array = NDArray[np.float64]

#: Rounds of covariance and fit.
_ROUNDS = 3
#: The error of the model is raised as long as the misfit has less than this probability.
_UNLIKELY, _MOST_MODEL_ERROR, _STEP = 0.01, 0.5, 1.25
#: Steps of the correlation time away from the best one, and how far it may lie outside of the
#: cluster times before an end of its interval is none.
_AWAY, _OUTSIDE = 1.25, 3.0
_CONVERGED = 1e-6


def process_of(best: Candidate) -> GaussMarkovFit:
    """The process of a candidate, without intervals."""
    deviation = float(np.sqrt(best.drive * best.time / 2.0))
    return GaussMarkovFit(GaussMarkov(best.time, deviation), best.squares, best.chi_square)


def settled(problem: Problem, found: GaussMarkovFit, confidence: float) -> GaussMarkovFit:
    """The process fitted under its own scatter, with intervals."""
    terms = tuple(sorted({N, *np.flatnonzero(found.squares).tolist()}))
    problem = replace(problem, model_error=LEAST_MODEL_ERROR)
    squares, drive, time = found.squares, _drive(found.model), found.model.correlation_time
    for _ in range(_ROUNDS):
        curve = _curve(problem, squares, drive, time)
        best = _best(curve, terms, time)
        while _is_unlikely(best, curve) and curve.problem.model_error < _MOST_MODEL_ERROR:
            problem = replace(problem, model_error=_STEP * curve.problem.model_error)
            curve = _curve(problem, squares, drive, time)
            best = _best(curve, terms, time)
        if not best.drive:
            return found
        squares, drive, time = best.squares, best.drive, best.time
    low, high = _times(curve, terms, best, confidence)
    fit = process_of(best)
    white, deviation = (
        math.exp(_quantile(confidence) * error) for error in _log_errors(curve, terms, best)
    )
    return replace(
        fit,
        time_low=low,
        time_high=high,
        deviation_low=fit.model.deviation / deviation,
        deviation_high=fit.model.deviation * deviation,
        white_factor=white,
    )


def _drive(model: GaussMarkov) -> float:
    return 2.0 * model.deviation**2 / model.correlation_time


def _curve(problem: Problem, squares: Array, drive: float, time: float) -> LogCurve:
    tau = problem.tau
    expected = allan_terms(tau) @ squares + drive * gauss_markov_variance(tau, time)
    scatter = problem.scatter.with_process(tau, squares, drive, time)
    return LogCurve(problem, scatter + np.diag((problem.model_error * expected) ** 2), expected)


def _is_unlikely(best: Candidate, curve: LogCurve) -> bool:
    from scipy.stats import chi2

    freedom = max(len(curve.problem.tau) - best.parameters, 1)
    return float(chi2.sf(best.chi_square, freedom)) < _UNLIKELY


def _at(curve: LogCurve, terms: tuple[int, ...], logarithm: float) -> Candidate:
    return curve.fit(terms, math.exp(logarithm), None, _CONVERGED)


def _best(curve: LogCurve, terms: tuple[int, ...], time: float) -> Candidate:
    from scipy.optimize import minimize_scalar

    centre = math.log(time)
    found = minimize_scalar(
        lambda x: _at(curve, terms, x).chi_square,
        bounds=(centre - 1.0, centre + 1.0),
        method="bounded",
        options={"xatol": 1e-4},
    )
    return _at(curve, terms, float(found.x))


def _times(
    curve: LogCurve, terms: tuple[int, ...], best: Candidate, confidence: float
) -> tuple[float, float]:
    """Where the profile exceeds its minimum by the quantile of χ²; 0 or infinite for no end."""
    from scipy.optimize import brentq

    limit = best.chi_square + _quantile(confidence) ** 2

    def above(logarithm: float) -> float:
        return _at(curve, terms, logarithm).chi_square - limit

    tau, centre, step = curve.problem.tau, math.log(best.time), math.log(_AWAY)
    bounds = math.log(tau[0] / _OUTSIDE), math.log(tau[-1] * _OUTSIDE)
    ends = []
    for sign, bound, none in ((-1.0, bounds[0], 0.0), (1.0, bounds[1], math.inf)):
        inside, outside = centre, centre + sign * step
        while sign * (bound - outside) > 0.0 and above(outside) < 0.0:
            inside, outside = outside, outside + sign * step
        known = above(outside) > 0.0
        ends.append(math.exp(brentq(above, inside, outside, xtol=1e-4)) if known else none)
    return ends[0], ends[1]


def _log_errors(curve: LogCurve, terms: tuple[int, ...], best: Candidate) -> tuple[float, float]:
    """Standard errors of the logarithms of N and of the process's deviation, √(qc² Tc / 2)."""
    tau, small = curve.problem.tau, 1e-3
    unit = gauss_markov_variance(tau, best.time)
    longer, shorter = (gauss_markov_variance(tau, best.time * math.exp(s)) for s in (small, -small))
    used = [term for term in terms if best.squares[term]]
    columns = [
        *(allan_terms(tau)[:, used] * best.squares[used]).T,
        best.drive * unit,
        best.drive * (longer - shorter) / (2.0 * small),
    ]
    relative = curve.whitening @ (np.column_stack(columns) / best.expected[:, None])
    size = np.linalg.norm(relative, axis=0)
    covariance = np.linalg.pinv((relative / size).T @ (relative / size)) / np.outer(size, size)
    white = covariance[used.index(N), used.index(N)] if N in used else 0.0
    return 0.5 * float(np.sqrt(white)), 0.5 * float(np.sqrt(covariance[-2:, -2:].sum()))


def _quantile(confidence: float) -> float:
    from scipy.special import ndtri

    return float(ndtri(0.5 * (1.0 + confidence)))
