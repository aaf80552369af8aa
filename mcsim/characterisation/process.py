"""A first-order Gauss-Markov process in flicker's place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import allan_terms, gauss_markov_variance
from mcsim.characterisation.problem import K, N, Problem

Array = NDArray[np.float64]


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


def fit_gauss_markov(problem: Problem, weights: Array) -> GaussMarkovFit | None:
    """White noise, random walk and a process; the correlation time by search.

    None where the best correlation time lies at an end of the cluster times.
    """
    from scipy.optimize import minimize_scalar, nnls

    base = allan_terms(problem.tau)[:, [N, K]]
    target = weights * problem.variance

    def solve(log_time: float) -> tuple[Array, float]:
        shape = gauss_markov_variance(problem.tau, float(np.exp(log_time)))
        design = np.column_stack([base, shape]) * weights[:, None]
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
