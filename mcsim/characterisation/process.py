"""A first-order Gauss-Markov process beside the noises of an Allan variance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.allan import allan_terms, gauss_markov_variance

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GaussMarkov:
    """First-order Gauss-Markov process, Eq. (3.27): correlation time (s), deviation."""

    correlation_time: float
    deviation: float

    def allan_variance(self, tau: Array) -> Array:
        """Allan variance (k,) at cluster times (k,) in s."""
        # σ² = qc² Tc / 2: the variance of a process with the table's density.
        qc2 = 2.0 * self.deviation**2 / self.correlation_time
        return qc2 * gauss_markov_variance(tau, self.correlation_time)

    def density(self, frequency: Array) -> Array:
        """Two-sided power spectral density (k,) at frequencies (k,) in Hz."""
        turn = 2.0 * np.pi * frequency * self.correlation_time
        return np.asarray(2.0 * self.deviation**2 * self.correlation_time / (1.0 + turn**2))


@dataclass(frozen=True)
class GaussMarkovFit:
    """Noises and a Gauss-Markov bias together.

    ``squares`` (5,) are Q², N², B², K², R² beside the process; ``chi_square`` is the misfit.
    ``time_low``, ``time_high`` (s) and ``deviation_low``, ``deviation_high`` are intervals; from
    zero to infinity where the curve was not asked for them, or gives no end.  N's interval is
    N over and times ``white_factor``.
    """

    model: GaussMarkov
    squares: Array
    chi_square: float
    time_low: float = 0.0
    time_high: float = math.inf
    deviation_low: float = 0.0
    deviation_high: float = math.inf
    white_factor: float = 1.0

    def coefficient(self, term: int) -> float:
        """Coefficient of a noise beside the process; ``term`` as in ``problem.TERMS``."""
        return float(np.sqrt(self.squares[term]))

    def allan_deviation(self, tau: Array) -> Array:
        """Allan deviation (k,) of noises and process together."""
        return np.asarray((allan_terms(tau) @ self.squares + self.model.allan_variance(tau)) ** 0.5)
