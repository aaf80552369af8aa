"""Autocorrelation of a log and of its bias, with the band that chance makes of none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: 95 % of a normal distribution lie within so many deviations.
_NORMAL = 1.959963984540054
#: Longer logs are looked at in pieces of so many samples.
_PIECE = 1 << 21
#: Lags per decade that are kept.
_PER_DECADE = 25


@dataclass(frozen=True)
class Autocorrelation:
    """Autocorrelation ``values`` (k,) at ``lags`` (k,) in s, and ``band`` (k,).

    Within ± ``band`` lie 95 % of the values of a series whose correlation ends before that lag
    (Bartlett 1946).  ``variance`` is that at lag 0.
    """

    lags: Array
    values: Array
    band: Array
    variance: float


def autocovariance(values: Array, longest: int | None = None) -> Array:
    """Biased autocovariance of values (n,) less their mean; lags 0 to n - 1, or to ``longest``."""
    from scipy.fft import irfft, next_fast_len, rfft

    n = len(values)
    lags = n if longest is None else min(longest + 1, n)
    length = next_fast_len(n + lags, real=True)
    spectrum = rfft(values - values.mean(), length)
    return np.asarray(irfft(np.abs(spectrum) ** 2, length)[:lags] / n)


def autocorrelation_of(
    values: Array, interval: float, shortest: int, longest: int
) -> Autocorrelation:
    """At some of the lags from ``shortest`` to ``longest`` intervals (s) of values (n,).

    Values that are longer than two million samples are taken in pieces; lags must be much shorter
    than these.
    """
    n = len(values)
    pieces = np.array_split(values - values.mean(), max(1, n // _PIECE))
    covariance = np.asarray(
        np.mean([_about_zero(piece, longest) for piece in pieces], axis=0), dtype=np.float64
    )
    correlation = covariance / covariance[0]
    # Sums over the lags below each one.
    squares = np.cumsum(correlation**2)
    places = _places(shortest, len(correlation) - 1)
    band = _NORMAL * np.sqrt((2.0 * squares[places - 1] - 1.0) / n)
    return Autocorrelation(
        places * interval, np.asarray(correlation[places]), np.asarray(band), float(covariance[0])
    )


def _about_zero(values: Array, longest: int) -> Array:
    """Autocovariance of a piece about the mean of the whole."""
    mean = float(values.mean())
    return autocovariance(values, longest) + mean**2


def _places(shortest: int, longest: int) -> NDArray[np.int64]:
    """Lags on a logarithmic scale, each once."""
    count = max(2, int(np.log10(max(longest / shortest, 1.0)) * _PER_DECADE))
    places = np.geomspace(shortest, max(longest, shortest), count)
    return np.unique(np.round(places).astype(np.int64))
