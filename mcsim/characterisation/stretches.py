"""Two stretches of one log compared: level, deviation and N, each with a test.

A level wanders by itself.  How far two means may lie apart follows from the noise that was fitted
to both stretches, flicker and random walk included; a t test of the samples would call every
drift a change.  Slow terms that chance puts into a fit would hide what has changed: both stretches
share one set of terms, the one that the misfit and a price for each term call best.

Of 80 logs of a kind (130 s at 100 Hz, compared without five of them; σ 0.02) the level's
uncertainty lies within 30 % of the truth in 91 % with white noise alone; in the others it is up
to eight times too large.  False alarms at the 5 % level are 5 % there, 8 % with flicker (B 1e-3)
and 11 % with a random walk (K 1e-3); with all fitted terms they were 4, 1 and 16 %.  What clusters
within the stretches do not show stays unseen: with K 1e-4 25 % of 40 logs, formerly 15 %.

The deviation is that of windows of a second, whose logarithms of the variance Welch's t test
compares; N has the intervals of its fits.  Of several tests the p are Holm's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.analysis import ChannelResult, Characterisation
from mcsim.characterisation.fit import NoiseFit
from mcsim.characterisation.log_curve import Candidate
from mcsim.characterisation.problem import B, K, N
from mcsim.characterisation.process import GaussMarkovFit
from mcsim.logs.model import ACCELEROMETER

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: What is called changed is so by chance this often, of all tests together.
LEVEL_OF_TEST = 0.01
#: Price of a term in χ².  With Akaike's 2 every sixth log of white noise has slow terms; with 4
#: every fourth of weak flicker has none.
_FOR_A_TERM = 2.5
#: Windows of the deviation: seconds, and the fewest samples.
_WINDOW, _FEWEST = 1.0, 50
#: 95 % of a normal distribution.
_NORMAL = 1.959963984540054
#: Of a sample and of N, by whether it is an acceleration.
_UNITS = {True: ("m/s^2", "m/s^1.5"), False: ("rad/s", "rad/s^0.5")}


@dataclass(frozen=True)
class NoiseModel:
    """Q², N², B², K², R² (5,) without a process."""

    model_squares: Array
    gauss_markov: GaussMarkovFit | None = None


@dataclass(frozen=True)
class Change:
    """A quantity of a channel before and after: values, standard uncertainty of the change, p.

    ``quantity`` is ``level``, ``deviation`` or ``N``; values and uncertainty are in ``unit``.  The
    p of the last two is that of the logarithm of their ratio.
    """

    channel: str
    quantity: str
    unit: str
    before: float
    after: float
    uncertainty: float
    p: float


def changes(before: Characterisation, after: Characterisation, gap: float) -> list[Change]:
    """Channel by channel; ``gap`` (s) lies between the two.  ``p`` of the single tests."""
    lengths = before.log.duration, gap, after.log.duration
    return [
        change
        for first, second in zip(before.channels, after.channels, strict=True)
        for change in (
            _level(first, second, lengths),
            _deviation(first, second, before.log.rate),
            _white(first, second),
        )
    ]


def adjusted(found: Sequence[Change]) -> list[float]:
    """Holm's p: of n tests the least is taken n times, the next n - 1 times, and so on."""
    order = np.argsort([change.p for change in found])
    result, largest = [1.0] * len(found), 0.0
    for rank, k in enumerate(order):
        largest = max(largest, min(1.0, (len(found) - rank) * found[k].p))
        result[k] = largest
    return result


def mean_difference(fit: NoiseModel | NoiseFit, first: float, gap: float, second: float) -> float:
    """Variance of the difference of two means of the fitted noise, in SI units squared.

    Over ``first`` and ``second`` s with ``gap`` s between them.  With F'' the autocovariance (of
    flicker and random walk that which only differences have), a mean over T has the variance
    2 F(T) / T², and two have the covariance of F's second difference.
    """
    times = np.array([first, second, gap + first + second, gap + first, gap + second, gap])
    one, two, whole, left, right, between = _twice_integrated(fit, times)
    together = (whole - left - right + between) / (first * second)
    return float(2.0 * one / first**2 + 2.0 * two / second**2 - 2.0 * together)


def _twice_integrated(fit: NoiseModel | NoiseFit, times: Array) -> Array:
    squares, process = fit.model_squares, fit.gauss_markov
    logarithm = np.log(np.where(times > 0.0, times, 1.0))
    total = squares[N] * times / 2.0 - squares[K] * times**3 / 12.0
    total -= squares[B] / np.pi * times**2 * (logarithm / 2.0 - 0.75)
    if process is not None:
        tc = process.model.correlation_time
        slow = times / tc + np.expm1(-times / tc)
        total += (process.model.deviation * tc) ** 2 * slow
    return np.asarray(total)


def _level(first: ChannelResult, second: ChannelResult, lengths: tuple[float, ...]) -> Change:
    before, after = (float(r.channel.samples.mean()) for r in (first, second))
    models = _needed(first.fit, second.fit)
    variance = 0.5 * sum(mean_difference(model, *lengths) for model in models)
    u = math.sqrt(max(variance, 0.0))
    return Change(*_named(first, "level"), before, after, u, _normal_p(after - before, u))


def _needed(first: NoiseFit, second: NoiseFit) -> list[NoiseModel | NoiseFit]:
    """A model of each stretch: its process, or those of its terms that the two stretches need."""
    pairs = list(zip(first.comparison.sums, second.comparison.sums, strict=True))
    best = min(pairs, key=lambda pair: _criterion(*pair))
    return [
        NoiseModel(terms.squares) if fit.gauss_markov is None else fit
        for fit, terms in zip((first, second), best, strict=True)
    ]


def _criterion(first: Candidate, second: Candidate) -> float:
    return first.chi_square + second.chi_square + _FOR_A_TERM * first.parameters


def _deviation(first: ChannelResult, second: ChannelResult, rate: float) -> Change:
    from scipy.stats import ttest_ind

    size = int(max(_WINDOW * rate, _FEWEST))
    variances = [_windows(r.channel.samples, size).var(axis=1, ddof=1) for r in (first, second)]
    values = [math.sqrt(float(v.mean())) for v in variances]
    logarithms = [0.5 * np.log(np.maximum(v, 1e-300)) for v in variances]
    p = float(ttest_ind(*logarithms, equal_var=False).pvalue)
    relative = [math.sqrt(float(x.var(ddof=1)) / len(x)) for x in logarithms]
    return Change(*_named(first, "deviation"), values[0], values[1], _absolute(values, relative), p)


def _windows(samples: Array, size: int) -> Array:
    count = len(samples) // size
    return samples[: count * size].reshape(count, size)


def _white(first: ChannelResult, second: ChannelResult) -> Change:
    found = first.fit["N"], second.fit["N"]
    values = [c.value for c in found]
    relative = [(c.high - c.low) / (2.0 * _NORMAL * c.value) for c in found]
    p = _normal_p(math.log(values[1] / values[0]), math.hypot(*relative))
    return Change(*_named(first, "N"), values[0], values[1], _absolute(values, relative), p)


def _absolute(values: Sequence[float], relative: Sequence[float]) -> float:
    """Of the difference of two values with relative uncertainties."""
    return math.hypot(*(x * u for x, u in zip(values, relative, strict=True)))


def _named(result: ChannelResult, quantity: str) -> tuple[str, str, str]:
    """Channel, quantity and its SI unit."""
    sample, white = _UNITS[result.channel.element == ACCELEROMETER]
    return result.channel.name, quantity, white if quantity == "N" else sample


def _normal_p(error: float, u: float) -> float:
    from scipy.special import erfc

    return float(erfc(abs(error) / u / math.sqrt(2.0))) if u > 0.0 else float(error == 0.0)


def least_shown(found: Sequence[Change]) -> dict[str, float]:
    """Smallest change of level, by unit, that Holm's test would have shown in each channel of it.

    The least p of n tests is taken n times: 2.9 u of three, 3.5 u of eighteen.
    """
    from scipy.special import ndtri

    far = -float(ndtri(LEVEL_OF_TEST / (2.0 * len(found))))
    levels = [change for change in found if change.quantity == "level"]
    return {
        unit: far * max(c.uncertainty for c in levels if c.unit == unit)
        for unit in dict.fromkeys(c.unit for c in levels)
    }


def change_table(found: Sequence[Change]) -> pd.DataFrame:
    """Columns channel, quantity, unit, before, after, u_of_change, p, p_holm, changed."""
    import pandas as pd

    holm = adjusted(found)
    return pd.DataFrame(
        {
            "channel": [c.channel for c in found],
            "quantity": [c.quantity for c in found],
            "unit": [c.unit for c in found],
            "before": [c.before for c in found],
            "after": [c.after for c in found],
            "u_of_change": [c.uncertainty for c in found],
            "p": [c.p for c in found],
            "p_holm": holm,
            "changed": [p < LEVEL_OF_TEST for p in holm],
        }
    )
