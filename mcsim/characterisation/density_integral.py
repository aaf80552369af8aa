"""From a power spectral density to its Allan variance: the integral of Eq. (3.12)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Nodes of Gauss's rule per cell, cells per decade of x = πfτ where the weight is smooth.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_PER_DECADE = 20
#: Cells per half period of the weight, and the half periods after which its mean stands for it:
#: what oscillates there is below 1e-6 of the integral of white noise.
_CELLS, _PERIODS = 8, 200
#: Ends of the integral in x, where a density goes on for ever.
_LEAST, _MOST = 1e-9, 1e9
#: Points of an end of a table that its slope is taken from: a third of a decade.
_END = 10.0 ** (1.0 / 3.0)


@dataclass(frozen=True)
class TabulatedDensity:
    """A density between its points, a power law from each to the next.

    ``frequency`` (k,) in Hz, ascending and above zero, ``density`` (k,) two-sided and above zero.
    """

    frequency: Array
    density: Array

    @property
    def band(self) -> tuple[float, float]:
        """First and last frequency (Hz)."""
        return float(self.frequency[0]), float(self.frequency[-1])

    @property
    def slopes(self) -> tuple[float, float]:
        """Exponent of the frequency over the first and the last third of a decade."""
        f, s = np.log(self.frequency), np.log(self.density)
        reach = math.log(_END)
        ends = f <= max(f[0] + reach, f[1]), f >= min(f[-1] - reach, f[-2])
        first, last = (float(np.polyfit(f[end], s[end], 1)[0]) for end in ends)
        return first, last

    def __call__(self, frequency: Array) -> Array:
        """Inside of the band; the outermost value beyond."""
        return np.exp(np.interp(np.log(frequency), np.log(self.frequency), np.log(self.density)))

    def continued(self) -> Callable[[Array], Array]:
        """The density with both ends continued by the power laws that they follow."""
        (low, high), (first, last) = self.band, self.slopes

        def density(frequency: Array) -> Array:
            below = np.minimum(frequency / low, 1.0) ** first
            above = np.maximum(frequency / high, 1.0) ** last
            return self(frequency) * below * above

        return density


def allan_from_density(
    density: Callable[[Array], Array],
    tau: Array,
    band: tuple[float, float] = (0.0, math.inf),
    points: Array | None = None,
    interval: float = 0.0,
) -> Array:
    """Allan variance (k,) of a two-sided density: ``4 ∫ S(f) sin⁴(πfτ) / (πfτ)² df``.

    Parameters
    ----------
    density : callable
        Frequencies (n,) in Hz to the two-sided density.
    tau : float64 (k,)
        Cluster times in s.
    band : (float, float)
        Where it is integrated, in Hz.
    points : float64 (m,), optional
        Frequencies at which the density has a kink or a step.
    interval : float
        Of samples (s): the weight is then that of clusters of samples, ``sin⁴(πfτ)`` over
        ``(n sin(πf interval))²``, which is exact for a log whose density is that of its samples.
        0 for Eq. (3.12) itself, clusters of a continuous signal.
    """
    kinks = np.empty(0) if points is None else points
    return np.array([_integral(density, float(t), band, kinks, interval) for t in tau])


def _integral(
    density: Callable[[Array], Array],
    tau: float,
    band: tuple[float, float],
    points: Array,
    interval: float,
) -> float:
    scale = math.pi * tau
    low, high = max(band[0] * scale, _LEAST), min(band[1] * scale, _MOST)
    if low >= high:
        return 0.0
    edges = np.concatenate([[low, high], _grid(), points * scale])
    edges = np.unique(edges[(edges >= low) & (edges <= high)])
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    x = middle[:, None] + half[:, None] * _NODES
    wave = np.where(x < _PERIODS * math.pi, np.sin(np.minimum(x, _PERIODS * math.pi)) ** 4, 0.375)
    values = density((x / scale).ravel()).reshape(x.shape) * wave / x**2
    if interval:
        angle = x / scale * math.pi * interval
        values *= (angle / np.sin(angle)) ** 2
    return float(4.0 / scale * np.sum(values * _WEIGHTS * half[:, None]))


def _grid() -> Array:
    """Edges of cells in x = πfτ, fine enough for the weight and for power laws."""
    turn = _PERIODS * math.pi
    return np.concatenate(
        [
            np.geomspace(_LEAST, 1.0, 9 * _PER_DECADE),
            np.arange(1, _PERIODS * _CELLS + 1) * (math.pi / _CELLS),
            np.geomspace(turn, _MOST, 7 * _PER_DECADE),
        ]
    )
