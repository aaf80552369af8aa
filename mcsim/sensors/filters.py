"""Mechanics and electronics before the samples: the signals of a drive behind each channel's
filters."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms.linear_filter import Filters, filtered
from mcsim.sensor_terms.mechanisms.resonance import Resonance
from mcsim.sensors.sampling import IIR_HALF_LENGTH, Signals, oversampling

Array = NDArray[np.float64]

#: Least number of steps per sensor sample that the filters work on.
_FEWEST_STEPS = 8
#: Steps per period of a resonance, which rings where a signal jumps, and most steps per sample.
_PER_PERIOD, _MOST_STEPS = 8, 64


def behind_filters(
    signals: Signals, filters: Sequence[Filters], start: float, rate: float, count: int
) -> Signals:
    """The signals behind each channel's filters, with their delays.

    ``signals`` are as in ``mcsim.sensors.sampling.sample``; filters start settled, as far
    before sample 0 as any decimation looks.  Channels without filters pass unchanged.
    """
    dense_rate = rate * _steps_per_sample(filters, rate)
    step = 1.0 / dense_rate
    reach = (IIR_HALF_LENGTH + 1) / rate
    times = np.arange(start - reach, start + count / rate + reach + step, step)
    dense = signals(times, step)
    behind = [
        filtered(channel, own, dense_rate) for channel, own in zip(dense, filters, strict=True)
    ]

    def after(t: Array, width: float | Array) -> Array:
        unchanged = signals(t, width)
        return np.stack(
            [
                np.interp(t, times, slow) if own else same
                for slow, same, own in zip(behind, unchanged, filters, strict=True)
            ]
        )

    return after


def _steps_per_sample(filters: Sequence[Filters], rate: float) -> int:
    steps = max(oversampling(rate), _FEWEST_STEPS)
    ringing = [one.fastest for own in filters for one in own if isinstance(one, Resonance)]
    if not ringing:
        return steps
    wanted = math.ceil(_PER_PERIOD * max(ringing) / rate)
    return max(steps, min(wanted, _MOST_STEPS))
