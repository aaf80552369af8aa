"""Non-negative least squares of many small problems with one design."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Columns count as dependent when a set of them has a determinant, of columns of length 1,
#: below this; a smaller set then serves.
_LEAST_DETERMINANT = 1e-13


def nonnegative_squares(design: Array, targets: Array, weights: Array) -> Array:
    """Least squares solutions without negative values, by trying every set of columns.

    Of the sets whose own solution has no negative value, the one with the least misfit is
    the solution of Lawson and Hanson's problem.  That is fast for a few columns.

    Parameters
    ----------
    design : float64 (k, p)
    targets, weights : float64 (r, k)
        Right sides and inverse deviations of r problems.

    Returns
    -------
    float64 (r, p)
    """
    size = np.sqrt(np.einsum("kp,rk->rp", design**2, weights**2))
    squared = weights**2
    columns = np.einsum("kp,kq->kpq", design, design).reshape(len(design), -1)
    normal = (squared @ columns).reshape(len(targets), *2 * design.shape[1:])
    normal /= size[:, :, None] * size[:, None, :]
    right = (squared * targets) @ design / size
    best = np.zeros(len(targets))
    solutions = np.zeros_like(right)
    for count in range(1, design.shape[1] + 1):
        for chosen in combinations(range(design.shape[1]), count):
            part = normal[:, chosen][:, :, chosen]
            sound = np.linalg.det(part) > _LEAST_DETERMINANT
            part = np.where(sound[:, None, None], part, np.eye(count))
            values = np.linalg.solve(part, right[:, chosen, None])[..., 0]
            gain = np.einsum("rp,rp->r", values, right[:, chosen])
            better = sound & np.all(values >= 0.0, axis=1) & (gain > best)
            best[better] = gain[better]
            solutions[better] = 0.0
            solutions[np.ix_(better, chosen)] = values[better]
    return solutions / size
