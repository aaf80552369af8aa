"""A noise level that does not stay: a step, or a wander.

The variance of the differences from sample to sample, which slow drift does not touch, is taken
of many windows.  Its logarithm scatters from one window to the next by chance; means of many
windows must not differ by more than that lets expect.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.health.record import Finding, Record

Array = NDArray[np.float64]

#: Windows of at least so many samples and seconds; at most so many windows.
_SAMPLES, _SECONDS, _MOST_WINDOWS = 50, 1.0, 1024
_FEWEST_WINDOWS = 24
#: Windows to a block, whose means are compared; and what a window may lie off by (handled ones
#: are told elsewhere).
_TO_A_BLOCK, _FARTHEST = 8, 4.0
#: A largest contrast that chance does not make (standard errors), and a change of the deviation
#: that is worth a word.
_CHANCE, _WORTH = 5.0, 0.08


def check_noise_level(record: Record) -> list[Finding]:
    """Compare the noise of the parts of a log."""
    n = len(record.samples)
    size = int(max(_SAMPLES, _SECONDS * record.rate, n // _MOST_WINDOWS))
    count = n // size
    if count < _FEWEST_WINDOWS or _coarse(record):
        return []
    windows = record.samples[: count * size].reshape(count, size)
    variances = np.mean(np.diff(windows, axis=1) ** 2, axis=1)
    if not np.all(variances > 0.0):
        return []
    level = np.log(variances)
    level = np.clip(level, *(np.median(level) + np.array([-_FARTHEST, _FARTHEST])))
    # Neighbours differ by chance alone; a median does not see the few that do not.
    scatter = 1.4826 * float(np.median(np.abs(np.diff(level)))) / np.sqrt(2.0)
    scatter = max(scatter, float(np.sqrt(0.5 * np.mean(np.diff(level) ** 2))), 1e-9)
    return _step(record, level, scatter, size) or _wander(record, level, scatter)


def _coarse(record: Record) -> bool:
    """Whether rounding makes the noise depend on where between two steps the output lies."""
    if record.resolution is None:
        return False
    return record.resolution > 1.2 * float(np.std(record.samples))


def _step(record: Record, level: Array, scatter: float, size: int) -> list[Finding]:
    count = len(level)
    total = np.cumsum(level)
    places = np.arange(4, count - 3)
    before = total[places - 1] / places
    after = (total[-1] - total[places - 1]) / (count - places)
    errors = scatter * np.sqrt(1.0 / places + 1.0 / (count - places))
    contrast = (after - before) / errors
    best = int(np.argmax(np.abs(contrast)))
    ratio = float(np.exp(0.5 * (after[best] - before[best])))
    if abs(contrast[best]) < _CHANCE or abs(np.log(ratio)) < np.log1p(_WORTH):
        return []
    # A step explains most of what there is; else it is a wander.
    step = np.where(np.arange(count) < places[best], before[best], after[best])
    if float(np.var(_blocks(level - step))) > 0.4 * float(np.var(_blocks(level))):
        return []
    at = record.seconds(float(places[best]) * size)
    cut = f"--end {at:.6g}" if ratio > 1.0 else f"--start {at:.6g}"
    text = (
        f"the noise changes by a factor of {ratio:.3g} about {at:.6g} s into the log; one N for "
        f"both is neither's: analyse each part ({cut} leaves the quieter one)"
    )
    return [Finding("level", record.name, text)]


def _wander(record: Record, level: Array, scatter: float) -> list[Finding]:
    blocks = _blocks(level)
    excess = float(np.var(blocks, ddof=1)) * _TO_A_BLOCK / scatter**2
    chance = 1.0 + _CHANCE * np.sqrt(2.0 / (len(blocks) - 1))
    low, high = np.exp(0.5 * (np.quantile(blocks, [0.05, 0.95]) - np.median(blocks)))
    if excess < chance + 0.5 or high / low < 1.0 + 2.0 * _WORTH:
        return []
    text = (
        f"the noise wanders between {low:.2g} and {high:.2g} times its median within the log: N is "
        "a mean over it"
    )
    return [Finding("level", record.name, text)]


def _blocks(level: Array) -> Array:
    count = len(level) // _TO_A_BLOCK
    size = _TO_A_BLOCK
    return np.asarray(level[: count * size].reshape(count, size).mean(axis=1))
