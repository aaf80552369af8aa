"""Groups of velocity runs with a whole sensor, sample by sample, with numpy's random numbers.

Nothing here is shared with the package but the undisturbed raw output: every process is stepped
as its definition says, flicker noise is Kasdin's, and each group is corrected and integrated
as the source writes it.  Error terms are in SI units, as data sheets have them.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from tests.reference.noise import flicker


@dataclass(frozen=True)
class Terms:
    """Deviations of a sensor's error terms, the same for all axes; SI."""

    noise: float = 0.0
    offset: float = 0.0
    scale: float = 0.0
    angle: float = 0.0
    bias_instability: float = 0.0
    walk: float = 0.0
    drift: float = 0.0
    correlation_time: float = 1.0
    resolution: float = 0.0
    range: float = np.inf
    spike_rate: float = 0.0
    spike_height: float = 0.0
    #: Mistakes, for controls that must fail.
    drift_starts_at_zero: bool = False
    walk_steps_with_dt: bool = False
    noise_starts_anew: bool = False


def in_run_noise(terms, groups, samples, dt, rng):
    """Drift, random walk and flicker (groups, samples) of one axis from turn-on."""
    noise = np.zeros((groups, samples))
    if terms.drift:
        decay = np.exp(-dt / terms.correlation_time)
        drive = terms.drift * np.sqrt(1.0 - decay**2)
        x = terms.drift * rng.standard_normal(groups) * (not terms.drift_starts_at_zero)
        for i in range(samples):
            noise[:, i] += x
            x = decay * x + drive * rng.standard_normal(groups)
    if terms.walk:
        step = terms.walk * (dt if terms.walk_steps_with_dt else np.sqrt(dt))
        x = np.zeros(groups)
        for i in range(samples):
            noise[:, i] += x
            x = x + step * rng.standard_normal(groups)
    if terms.bias_instability:
        for group in range(groups):
            noise[group] += terms.bias_instability * flicker(samples, rng)
    return noise


def measured(problem, terms, g, groups, rng):
    """Raw output (groups, samples, 3) of the rest and all runs, in fractions of g."""
    rest, bias = problem.inputs[9:12], problem.inputs[6:9]
    raw = np.concatenate([np.tile(rest, (problem.at_rest, 1)), *[problem.raw] * problem.runs])
    samples, dt = len(raw), problem.interval
    mixing = terms.angle * rng.standard_normal((groups, 3, 3))
    diagonal = np.arange(3)
    mixing[:, diagonal, diagonal] = terms.scale * rng.standard_normal((groups, 3))
    output = raw + np.einsum("gij,nj->gni", mixing, raw - bias)
    offset = terms.offset * rng.standard_normal((groups, 3))
    cuts = [0, samples]
    if terms.noise_starts_anew:
        cuts = [0, *range(problem.at_rest, samples + 1, len(problem.raw))]
    for axis in range(3):
        added = terms.noise * rng.standard_normal((groups, samples)) + offset[:, axis, None]
        for begin, end in itertools.pairwise(cuts):
            added[:, begin:end] += in_run_noise(terms, groups, end - begin, dt, rng)
        hit = rng.random((groups, samples)) < terms.spike_rate * dt
        added += terms.spike_height * hit * rng.choice([-1.0, 1.0], (groups, samples))
        output[:, :, axis] += added / g
    return digitised(output, terms.range / g, terms.resolution / g)


def digitised(output, largest, step):
    """Saturation, then the nearest step."""
    output = np.clip(output, -largest, largest)
    return step * np.floor(output / step + 0.5) if step else output


def integrated(problem, output, q, intervals):
    """Velocities (runs, steps, groups) from raw output (groups, samples, 3), Eq. (3)-(24).

    ``q`` (14, groups) are calibration, rest (unused), tilt change and gravity; ``intervals``
    (runs, steps, groups).
    """
    lx, lz, bias = q[0:3].T[:, None], q[3:6].T[:, None], q[6:9].T[:, None]
    acx = np.sum(lx * (output - bias), axis=2)
    acz = np.sum(lz * (output - bias), axis=2)
    mean = (output[:, : problem.at_rest] - bias).mean(axis=1, keepdims=True)
    tilt = np.arctan(np.sum(lx * mean, axis=2) / np.sum(lz * mean, axis=2)) + q[12][:, None]
    acceleration = q[13][:, None] * (acx - acz * tilt)[:, problem.at_rest :]
    of_runs = acceleration.T.reshape(problem.runs, -1, len(output))
    return np.cumsum(of_runs * intervals, axis=1)


def errors(problem, terms, g, groups, seed):
    """The case's errors (3 k, groups): first run, mean of the runs, scatter, per instant."""
    rng = np.random.default_rng(seed)
    output = measured(problem, terms, g, groups, rng)
    u = problem.uncertainties.copy()
    u[9:12] = 0.0
    q = problem.inputs[:, None] + u[:, None] * rng.standard_normal((14, groups))
    shape = (problem.runs, len(problem.raw), groups)
    intervals = problem.interval + problem.time_error * rng.standard_normal(shape)
    at = integrated(problem, output, q, intervals)[:, problem.steps - 1]
    truth = problem.truth[problem.steps][:, None]
    rows = [at[0] - truth, at.mean(axis=0) - truth, at.std(axis=0, ddof=1)]
    return np.stack(rows, axis=1).reshape(-1, groups)
