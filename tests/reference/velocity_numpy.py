"""The velocity measurement, slow and plain: every group, run and step as the source writes it."""

from __future__ import annotations

import numpy as np

from tests.reference.random_numpy import normal_pair, stream_words, xoshiro


def group_normals(key: int, groups) -> np.ndarray:
    """What every group draws once, (16, groups)."""
    rows = []
    for block in range(4):
        w = stream_words(key, groups, 1, block)
        rows += [*normal_pair(w[0], w[1]), *normal_pair(w[2], w[3])]
    return np.array(rows)


def step_normals(key: int, groups, runs: int, steps: int, stamps: bool):
    """Normals (runs, steps, 4, groups): twelve drawn at a time serve three steps of a run.

    Also the normals (runs, groups) of the first stamps; with them twelve more are drawn per run.
    """
    state = stream_words(key, groups, 0, 0)
    drawn = []
    for _ in range(runs * (-(-steps // 3) + stamps)):
        for _ in range(6):
            a, state = xoshiro(state)
            b, state = xoshiro(state)
            drawn += [*normal_pair(a, b)]
    normals = np.array(drawn).reshape(runs, -1, 12, len(groups))
    first = normals[:, 0, 0] if stamps else np.zeros((runs, len(groups)))
    return normals[:, int(stamps) :].reshape(runs, -1, 4, len(groups))[:, :steps], first


def velocities(problem, key: int, groups) -> np.ndarray:
    """Velocity (runs, steps, groups) after every step."""
    n = len(problem.raw)
    q = problem.inputs[:, None] + problem.uncertainties[:, None] * group_normals(key, groups)[:14]
    lx, lz, bias, rest = q[0:3], q[3:6], q[6:9], q[9:12]
    theta0 = np.arctan(np.sum(lx * (rest - bias), 0) / np.sum(lz * (rest - bias), 0))
    theta, g = theta0 + q[12], q[13]
    z, first = step_normals(key, groups, problem.runs, n, problem.stamps)
    raw = problem.raw[None, :, :, None] + problem.white[None, None, :, None] * z[:, :, :3]
    acx = np.sum(lx * (raw - bias), axis=2)
    acz = np.sum(lz * (raw - bias), axis=2)
    tilted = {
        0: acx - acz * theta,
        1: (acx - acz * theta) / (1.0 + theta**2),
        2: acx * np.cos(theta) - acz * np.sin(theta),
    }[problem.tilt_order]
    error = z[:, :, 3]
    if problem.stamps:
        error = np.diff(error, axis=1, prepend=first[:, None]) / np.sqrt(2.0)
    return np.cumsum(g * tilted * (problem.interval + problem.time_error * error), axis=1)
