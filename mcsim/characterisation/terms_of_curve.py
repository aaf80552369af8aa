"""Non-negative terms whose Allan variances make up a tabulated curve.

An Allan variance does not determine its density: different densities have the same one (Greenhall,
IEEE Trans. Instrum. Meas. 47, 623, 1998).  What is well posed is the fit of a few terms.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation import noise_terms
from mcsim.characterisation.allan import gauss_markov_variance
from mcsim.characterisation.noise_terms import NoiseTerm, total_variance
from mcsim.characterisation.process import GaussMarkov

Array = NDArray[np.float64]

#: Correlation times tried per decade.
_PER_DECADE = 20
_ROUNDS = 10


@dataclass(frozen=True)
class FittedTerms:
    """``terms`` found, those of zero left out; ``misfit`` (k,) of the deviation, as parts of 1."""

    terms: tuple[NoiseTerm, ...]
    misfit: Array

    @property
    def rms(self) -> float:
        """Root mean square of the misfit."""
        return float(np.sqrt(np.mean(self.misfit**2)))


def terms_of_curve(
    tau: Array,
    deviation: Array,
    letters: Sequence[str],
    spread: Array | None = None,
    interval: float | None = None,
) -> FittedTerms:
    """Fit terms to an Allan deviation by non-negative least squares on relative errors.

    Parameters
    ----------
    tau, deviation : float64 (k,)
        Cluster times in s, Allan deviation in SI units.
    letters : sequence of str
        Of ``Q``, ``N``, ``B``, ``K``, ``R``, ``GM``.
    spread : float64 (k,), optional
        Relative errors of the deviation; growing as √τ if absent, as those of one log do.
    interval : float, optional
        Sampling interval (s), which the density of quantisation needs; the shortest cluster if
        absent.
    """
    weights = 1.0 / (np.sqrt(tau / tau[0]) if spread is None else spread)
    step = interval or float(tau[0])
    makers = {
        "Q": lambda c: noise_terms.quantisation(c, step),
        "N": noise_terms.white,
        "B": noise_terms.flicker,
        "K": noise_terms.random_walk,
        "R": noise_terms.ramp,
    }
    powers = [letter for letter in letters if letter in makers]
    design = [makers[letter](1.0).variance(tau) for letter in powers]
    times = [0.0]
    if "GM" in letters:
        count = int(_PER_DECADE * np.log10(tau[-1] / tau[0])) + 1
        times = np.geomspace(tau[0], tau[-1], count).tolist()
    best, least, time = np.zeros(len(design)), np.inf, 0.0
    for trial in times:
        columns = [*design, gauss_markov_variance(tau, trial)] if trial else design
        squares, chi = _solve(np.column_stack(columns), deviation**2, weights)
        if chi < least:
            best, least, time = squares, chi, trial
    found = [makers[x](float(np.sqrt(s))) for x, s in zip(powers, best, strict=False) if s > 0.0]
    if time and best[-1] > 0.0:
        found.append(
            noise_terms.gauss_markov(GaussMarkov(time, float(np.sqrt(best[-1] * time / 2.0))))
        )
    model = np.sqrt(total_variance(found, tau)) if found else np.zeros_like(tau)
    return FittedTerms(tuple(found), model / deviation - 1.0)


def _solve(design: Array, variance: Array, weights: Array) -> tuple[Array, float]:
    """Squares (p,) and χ²; the weights are relative to the model, which is iterated."""
    from scipy.optimize import nnls

    expected = variance
    for _ in range(_ROUNDS):
        relative = design * (weights / expected)[:, None]
        size = np.maximum(np.linalg.norm(relative, axis=0), 1e-300)
        solution, _ = nnls(relative / size, weights * variance / expected)
        squares = solution / size
        expected = np.maximum(design @ squares, 1e-6 * variance)
    rest = weights * (variance / expected - 1.0)
    return squares, float(rest @ rest)
