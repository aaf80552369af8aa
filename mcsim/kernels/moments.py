"""Sums of errors and controls over cells of consecutive realizations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel

Array = NDArray[np.float64]

#: Sums per error: u, u^2, c, c^2, u c, u^2 c^2, c^4 (u: error, c: control, both centred).
SUMS = 7


@kernel
def add_cells(
    errors: Array, centre: Array, controls: Array, cell: int, first_cell: int, sums: Array
) -> None:
    """Sum powers of centred errors, and their products with controls, cell by cell.

    Parameters
    ----------
    errors : float64 (e, r)
        Realizations that begin a cell; the last cell may be incomplete.
    centre : float64 (e,)
        What is taken off the errors.
    controls : float64 (e, r) or (e, 0)
        Control variates; without them their sums are not touched.
    cell : int
        Realizations per cell.
    first_cell : int
        Where the first of these cells stands in ``sums``.
    sums : float64 (SUMS, e, cells), written
    """
    n_errors, n = errors.shape
    with_controls = controls.shape[1] > 0
    for e in range(n_errors):
        for start in range(0, n, cell):
            place = first_cell + start // cell
            s1 = 0.0
            s2 = 0.0
            c1 = 0.0
            c2 = 0.0
            m11 = 0.0
            m22 = 0.0
            c4 = 0.0
            for i in range(start, min(start + cell, n)):
                u = errors[e, i] - centre[e]
                s1 += u
                s2 += u * u
                if with_controls:
                    c = controls[e, i]
                    c1 += c
                    c2 += c * c
                    m11 += u * c
                    m22 += u * u * c * c
                    c4 += c * c * c * c
            sums[0, e, place] = s1
            sums[1, e, place] = s2
            if with_controls:
                sums[2, e, place] = c1
                sums[3, e, place] = c2
                sums[4, e, place] = m11
                sums[5, e, place] = m22
                sums[6, e, place] = c4
