"""The filter that tracks a first-order Gauss-Markov bias in white noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel

Array = NDArray[np.float64]


@kernel
def track(samples: Array, decay: float, deviation: float, noise: float, estimates: Array) -> None:
    """Kalman filter with the Gauss-Markov state, Eq. (3.34) and (3.35).

    ``samples`` (n,), ``noise`` standard deviation of one sample, ``estimates`` (n,) after
    each sample, written.  It begins with the process's own mean 0 and deviation.
    """
    drive = deviation * deviation * (1.0 - decay * decay)
    x = 0.0
    p = deviation * deviation
    for k in range(samples.shape[0]):
        if k > 0:
            x = decay * x
            p = decay * decay * p + drive
        gain = p / (p + noise * noise)
        x += gain * (samples[k] - x)
        p *= 1.0 - gain
        estimates[k] = x
