"""A warm-up: an output that settles, a exp(-t/T), beside noise that wanders too.

Means of equal blocks are explained by white noise, flicker and random walk of any mix, with and
without a settling or a straight line (generalised least squares; the mix is that of the largest
likelihood for each).  A settling must be far more likely than the noises alone, which also
drift, and than a straight line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.health.record import SHORTEST, Finding, Record

Array = NDArray[np.float64]

#: Block means of a log; at least so many samples to each.
_BLOCKS, _FEWEST = 96, 8
#: Powers of flicker and random walk beside white noise of one, at the length of a block.
_POWERS = (0.0, *(10.0**e for e in np.arange(-2.0, 3.1, 0.5)))
#: Settling times as parts of the log.
_TIMES = np.geomspace(0.02, 0.7, 24)
#: Twice the logarithm of the likelihoods' ratio that shows a settling against noises alone, and
#: against a straight line: noise alone reaches 15 and 11 in 1500 logs of all mixes.
_AGAINST_NOISE, _AGAINST_A_LINE = 20.0, 8.0
#: What may remain of a settling, as a part of the least Allan deviation.
_SETTLED = 0.3
_LEAST_REST = 1e-12
#: The part of a log that must be left after a warm-up for the advice to cut it off.
_ENOUGH = 0.3


@dataclass(frozen=True)
class WarmUp:
    """``size`` (SI) at the beginning of the log, and ``time`` constant (s)."""

    size: float
    time: float

    def output(self, samples: int, rate: float) -> Array:
        """The settling (n,) at every sample, its mean taken off."""
        values = self.size * np.exp(-np.arange(samples) / (rate * self.time))
        return values - values.mean()

    def over_after(self, least_deviation: float) -> float:
        """Time (s) after which no more is left of it than a part of an Allan deviation."""
        return self.time * float(np.log(max(abs(self.size) / (_SETTLED * least_deviation), 1.0)))


def find_warm_up(samples: Array, rate: float) -> WarmUp | None:
    """The settling of a log (n,), if it clearly holds one."""
    size = len(samples) // _BLOCKS
    if size < _FEWEST:
        return None
    used = samples[: size * _BLOCKS]
    means = used.reshape(_BLOCKS, size).mean(axis=1)
    differences = np.diff(means)
    if not np.any(differences):
        return None
    at = (np.arange(_BLOCKS) + 0.5) / _BLOCKS
    shapes = [at, *(np.exp(-at / time) for time in _TIMES)]
    alone, explained = _likelihoods(differences, np.diff(np.array(shapes), axis=1))
    best = int(np.argmax(explained[1:]))
    gain = explained[1 + best] - alone
    if gain < _AGAINST_NOISE or explained[1 + best] - explained[0] < _AGAINST_A_LINE:
        return None
    time = _TIMES[best]
    amount = _amount(differences, np.diff(shapes[1 + best]))
    duration = size * _BLOCKS / rate
    return WarmUp(amount, float(time * duration))


@lru_cache(maxsize=1)
def _whitenings() -> tuple[Array, Array]:
    """Of every mix the factor (w, m, m) that makes differences of means independent.

    And the logarithm (w,) of the covariance's determinant.
    """
    from scipy.linalg import solve_triangular, toeplitz

    lag = np.arange(-2.0, _BLOCKS + 1.0)
    size = np.abs(lag)
    logarithm = np.log(np.where(size > 0.0, size, 1.0))
    integrals = (-0.5 * size, size**2 * logarithm / (2.0 * np.pi), size**3 / 12.0)
    parts = []
    for integral in integrals:
        # Autocovariance of the integral, of the means, of their differences.
        of_differences = np.diff(integral, 4)
        parts.append(toeplitz(of_differences[: _BLOCKS - 1]))
    factors, determinants = [], []
    for flicker, walk in product(_POWERS, _POWERS):
        root = np.linalg.cholesky(parts[0] + flicker * parts[1] + walk * parts[2])
        factors.append(solve_triangular(root, np.eye(len(root)), lower=True))
        determinants.append(2.0 * np.log(np.diagonal(root)).sum())
    return np.array(factors), np.array(determinants)


def _whitened(differences: Array, shapes: Array) -> tuple[Array, Array, Array]:
    """Differences (w, m) and shapes (w, m, s) under every mix, logarithms of determinants (w,)."""
    factors, determinants = _whitenings()
    return factors @ differences, factors @ shapes.T, determinants


def _likelihoods(differences: Array, shapes: Array) -> tuple[float, Array]:
    """Twice the logarithm of the largest likelihood: of noise alone, and with each shape (s,)."""
    values, columns, determinants = _whitened(differences, shapes)
    whole = np.sum(values**2, axis=1)
    projected = np.einsum("wm,wms->ws", values, columns)
    rest = whole[:, None] - projected**2 / np.sum(columns**2, axis=1)
    # Of a log without noise a shape may explain everything.
    rest = np.maximum(rest, _LEAST_REST * whole[:, None])
    m = values.shape[1]
    alone = -m * np.log(whole) - determinants
    explained = -m * np.log(rest) - determinants[:, None]
    return float(alone.max()), np.asarray(explained.max(axis=0))


def _amount(differences: Array, shape: Array) -> float:
    """Amount of a shape under the mix that makes it likeliest."""
    values, columns, determinants = _whitened(differences, shape[None, :])
    column = columns[..., 0]
    amount = np.sum(values * column, axis=1) / np.sum(column**2, axis=1)
    rest = np.sum((values - amount[:, None] * column) ** 2, axis=1)
    rest = np.maximum(rest, _LEAST_REST * np.sum(values**2, axis=1))
    best = np.argmax(-values.shape[1] * np.log(rest) - determinants)
    return float(amount[best])


def check_warm_up(record: Record) -> tuple[WarmUp | None, list[Finding]]:
    """The warm-up of a channel, and a sentence about it with the cut that leaves it out."""
    from mcsim.characterisation.allan import allan_curve

    found = find_warm_up(record.samples, record.rate)
    if found is None:
        return None, []
    n = len(record.samples)
    rest = record.samples - found.output(n, record.rate)
    least = float(allan_curve(rest, record.rate, _octaves(n)).deviation.min())
    over, duration = found.over_after(least), n / record.rate
    left = duration - over
    if left > max(SHORTEST, _ENOUGH * duration):
        advice = f"--start {math.ceil(over)} leaves it out"
    else:
        advice = f"it is over after {over:.3g} s only: log again once it has settled"
    text = (
        f"the output settles by {record.written(-found.size)} with a time constant of "
        f"{found.time:.3g} s (warm-up); the fit goes without it; {advice}"
    )
    return found, [Finding("warm-up", record.name, text)]


def _octaves(samples: int) -> NDArray[np.int64]:
    """Cluster sizes in octaves up to a tenth of the log."""
    return 2 ** np.arange(max(1, int(np.log2(samples / 10.0))), dtype=np.int64)
