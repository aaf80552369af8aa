"""Two stretches of one log compared: level, deviation and N, each with a test.

A level wanders by itself.  How far two means may lie apart follows from the noise that was fitted
to both stretches, flicker and random walk included; a t test of the samples would call every
drift a change.  The deviation is that of windows of a second, whose logarithms of the variance
Welch's t test compares; N has the intervals of its fits.  Of several tests the p are Holm's.
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
from mcsim.characterisation.problem import B, K, N

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: What is called changed is so by chance this often, of all tests together.
LEVEL_OF_TEST = 0.01
#: Windows of the deviation: seconds, and the fewest samples.
_WINDOW, _FEWEST = 1.0, 50
#: 95 % of a normal distribution.
_NORMAL = 1.959963984540054


@dataclass(frozen=True)
class Change:
    """A quantity of a channel before and after: values, standard uncertainty of the change, p.

    ``quantity`` is ``level``, ``deviation`` or ``N``, in SI units; the uncertainty of the last two
    is that of the logarithm of their ratio.
    """

    channel: str
    quantity: str
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


def mean_difference(fit: NoiseFit, first: float, gap: float, second: float) -> float:
    """Variance of the difference of two means of the fitted noise, in SI units squared.

    Over ``first`` and ``second`` s with ``gap`` s between them.  With F'' the autocovariance (of
    flicker and random walk that which only differences have), a mean over T has the variance
    2 F(T) / T², and two have the covariance of F's second difference.
    """
    times = np.array([first, second, gap + first + second, gap + first, gap + second, gap])
    one, two, whole, left, right, between = _twice_integrated(fit, times)
    together = (whole - left - right + between) / (first * second)
    return float(2.0 * one / first**2 + 2.0 * two / second**2 - 2.0 * together)


def _twice_integrated(fit: NoiseFit, times: Array) -> Array:
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
    variance = 0.5 * sum(mean_difference(r.fit, *lengths) for r in (first, second))
    return _change(first, "level", (before, after), after - before, math.sqrt(max(variance, 0.0)))


def _deviation(first: ChannelResult, second: ChannelResult, rate: float) -> Change:
    from scipy.stats import ttest_ind

    size = int(max(_WINDOW * rate, _FEWEST))
    variances = [_windows(r.channel.samples, size).var(axis=1, ddof=1) for r in (first, second)]
    values = [math.sqrt(float(v.mean())) for v in variances]
    logarithms = [0.5 * np.log(np.maximum(v, 1e-300)) for v in variances]
    p = float(ttest_ind(*logarithms, equal_var=False).pvalue)
    u = math.sqrt(sum(float(x.var(ddof=1)) / len(x) for x in logarithms))
    return Change(first.channel.name, "deviation", values[0], values[1], u, p)


def _windows(samples: Array, size: int) -> Array:
    count = len(samples) // size
    return samples[: count * size].reshape(count, size)


def _white(first: ChannelResult, second: ChannelResult) -> Change:
    before, after = first.fit["N"], second.fit["N"]
    spreads = [(c.high - c.low) / (2.0 * _NORMAL * c.value) for c in (before, after)]
    ratio = math.log(after.value / before.value)
    return _change(first, "N", (before.value, after.value), ratio, math.hypot(*spreads))


def _change(
    result: ChannelResult, quantity: str, values: tuple[float, float], error: float, u: float
) -> Change:
    from scipy.special import erfc

    p = float(erfc(abs(error) / u / math.sqrt(2.0))) if u > 0.0 else float(error == 0.0)
    return Change(result.channel.name, quantity, *values, u, p)


def change_table(found: Sequence[Change]) -> pd.DataFrame:
    """Columns channel, quantity, before, after, u, p, p_holm, changed; SI units."""
    import pandas as pd

    holm = adjusted(found)
    return pd.DataFrame(
        {
            "channel": [c.channel for c in found],
            "quantity": [c.quantity for c in found],
            "before": [c.before for c in found],
            "after": [c.after for c in found],
            "u_of_change": [c.uncertainty for c in found],
            "p": [c.p for c in found],
            "p_holm": holm,
            "changed": [p < LEVEL_OF_TEST for p in holm],
        }
    )
