"""Static sensor noise made by methods that share nothing with the fit.

Flicker noise is Kasdin's (Proc. IEEE 83, 802, 1995): white noise through the exact
impulse response of (1 - z^-1)^(-1/2), by FFT. Random walk is a running sum.
"""

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

#: Tables 5.4 to 5.6: N in m/s/√h, B in m/s/h, K in m/s/h^1.5, for x, y, z.
THESIS = {
    "Xsens": ((0.0833, 1.4273, 4.052), (0.0852, 1.9474, 1.5527), (1.19599, 2.7729, 8.3062)),
    "MPU-9250": ((0.1277, 4.4881, 4.9431), (0.1274, 4.4140, 5.1879), (0.2565, 4.2605, 8.8999)),
    "LSM9DS1": ((0.0825, 1.7619, 2.1911), (0.0723, 1.6712, 2.8486), (0.0977, 2.3084, 4.8661)),
    "BNO055": ((0.0743, 0.8039, 1.866), (0.0840, 2.9657, 12.7052), (0.1032, 3.9984, 2.3612)),
    "LSM303": ((0.7554, 2.6671, 3.306), (0.8139, 4.2955, 6.7863), (0.8776, 6.7863, 14.4080)),
}


def in_si(coefficients):
    """N, B, K of the thesis's tables in SI units."""
    n, b, k = coefficients
    return n / 60.0, b / 3600.0, k / 3600.0**1.5


def flicker(n, rng):
    """Samples (n,) whose two-sided density is 1 / (2π f): bias instability 1."""
    k = np.arange(1.0, n)
    response = np.concatenate([[1.0], np.cumprod((k - 0.5) / k)])
    length = next_fast_len(2 * n, real=True)
    return irfft(rfft(response, length) * rfft(rng.standard_normal(n), length), length)[:n]


def static_noise(white, bias_instability, random_walk, rate, n, rng):
    """Samples (n,) at ``rate`` with Allan's N, B and K in SI units."""
    samples = white * np.sqrt(rate) * rng.standard_normal(n)
    if bias_instability:
        samples += bias_instability * flicker(n, rng)
    if random_walk:
        samples += random_walk / np.sqrt(rate) * np.cumsum(rng.standard_normal(n))
    return samples


def gauss_markov(correlation_time, deviation, rate, n, rng):
    """Samples (n,) of a stationary first-order process, by scipy's filter."""
    from scipy.signal import lfilter

    decay = np.exp(-1.0 / (rate * correlation_time))
    drive = deviation * np.sqrt(1.0 - decay**2) * rng.standard_normal(n)
    drive[0] = deviation * rng.standard_normal()
    return lfilter([1.0], [1.0, -decay], drive)
