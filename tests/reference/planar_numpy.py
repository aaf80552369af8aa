"""Planar dead reckoning, slow and plain: Eq. (2) and (3) as the paper writes them."""

from __future__ import annotations

import numpy as np

from tests.reference.random_numpy import constants, white_noise


def reconstruct(problem, key: int, realizations, trapezoidal: bool) -> dict[str, np.ndarray]:
    """States of every realization at every sample, arrays (n + 1, r).

    The third channel of a problem is the turn per interval, Omega T.
    """
    truth, t = problem.truth, problem.interval
    n = problem.n_samples
    z = constants(key, realizations)
    d = problem.deviations(problem.measurement, disturbed=True)
    white = np.concatenate([z[None, 8:11], white_noise(key, realizations, n)])
    measured = (
        problem.signals[:, :, None]
        + (d[:3, None] * z[:3])[None]
        + problem.sensor_errors.white[None, :, None] * white
    )
    psi = truth.heading[0] + d[4] * z[4] + d[5] * z[5]
    chi = truth.course[0] + d[4] * z[4] + d[6] * z[6]
    speed = truth.speed[0] + d[3] * z[3]
    v = speed * np.cos(chi) + 1j * speed * np.sin(chi)
    p = np.full(len(realizations), truth.along[0] + 1j * truth.across[0])
    psis, vs, ps = [psi], [v], [p]
    for i in range(1, n + 1):
        if trapezoidal:
            share = problem.previous_share
            mean = (1.0 - share) * measured[i] + share * measured[i - 1]
            middle = psi + 0.5 * mean[2]
            psi = psi + mean[2]
            a = (mean[0] + 1j * mean[1]) * np.exp(1j * middle)
            p = p + t * v + 0.5 * t**2 * a
            v = v + t * a
        else:
            psi = psi + measured[i, 2]
            a = (measured[i, 0] + 1j * measured[i, 1]) * np.exp(1j * psi)
            v = v + t * a
            p = p + t * v
        psis.append(psi)
        vs.append(v)
        ps.append(p)
    return {"heading": np.array(psis), "velocity": np.array(vs), "position": np.array(ps)}


def end_errors(problem, key: int, realizations, trapezoidal: bool) -> np.ndarray:
    """along, across, position, heading, course at the last sample, (5, r)."""
    states = reconstruct(problem, key, realizations, trapezoidal)
    truth = problem.truth
    error = states["position"][-1] - (truth.along[-1] + 1j * truth.across[-1])
    heading = np.exp(1j * (states["heading"][-1] - truth.heading[-1]))
    course = states["velocity"][-1] * np.exp(-1j * truth.course[-1])
    return np.array([error.real, error.imag, np.abs(error), np.angle(heading), np.angle(course)])
