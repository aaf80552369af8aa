"""The interval of any statistic by the bootstrap over the realizations that are kept.

Realizations are resampled singly, or in cells of equal size where there are many; where Sobol nets
make them, in nets.

Of intervals of 95.4 % for the median deviation, the mean magnitude and the quartiles' distance of
normal and gamma errors, 93.3 to 96.0 % held the truth at 50 to 5000 realizations (600 trials each,
200 at 5000); of those of 99.73 %, 98.5 to 100 %, and 96 % at 50 for the quartiles of gamma errors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mcsim.statistics.bca import acceleration, bca, student_sigmas

if TYPE_CHECKING:
    from mcsim.statistics.evidence import Evidence

Array = NDArray[np.float64]

#: Realizations that are resampled in all, at most, and resamples at least.
_MOST_RESAMPLED, _FEWEST_RESAMPLES = 20_000_000, 200
#: Realizations resampled at once: what that takes in memory.
_AT_ONCE = 1 << 21
#: Groups of realizations that are left out in turn, to see how the statistic leans.
_GROUPS = 64
#: Fewer nets than this do not tell how they scatter: realizations then count as independent,
#: which scatter more.
_FEWEST_NETS = 8


def resampled_interval(
    evidence: Evidence, statistic: Callable[[Array], Array]
) -> tuple[Array, Array, Array]:
    """Value and BCa interval ends (e,) of a statistic of realizations (…, r) to (…)."""
    kept = evidence.collector.kept(evidence.rows)
    value = statistic(kept)
    items, sigmas = _items(evidence, kept)
    influence = _influence(statistic, items)
    count = max(_FEWEST_RESAMPLES, min(evidence.resamples, _MOST_RESAMPLED // kept.shape[1]))
    resampled = np.concatenate(
        [
            np.stack([statistic(row[drawn].reshape(len(drawn), -1)) for row in items])
            for drawn in _drawn(items.shape[1:], count, evidence.key)
        ],
        axis=-1,
    )
    low, high = bca(value, resampled, acceleration(influence), sigmas)
    return value, low, high


def _items(evidence: Evidence, kept: Array) -> tuple[Array, float]:
    """What is resampled (e, items, cell) of realizations (e, r), and the reach of intervals."""
    from mcsim.statistics.collector import cell_size

    collector, sigmas = evidence.collector, evidence.sigmas
    rows, count = kept.shape
    nets = count // collector.cell
    if collector.nets and nets >= _FEWEST_NETS:
        whole = kept[:, : nets * collector.cell]
        return whole.reshape(rows, nets, collector.cell), student_sigmas(sigmas, nets)
    cell = cell_size(count, nets=False)
    number = count // cell
    return kept[:, : number * cell].reshape(rows, number, cell), sigmas


def _influence(statistic: Callable[[Array], Array], items: Array) -> Array:
    """How much each group of items (e, groups) raises the statistic: left out, it falls by that."""
    rows, number, _ = items.shape
    without = np.stack(
        [
            statistic(np.delete(items, group, axis=1).reshape(rows, -1))
            for group in np.array_split(np.arange(number), min(_GROUPS, number))
        ],
        axis=-1,
    )
    return without.mean(axis=-1, keepdims=True) - without


def _drawn(shape: tuple[int, ...], count: int, key: int) -> Iterator[NDArray[np.intp]]:
    """Indices (b, items) of resamples, some at once: the same for every error and statistic."""
    generator = np.random.default_rng(key)
    items, cell = shape
    at_once = max(1, _AT_ONCE // (items * cell))
    for first in range(0, count, at_once):
        yield generator.integers(0, items, (min(at_once, count - first), items))
