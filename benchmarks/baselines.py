"""The two baselines that speeds are stated against: plain numpy and naive numba.

Both do what the planar kernel does (Eq. (2) and (3), white noise on three channels),
the way one writes it first.  tests/test_benchmarks.py holds their statistics against
the kernel's.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange


def plain_numpy(signals, white, start, interval, count, rng):
    """Vectorised over realizations, a Python loop over samples; end positions (2, count)."""
    psi = np.full(count, start[3])
    vl = np.full(count, start[2] * math.cos(start[4]))
    vd = np.full(count, start[2] * math.sin(start[4]))
    pl = np.full(count, start[0])
    pd = np.full(count, start[1])
    for forward, left, turn in signals[1:]:
        noise = rng.standard_normal((3, count))
        psi += turn + white[2] * noise[2]
        c, s = np.cos(psi), np.sin(psi)
        f = forward + white[0] * noise[0]
        g = left + white[1] * noise[1]
        vl += interval * (c * f - s * g)
        vd += interval * (s * f + c * g)
        pl += interval * vl
        pd += interval * vd
    return np.stack([pl, pd])


@njit(parallel=True, cache=True)
def naive_numba(signals, white, start, interval, count):
    """A parallel loop over realizations with numpy's normals inside; end positions."""
    ends = np.empty((2, count))
    for r in prange(count):
        psi = start[3]
        vl = start[2] * math.cos(start[4])
        vd = start[2] * math.sin(start[4])
        pl = start[0]
        pd = start[1]
        for i in range(1, len(signals)):
            psi += signals[i, 2] + white[2] * np.random.normal()  # noqa: NPY002
            f = signals[i, 0] + white[0] * np.random.normal()  # noqa: NPY002
            g = signals[i, 1] + white[1] * np.random.normal()  # noqa: NPY002
            vl += interval * (math.cos(psi) * f - math.sin(psi) * g)
            vd += interval * (math.sin(psi) * f + math.cos(psi) * g)
            pl += interval * vl
            pd += interval * vd
        ends[0, r] = pl
        ends[1, r] = pd
    return ends
