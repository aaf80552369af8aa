"""The realizations of one point, summed in cells as they come, in any order.

Realizations are summed in *cells* of equal size (single ones, up to ``MOST_ITEMS``), so that
neither the cost of resampling nor the memory grows with their number.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Percentiles that are estimated where a case does not ask for others.
PERCENTILES = (0.50, 0.95)
#: Most items that are resampled; cells grow by powers of two beyond.
MOST_ITEMS = 2048
#: Cells that realizations make where each is a Sobol net: few, since nets gain by size.
MOST_NETS = 64
#: Realizations that are kept as they are; beyond, only those near a percentile.
KEPT = 1 << 17
#: Half-width of what "near" means, in standard errors of the kept ones' percentile.
_NEAR = 9.0


@dataclass(frozen=True)
class Rare:
    """Events so rare that a run may miss them, as the linear model knows them; (e,) each.

    ``variance`` is what they add to an error's variance, ``events`` how many a realization
    has on average; of events of unequal weight, as many equal ones as scatter alike.
    """

    variance: Array
    events: Array


@dataclass(frozen=True)
class Reference:
    """What is known beforehand: per error (e,), SI units.

    ``centre`` is taken off the errors (the method errors); ``mean`` and
    ``second_moment`` are the controls' expectations, absent without controls, NaN for controls
    that are not to be trusted; ``percentiles`` are those that realizations are kept around.
    """

    centre: Array
    mean: Array | None = None
    second_moment: Array | None = None
    percentiles: tuple[float, ...] = PERCENTILES
    rare: Rare | None = None


def cell_size(count: int, nets: bool) -> int:
    """Realizations of a cell where there are ``count``: a power of two."""
    cell = 1
    while count > (MOST_NETS if nets else MOST_ITEMS) * cell:
        cell *= 2
    return cell


class Collector:
    """Takes in the realizations of one point, in any order and from any thread.

    ``count`` realizations are expected, in pieces that begin at multiples of
    ``cell``; those below ``KEPT`` must be added before any beyond.  With ``nets`` every
    cell is a Sobol net: cells are independent of each other, realizations are not.
    """

    def __init__(self, count: int, reference: Reference, nets: bool = False) -> None:
        from mcsim.kernels.moments import SUMS

        self.count = count
        self.reference = reference
        self.nets = nets
        self.cell = cell_size(count, nets)
        cells = -(-count // self.cell)
        n_errors = len(reference.centre)
        self.sums = np.zeros((SUMS, n_errors, cells))
        self.sizes = np.full(cells, float(self.cell))
        self.sizes[-1] = count - (cells - 1) * self.cell
        self._kept = np.empty((n_errors, min(count, KEPT)))
        self._extremes = [np.full(n_errors, np.inf), np.full(n_errors, -np.inf)]
        self._ordered: dict[int, Array] = {}
        self._lock = threading.Lock()
        self._brackets: list[dict[float, _Bracket]] | None = None

    def add(self, first: int, errors: Array, controls: Array) -> None:
        """Take in realizations ``first`` and following: (e, r) errors and controls."""
        from mcsim.kernels.moments import add_cells

        add_cells(errors, self.reference.centre, controls, self.cell, first // self.cell, self.sums)
        low, high = errors.min(axis=1), errors.max(axis=1)
        with self._lock:
            self._extremes = [
                np.minimum(self._extremes[0], low),
                np.maximum(self._extremes[1], high),
            ]
        if first < KEPT:
            kept = min(errors.shape[1], self._kept.shape[1] - first)
            self._kept[:, first : first + kept] = errors[:, :kept]
            if kept == errors.shape[1]:
                return
            errors = errors[:, kept:]
        with self._lock:
            if self._brackets is None:
                percentiles = self.reference.percentiles
                self._brackets = [{p: _Bracket(row, p) for p in percentiles} for row in self._kept]
        for row, brackets in zip(errors, self._brackets, strict=True):
            for bracket in brackets.values():
                bracket.add(row)

    @property
    def smallest(self) -> Array:
        """The smallest realization of each error (e,)."""
        return self._extremes[0]

    @property
    def degenerate(self) -> NDArray[np.bool_]:
        """Errors (e,) whose realizations are all equal."""
        return self._extremes[0] == self._extremes[1]

    def not_negative(self) -> NDArray[np.bool_]:
        """Errors (e,) of which no realization is negative."""
        return self._extremes[0] >= 0.0

    def kept(self, errors: NDArray[np.intp]) -> Array:
        """The realizations (e, k) of these errors that are kept as they are, the first ones."""
        return np.asarray(self._kept[errors], float)

    def order_statistics(self, error: int, percentile: float, ranks: list[int]) -> list[float]:
        """The realizations of the given ranks (1 ... count) around a percentile."""
        if self._brackets is None:
            ordered = self._sorted(error)
            return [float(ordered[rank - 1]) for rank in ranks]
        return self._brackets[error][percentile].order_statistics(ranks)

    def scatter_below(self, error: int, value: float) -> float:
        """Scatter of the cells' numbers of errors below a value, in that of independent ones.

        At least 1, which it is without nets; of the realizations that are kept.
        """
        whole = self._kept.shape[1] // self.cell
        if not self.nets or self.cell == 1 or whole < 2:
            return 1.0
        below = self._kept[error, : whole * self.cell].reshape(whole, self.cell) < value
        share = float(below.mean())
        independent = share * (1.0 - share) * self.cell
        if independent == 0.0:
            return 1.0
        return max(1.0, float(np.sqrt(np.var(below.sum(axis=1), ddof=1) / independent)))

    def _sorted(self, error: int) -> Array:
        if error not in self._ordered:
            self._ordered[error] = np.sort(self._kept[error])
        return self._ordered[error]


class _Bracket:
    """Counts the realizations below a percentile's neighbourhood, and keeps those inside."""

    def __init__(self, kept: Array, p: float) -> None:
        ordered = np.sort(kept)
        reach = _NEAR * np.sqrt(p * (1.0 - p) / len(kept))
        last = len(kept) - 1
        self.low = ordered[max(int((p - reach) * last), 0)]
        self.high = ordered[min(int((p + reach) * last) + 1, last)]
        inside = (ordered >= self.low) & (ordered <= self.high)
        self.below = int(np.count_nonzero(ordered < self.low))
        self._inside = [ordered[inside]]
        self._lock = threading.Lock()

    def add(self, values: Array) -> None:
        below = int(np.count_nonzero(values < self.low))
        inside = values[(values >= self.low) & (values <= self.high)]
        with self._lock:
            self.below += below
            self._inside.append(inside)

    def order_statistics(self, ranks: list[int]) -> list[float]:
        # Sorting makes the result independent of the order in which threads came.
        inside = np.sort(np.concatenate(self._inside))
        return [float(inside[min(max(r - 1 - self.below, 0), len(inside) - 1)]) for r in ranks]
