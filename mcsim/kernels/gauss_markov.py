"""A first-order Gauss-Markov bias in white noise: the process and the filter that tracks it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel

Array = NDArray[np.float64]


@kernel
def gauss_markov(normals: Array, decay: float, deviation: float, process: Array) -> None:
    """Eq. (3.27): x_k = decay x_(k-1) + w_k, stationary from the first sample on.

    ``normals`` (n,) of variance 1, ``decay`` e^(-dt/Tc), ``process`` (n,), written.
    """
    drive = deviation * np.sqrt(1.0 - decay * decay)
    x = deviation * normals[0]
    process[0] = x
    for k in range(1, normals.shape[0]):
        x = decay * x + drive * normals[k]
        process[k] = x


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
