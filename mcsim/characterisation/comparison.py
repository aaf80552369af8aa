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

from mcsim.characterisation.allan import allan_terms
from mcsim.characterisation.log_curve import Candidate, LogCurve
from mcsim.characterisation.problem import B, K, Problem
from mcsim.characterisation.process import GaussMarkovFit
from mcsim.characterisation.process_fit import process_of, settled

Array = NDArray[np.float64]

#: A difference of Akaike's criterion that decides, and one that is worth a word.
DECIDES, SUGGESTS = 4.0, 2.0
#: Correlation times whose χ² lies this far above the least fit as well (95 %).
_AS_WELL = 4.0
#: Relative error of any model at each cluster time, on the variance: what real noise differs
#: by from a sum of powers is no process.  The misfit (χ² per cluster time) at which even the
#: best model needs more, the step that raises it, and its end.
_MODEL_ERROR, _MISFITS, _STEP, _MOST_MODEL_ERROR = 0.1, 2.0, 1.5, 0.5


@dataclass(frozen=True)
class Comparison:
    """What the log says about the kind of its bias.

    ``gain`` is how much lower Akaike's criterion is with the ``process`` than without.
    ``shortest_alike`` (s): a process of any longer correlation time in random walk's place fits
    as well as random walk does; None where there is no random walk.  ``sums`` are the models
    without a process: all terms of the fit, and those without B, K or both.
    """

    gain: float
    process: GaussMarkovFit | None
    shortest_alike: float | None
    sums: tuple[Candidate, ...] = ()

    @property
    def is_gauss_markov(self) -> bool:
        return self.process is not None and self.gain > DECIDES

    @property
    def is_undecided(self) -> bool:
        """Whether the process fits better, but not by enough."""
        return self.process is not None and SUGGESTS < self.gain <= DECIDES


def compare(
    problem: Problem, terms: tuple[int, ...], squares: Array, confidence: float = 0.95
) -> Comparison:
    """Compare models of a curve with and without a Gauss-Markov process.

    Parameters
    ----------
    problem : Problem
        What is fitted, with the covariance of its points.
    terms : tuple of int
        Terms of the fit; B and K are tried with and without.
    squares : float64 (5,)
        The fit, under which the points scatter.
    confidence : float
        Probability of the intervals of a process that wins, or nearly so.
    """
    whole = _curve(problem, squares, _MODEL_ERROR)
    while True:
        least = min(whole.fit(terms), whole.best_process(terms), key=lambda c: c.chi_square)
        error = whole.problem.model_error
        if least.chi_square < _MISFITS * len(problem.tau) or error * _STEP > _MOST_MODEL_ERROR:
            break
        whole = _curve(problem, squares, error * _STEP)
    sets = list(_sets(terms))
    sums = tuple(whole.fit(s) for s in sets)
    without = min(sums, key=lambda c: c.criterion)
    bests = [whole.best_process(s) for s in sets]
    process = min(bests, key=lambda c: c.criterion)
    found = None
    times = whole.times
    if process.drive > 0.0 and times[0] < process.time < times[-1]:
        found = process_of(process)
    gain = without.criterion - process.criterion
    if found is not None and gain > SUGGESTS:
        found = settled(problem, found, confidence)
    return Comparison(
        gain=gain,
        process=found,
        shortest_alike=_shortest_alike(whole, without),
        sums=sums,
    )


def _sets(terms: tuple[int, ...]) -> Iterable[tuple[int, ...]]:
    """The terms with both, one or none of B and K."""
    always = [term for term in terms if term not in (B, K)]
    for count in range(3):
        for chosen in combinations((B, K), count):
            yield tuple(sorted((*always, *chosen)))


def _curve(problem: Problem, squares: Array, model_error: float) -> LogCurve:
    problem = replace(problem, model_error=model_error)
    return LogCurve(problem, problem.covariance(squares), allan_terms(problem.tau) @ squares)


def _shortest_alike(curve: LogCurve, without: Candidate) -> float | None:
    """The shortest correlation time of a process that stands in for random walk as well."""
    if not without.squares[K] > 0.0:
        return None
    others = tuple(term for term in np.flatnonzero(without.squares).tolist() if term != K)
    for time in curve.times[::-1]:
        if curve.fit(others, time).chi_square > without.chi_square + _AS_WELL:
            return float(time)
    return float(curve.times[0])
