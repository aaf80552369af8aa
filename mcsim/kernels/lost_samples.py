"""The likeliest places of lost samples in jittering time stamps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel

Array = NDArray[np.float64]

#: Hypotheses that are followed side by side, one per number of samples lost so far.
_HYPOTHESES = 16
#: A stamp farther out (in standard deviations) counts as this far: late or stale.
_FARTHEST = 4.0


@kernel
def follow(
    excess: Array,
    sigma: float,
    gain: float,
    penalty: float,
    lost: NDArray[np.int64],
    residuals: Array,
) -> float:
    """Find where samples were lost, by the number of samples against the time elapsed.

    Stamp i of an evenly sampling sensor stands at ``i + lost + phase + noise`` intervals.  The
    path of ``lost`` that never falls and costs least is found by dynamic programming
    (Viterbi): each stamp costs half its squared deviation, each place of loss ``penalty``.
    Every hypothesis follows the slow phase (drift of the clock) by itself.

    Parameters
    ----------
    excess : float64 (n,)
        Stamps in intervals, less their row number.
    sigma : float
        Standard deviation of the noise, in intervals.
    gain : float
        Part of a deviation that the phase follows.
    penalty : float
        Cost of a place of loss, in nats.
    lost : int64 (n,), written
        Samples lost before each row, since the first.
    residuals : float64 (n,), written
        Deviations of the stamps from the best path.

    Returns
    -------
    float
        Cost of the best path.
    """
    n = excess.shape[0]
    h = _HYPOTHESES
    infinite = 1e300
    costs = np.full(h, infinite)
    phases = np.zeros(h)
    next_costs = np.empty(h)
    next_phases = np.empty(h)
    came = np.zeros((n, h), np.int8)
    bases = np.zeros(n, np.int64)
    first = min(n, 32)
    start = np.median(excess[:first])
    costs[0] = 0.0
    phases[0] = start
    base = 0
    half = 0.5 / (sigma * sigma)
    far = _FARTHEST * sigma
    for i in range(n):
        # The best of all hypotheses with fewer losses may lose some here.
        below = infinite
        source = 0
        for k in range(h):
            cost = costs[k]
            phase = phases[k]
            origin = k
            if below + penalty < cost:
                cost = below + penalty
                phase = phases[source]
                origin = source
            if costs[k] < below:
                below = costs[k]
                source = k
            if cost >= infinite:
                next_costs[k] = infinite
                next_phases[k] = 0.0
                came[i, k] = 0
                continue
            r = excess[i] - (base + k) - phase
            bounded = min(max(r, -far), far)
            next_costs[k] = cost + bounded * bounded * half
            next_phases[k] = phase + gain * bounded
            came[i, k] = k - origin
        best = 0
        for k in range(h):
            costs[k] = next_costs[k]
            phases[k] = next_phases[k]
            if costs[k] < costs[best]:
                best = k
        bases[i] = base
        shift = best - h // 2
        if shift > 0 and i < n - 1:
            for k in range(h - shift):
                costs[k] = costs[k + shift]
                phases[k] = phases[k + shift]
            for k in range(h - shift, h):
                costs[k] = infinite
            base += shift
    best = 0
    for k in range(h):
        if costs[k] < costs[best]:
            best = k
    total = costs[best]
    k = best
    for i in range(n - 1, -1, -1):
        lost[i] = bases[i] + k
        k -= came[i, k]
        if i > 0:
            k += bases[i] - bases[i - 1]
    phase = start
    for i in range(n):
        r = excess[i] - lost[i] - phase
        residuals[i] = r
        phase += gain * min(max(r, -far), far)
    return total
