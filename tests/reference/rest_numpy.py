"""A sensor axis at rest and on a straight, level run, sample by sample in plain numpy.

First its bias is calibrated, then the attitude is levelled by its mean, then it drives.  To
first order in the tilt the velocity collects what it measures less the mean at rest.
"""

import numpy as np


def noise(rng, count, n, step, white=0.0, drift=0.0, time=1.0, walk=0.0, spikes=(0.0, 0.0)):
    """In-run noise (count, n) of realizations; ``spikes`` are a rate and an amplitude."""
    values = white * rng.standard_normal((count, n))
    if drift:
        decay = np.exp(-step / time)
        state = drift * rng.standard_normal(count)
        for k in range(n):
            values[:, k] += state
            state = decay * state + drift * np.sqrt(1 - decay**2) * rng.standard_normal(count)
    if walk:
        steps = walk * np.sqrt(step) * rng.standard_normal((count, n))
        values += np.cumsum(steps, axis=1) - steps
    rate, amplitude = spikes
    if rate:
        hit = rng.random((count, n)) < rate * step
        values += amplitude * hit * rng.choice([-1.0, 1.0], (count, n))
    return values


def digitise(values, largest, resolution):
    cut = np.clip(values, -largest, largest)
    return resolution * np.floor(cut / resolution + 0.5) if resolution else cut


def along_errors(
    rng, count, step, calibration, levelling, run, late, bias=0.0, fixed=0.0, signal=0.0,
    largest=np.inf, resolution=0.0, **terms,
):  # fmt: skip
    """Errors along (count,) of a run of ``run`` steps, by the rectangular rule.

    ``calibration`` and ``levelling`` are numbers of samples at rest, zero for none; ``late`` says
    that the rule reads one sample behind and moves by the old velocity.  ``bias`` is the
    deviation of an offset, ``fixed`` what the axis truly senses all the time, ``signal`` what it
    senses while it runs.
    """
    n = calibration + levelling + run + 1
    raw = noise(rng, count, n, step, **terms) + bias * rng.standard_normal((count, 1)) + fixed
    raw[:, calibration + levelling :] += signal
    out = digitise(raw, largest, resolution) - fixed
    if calibration:
        out = out - out[:, :calibration].mean(axis=1, keepdims=True)
    if levelling:
        rest = out[:, calibration : calibration + levelling]
        out = out - rest.mean(axis=1, keepdims=True)
    own = out[:, calibration + levelling :] - signal
    own = own[:, :-1] if late else own[:, 1:]
    velocity = np.cumsum(own, axis=1) * step
    if late:
        velocity = velocity[:, :-1]
    return velocity.sum(axis=1) * step
