"""Limited bandwidth: the signals of a drive behind each channel's low-pass."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.sensor_terms.mechanisms import low_pass
from mcsim.sensors.sampling import IIR_HALF_LENGTH, Signals, oversampling

Array = NDArray[np.float64]

#: Least number of steps per sensor sample that the filter works on.
_FEWEST_STEPS = 8


def behind_low_pass(
    signals: Signals, bandwidths: tuple[float, ...], start: float, rate: float, count: int
) -> Signals:
    """The signals behind a low-pass of -3 dB at each channel's bandwidth (Hz), with its delay.

    ``signals`` are as in ``mcsim.sensors.sampling.sample``; the filter starts settled, as far
    before sample 0 as any decimation looks.  Channels of infinite bandwidth pass unchanged.
    """
    step = 1.0 / (rate * max(oversampling(rate), _FEWEST_STEPS))
    reach = (IIR_HALF_LENGTH + 1) / rate
    times = np.arange(start - reach, start + count / rate + reach + step, step)
    dense = signals(times, step)
    filtered = np.stack(
        [low_pass.filtered(channel, f, step) for channel, f in zip(dense, bandwidths, strict=True)]
    )

    def after(t: Array, width: float | Array) -> Array:
        unchanged = signals(t, width)
        return np.stack(
            [
                np.interp(t, times, low) if np.isfinite(f) else same
                for low, same, f in zip(filtered, unchanged, bandwidths, strict=True)
            ]
        )

    return after
