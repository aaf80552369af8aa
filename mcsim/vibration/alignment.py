"""Clocks of several logs brought together by the cross-correlation of what they show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate, correlation_lags

from mcsim.errors import InputError
from mcsim.vibration.platform import Seen
from mcsim.vibration.processing import filters
from mcsim.vibration.scenario import Chain

Array = NDArray[np.float64]

#: Two logs that correlate less do not show the same.
_LEAST = 0.5


def aligned(seen: Sequence[Seen], base: Seen, chain: Chain) -> list[Seen]:
    """All on the clock of ``base``.

    Parameters
    ----------
    seen : sequence of Seen
    base : Seen
        Whose clock the others take; it may be one of them.
    chain : Chain
        Filters before the correlation; its moving average is left out.

    Raises
    ------
    InputError
        A log that correlates with the other by less than a half.
    """
    lags = [0.0 if one is base else _lag(base, one, chain) for one in seen]
    return [replace(one, time=one.time - lag, lag=lag) for one, lag in zip(seen, lags, strict=True)]


def in_common(seen: Sequence[Seen]) -> list[Seen]:
    """Only the stretch of time that all of them saw.

    Raises
    ------
    InputError
        Fewer than 64 samples of one of them.
    """
    first = max(float(one.time[0]) for one in seen)
    last = min(float(one.time[-1] + 1.0 / one.log.rate) for one in seen)
    return [one.between(first, last) for one in seen]


def _lag(base: Seen, other: Seen, chain: Chain) -> float:
    """How much later (s) on its own clock a log shows the same as the other."""
    rate = min(base.log.rate, other.log.rate)
    first, second = (_evenly(one, rate, chain) for one in (base, other))
    product = correlate(second, first, mode="full", method="fft")
    lags = correlation_lags(len(second), len(first), mode="full")
    peak = int(np.argmax(product))
    share = float(product[peak]) / float(np.linalg.norm(first) * np.linalg.norm(second))
    if share < _LEAST:
        raise InputError(
            f"--align: {other.name} correlates with {base.name} by {share:.2f} at most: they do "
            "not show the same, or with opposite signs; leave --align out, or cut them with "
            "--start and --end"
        )
    shift = (lags[peak] + _between(product, peak)) / rate
    return float(shift + other.time[0] - base.time[0])


def _evenly(seen: Seen, rate: float, chain: Chain) -> Array:
    """Filtered at its own rate, then at a common one."""
    # A moving average of an even number of samples is late by half a sample.
    steps = filters(chain.model_copy(update={"moving_average": 0}), seen.log.rate)
    filtered = steps.apply(seen.log.samples)[:, 0]
    own = seen.time - seen.time[0]
    return np.interp(np.arange(0.0, own[-1], 1.0 / rate), own, filtered)


def _between(values: Array, peak: int) -> float:
    """Where the parabola through a maximum and its neighbours has its own, in samples."""
    if not 0 < peak < len(values) - 1:
        return 0.0
    before, at, after = values[peak - 1 : peak + 2]
    return float(0.5 * (before - after) / (before - 2.0 * at + after))
