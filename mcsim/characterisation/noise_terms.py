"""The terms of Allan analysis: of each its two-sided density and its Allan variance.

Equations (3.13) to (3.21) of the thesis, and quantisation, ramp and sinusoid of IEEE Std 952,
which the thesis names.  Densities are two-sided, as Eq. (3.12) has them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.process import GaussMarkov

Array = NDArray[np.float64]
Function = Callable[[Array], Array]

#: Floor of the Allan deviation of flicker noise, in parts of B: √(2 ln 2 / π).
FLOOR = math.sqrt(2.0 * math.log(2.0) / math.pi)
#: The peak of a Gauss-Markov process: τ / Tc where it lies, and σ / (qc √Tc) there.  The thesis
#: prints 1.89 and 0.437; these are the digits behind them.
PEAK_TIME, PEAK_LEVEL = 1.892618, 0.436542
#: Below this argument Eq. (3.16) cancels, and its series stands for it.
_SMALL = 0.02


@dataclass(frozen=True)
class ReadOff:
    """Where a coefficient is read: at ``tau`` (s) the deviation is ``level`` of the coefficient."""

    tau: float
    level: float


@dataclass(frozen=True)
class NoiseTerm:
    """A term with its coefficient, in SI units.

    ``letter`` is Allan's (``Q``, ``N``, ``B``, ``K``, ``R``, ``GM``, ``S``), ``words`` what it
    is called, ``slope`` that of its deviation on the logarithmic axes as print shows it.
    ``variance`` takes cluster times (k,) in s, ``density`` frequencies (k,) in Hz above zero to
    the two-sided density; a ramp and a sinusoid have none that is a function.
    """

    letter: str
    words: str
    slope: str
    coefficient: float
    variance: Function
    density: Function | None
    read_off: ReadOff | None

    def deviation(self, tau: Array) -> Array:
        """Allan deviation (k,)."""
        return np.sqrt(self.variance(tau))


def quantisation(coefficient: float, interval: float) -> NoiseTerm:
    """Quantisation Q (unit times s) of the integrated output, sampled every ``interval`` (s)."""
    q2 = coefficient**2
    return NoiseTerm(
        "Q",
        "quantisation",
        "−1",
        coefficient,
        lambda tau: 3.0 * q2 / tau**2,
        lambda f: np.where(
            f <= 0.5 / interval, 4.0 * q2 / interval * np.sin(np.pi * f * interval) ** 2, 0.0
        ),
        ReadOff(math.sqrt(3.0), 1.0),
    )


def white(coefficient: float) -> NoiseTerm:
    """White noise N: Eqs. (3.13) and (3.14)."""
    n2 = coefficient**2
    return NoiseTerm(
        "N",
        "white noise",
        "−1/2",
        coefficient,
        lambda tau: n2 / tau,
        lambda f: np.full_like(f, n2),
        ReadOff(1.0, 1.0),
    )


def flicker(coefficient: float, cutoff: float = math.inf) -> NoiseTerm:
    """Bias instability B up to the frequency ``cutoff`` (Hz): Eqs. (3.15) and (3.16)."""
    b2 = coefficient**2
    # Far beyond the cut-off's time the floor is reached to 1 in 1e4.
    plateau = 100.0 / cutoff if math.isfinite(cutoff) else 1.0
    return NoiseTerm(
        "B",
        "bias instability",
        "0",
        coefficient,
        lambda tau: b2 * flicker_variance(tau, cutoff),
        lambda f: np.where(f <= cutoff, b2 / (2.0 * np.pi * f), 0.0),
        ReadOff(plateau, FLOOR),
    )


def random_walk(coefficient: float) -> NoiseTerm:
    """Random walk of the output, K: Eqs. (3.17) and (3.18)."""
    k2 = coefficient**2
    return NoiseTerm(
        "K",
        "random walk",
        "+1/2",
        coefficient,
        lambda tau: k2 * tau / 3.0,
        lambda f: k2 / (2.0 * np.pi * f) ** 2,
        ReadOff(3.0, 1.0),
    )


def ramp(coefficient: float) -> NoiseTerm:
    """A steady drift R (unit per s)."""
    return NoiseTerm(
        "R",
        "ramp",
        "+1",
        coefficient,
        lambda tau: (coefficient * tau) ** 2 / 2.0,
        None,
        ReadOff(math.sqrt(2.0), 1.0),
    )


def gauss_markov(model: GaussMarkov) -> NoiseTerm:
    """A Gauss-Markov process: Eqs. (3.19) and (3.20); its coefficient is qc."""
    qc = math.sqrt(2.0 / model.correlation_time) * model.deviation
    return NoiseTerm(
        "GM",
        "Gauss-Markov process",
        "+1/2, then −1/2",
        qc,
        model.allan_variance,
        model.density,
        ReadOff(PEAK_TIME * model.correlation_time, PEAK_LEVEL * math.sqrt(model.correlation_time)),
    )


def sinusoid(amplitude: float, frequency: float) -> NoiseTerm:
    """A sinusoid (Hz): its power stands in one line, of which a quarter A² on each side."""

    def variance(tau: Array) -> Array:
        x = np.pi * frequency * tau
        return np.asarray((amplitude * np.sin(x) ** 2 / x) ** 2)

    # Of sin² x / x the largest value, 0.7246, lies at tan x = 2 x.
    return NoiseTerm(
        "S",
        "sinusoid",
        "+1, then −1",
        amplitude,
        variance,
        None,
        ReadOff(1.165561 / (math.pi * frequency), 0.724611),
    )


def flicker_variance(tau: Array, cutoff: float = math.inf) -> Array:
    """Allan variance (k,) of flicker noise of B = 1 below ``cutoff`` (Hz): Eq. (3.16).

    The thesis prints ``sin x + 3 x cos x``.  IEEE Std 952 has ``4 x``, and so has the integral of
    Eq. (3.12): with 3 the variance of short clusters would be twice too large.
    """
    from scipy.special import sici

    if math.isinf(cutoff):
        return np.full_like(tau, FLOOR**2)
    x = np.pi * cutoff * tau
    series = x**2 / 2.0 - x**4 / 6.0
    x = np.maximum(x, _SMALL / 2.0)
    exact = (
        math.log(2.0)
        - np.sin(x) ** 3 / (2.0 * x**2) * (np.sin(x) + 4.0 * x * np.cos(x))
        + sici(2.0 * x)[1]
        - sici(4.0 * x)[1]
    )
    return np.asarray(2.0 / np.pi * np.where(np.pi * cutoff * tau < _SMALL, series, exact))


def total_variance(terms: Sequence[NoiseTerm], tau: Array) -> Array:
    """Allan variance (k,) of independent terms together: Eq. (3.23)."""
    return np.sum([term.variance(tau) for term in terms], axis=0)


def total_density(terms: Sequence[NoiseTerm], frequency: Array) -> Array:
    """Two-sided density (k,) of those terms that have one."""
    found = [term.density(frequency) for term in terms if term.density is not None]
    return np.sum(found, axis=0) if found else np.zeros_like(frequency)
