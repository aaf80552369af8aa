"""Allan variance of millions of samples, and the covariance of such estimates."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel, scalar

Array = NDArray[np.float64]

#: Noise terms whose covariance is known: quantisation, white, flicker, random walk.
NOISES = 4
#: Steps of the lag per shorter cluster time.
_STEPS = 8
#: Lags are summed up to this multiple of the two cluster times together.
_REACH = 5.0
#: Estimates whose cluster times differ by more than this factor count as independent.
_FARTHEST = 1024.0


@kernel
def squares_of_stretches(
    phase: Array, factors: NDArray[np.int64], edges: NDArray[np.int64], squares: Array
) -> None:
    """Sums of half the squared second differences of Eq. (3.11), stretch by stretch.

    Parameters
    ----------
    phase : float64 (samples + 1,)
        Running sum of the samples, beginning with 0.
    factors : int64 (k,)
        Samples per cluster, at most half of the samples; clusters begin at every sample.
    edges : int64 (s + 1,)
        Ends of the stretches in ``phase``; a difference belongs to the stretch of its middle.
    squares : float64 (k, s), written
        In the samples' unit, squared; summed up and divided by their number they are the
        Allan variance.
    """
    samples = phase.shape[0] - 1
    # Stretch by stretch, so that the phases of short clusters stay in the processor's cache.
    for s in range(edges.shape[0] - 1):
        for j in range(factors.shape[0]):
            n = factors[j]
            low = max(0, edges[s] - n)
            high = max(low, min(samples - 2 * n + 1, edges[s + 1] - n))
            total = _squares(
                phase[low:high], phase[low + n : high + n], phase[low + 2 * n : high + 2 * n]
            )
            squares[j, s] = total / (2.0 * float(n) * float(n))


@kernel
def separate_variances(phase: Array, factors: NDArray[np.int64], variances: Array) -> None:
    """Eq. (3.11) with clusters that begin where the last one ended.

    ``phase`` and ``factors`` as above, ``variances`` (k,) in the samples' unit squared, written.
    """
    samples = phase.shape[0] - 1
    for j in range(factors.shape[0]):
        n = factors[j]
        count = samples // n - 1
        total = 0.0
        for i in range(count):
            d = phase[(i + 2) * n] - 2.0 * phase[(i + 1) * n] + phase[i * n]
            total += d * d
        variances[j] = total / (2.0 * float(n) * float(n) * count)


@scalar
def _squares(first, middle, last):
    """Sum of (first - 2 middle + last)^2; eight partial sums keep the processor busy."""
    count = first.shape[0]
    sums = np.zeros(8)
    whole = count - count % 8
    for i in range(0, whole, 8):
        for k in range(8):
            d = (first[i + k] - middle[i + k]) - (middle[i + k] - last[i + k])
            sums[k] += d * d
    total = 0.0
    for k in range(8):
        total += sums[k]
    for i in range(whole, count):
        d = (first[i] - middle[i]) - (middle[i] - last[i])
        total += d * d
    return total


@scalar
def _structure(noise, t, interval, step, time):
    """Generalised autocovariance of the integrated noise with coefficient 1 at lag t.

    ``time`` is the correlation time of a Gauss-Markov process of unit qc, noise 4.
    """
    t = abs(t)
    if noise == NOISES:
        x = t / time
        bounded = x - 1.0 + math.exp(-x) if x > 1e-4 else 0.5 * x * x
        return -0.5 * time * time * time * bounded
    if noise == 0:
        # Quantisation: white phase, one sample wide; its square keeps its integral.
        return math.sqrt(interval / step) if t < 0.5 * step else 0.0
    if noise == 1:  # white rate
        return -0.5 * t
    if noise == 2:  # flicker of the rate
        return t * t * math.log(t) / (2.0 * math.pi) if t > 0.0 else 0.0
    return t * t * t / 12.0  # random walk of the rate


@scalar
def _difference(noise, lag, a, b, interval, step, time):
    """Covariance of second differences over a and b whose centres are ``lag`` apart."""
    total = 0.0
    for p in range(-1, 2):
        for q in range(-1, 2):
            weight = (-2.0 if p == 0 else 1.0) * (-2.0 if q == 0 else 1.0)
            total += weight * _structure(noise, lag + q * b - p * a, interval, step, time)
    return total


@kernel
def allan_covariances(
    taus: Array, interval: float, length: float, products: Array, ramps: Array
) -> None:
    """Covariance of overlapping Allan variances of a Gaussian log of a given length.

    Greenhall and Riley (2003): the estimates are mean squares of second differences,
    whose covariances follow from generalised autocovariances.  With coefficients
    squared p = (Q², N², B², K²) and a rate ramp R::

        Cov(i, j) = Σ_ab p_a p_b products[a, b, i, j] + R² Σ_a p_a ramps[a, i, j]

    Parameters
    ----------
    taus : float64 (k,)
        Cluster times in s, ascending.
    interval, length : float
        Sampling interval and length of the log in s.
    products : float64 (NOISES, NOISES, k, k), written
    ramps : float64 (NOISES, k, k), written
    """
    products[:] = 0.0
    ramps[:] = 0.0
    c = np.empty(NOISES)
    for i in range(taus.shape[0]):
        a = taus[i]
        step = interval * max(1.0, math.floor(a / interval / _STEPS))
        for j in range(i, taus.shape[0]):
            b = taus[j]
            if b > _FARTHEST * a:
                break
            places = (length - 2.0 * a + interval) * (length - 2.0 * b + interval)
            scale = step / (2.0 * a * a * b * b * places)
            for s in range(int(min(length - a - b, _REACH * (a + b)) / step) + 1):
                lag = s * step
                overlap = min(length - b - lag - a, length - 2.0 * b) + interval
                weight = (1.0 if s == 0 else 2.0) * scale * overlap
                for u in range(NOISES):
                    c[u] = _difference(u, lag, a, b, interval, step, 1.0)
                for u in range(NOISES):
                    ramps[u, i, j] += weight * 2.0 * a * a * b * b * c[u]
                    for v in range(NOISES):
                        products[u, v, i, j] += weight * c[u] * c[v]
            for u in range(NOISES):
                ramps[u, j, i] = ramps[u, i, j]
                for v in range(NOISES):
                    products[u, v, j, i] = products[u, v, i, j]


@kernel
def process_covariance(
    taus: Array,
    interval: float,
    length: float,
    squares: Array,
    drive: float,
    time: float,
    covariance: Array,
) -> None:
    """As ``allan_covariances``, of one mix of noises and a Gauss-Markov process.

    Parameters
    ----------
    taus, interval, length
        As above.
    squares : float64 (NOISES,)
        Q², N², B², K²; a negative Q² is a filter's.
    drive, time : float
        qc² and correlation time (s) of the process.
    covariance : float64 (k, k), written
    """
    covariance[:] = 0.0
    for i in range(taus.shape[0]):
        a = taus[i]
        step = interval * max(1.0, math.floor(a / interval / _STEPS))
        for j in range(i, taus.shape[0]):
            b = taus[j]
            if b > _FARTHEST * a:
                break
            places = (length - 2.0 * a + interval) * (length - 2.0 * b + interval)
            scale = step / (2.0 * a * a * b * b * places)
            total = 0.0
            for s in range(int(min(length - a - b, _REACH * (a + b)) / step) + 1):
                lag = s * step
                overlap = min(length - b - lag - a, length - 2.0 * b) + interval
                weight = (1.0 if s == 0 else 2.0) * scale * overlap
                c = drive * _difference(NOISES, lag, a, b, interval, step, time)
                for u in range(NOISES):
                    if squares[u] != 0.0:
                        c += squares[u] * _difference(u, lag, a, b, interval, step, 1.0)
                total += weight * c * c
            covariance[i, j] = total
            covariance[j, i] = total
