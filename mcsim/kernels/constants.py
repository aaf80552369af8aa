"""What realizations draw once, for those who need it beside a kernel."""

from __future__ import annotations

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel
from mcsim.kernels.lanes import LANES, draw_constants


@kernel
def constants_of(key: np.uint64, first: np.uint64, normals: NDArray[np.float32]) -> None:
    """The normals (rows, count) of the realizations from ``first`` on, as the kernels draw them.

    The number of rows is a multiple of four.
    """
    rows, count = normals.shape
    constants = np.empty(rows * LANES, np.float32)
    for start in range(0, count, LANES):
        draw_constants(key, first + uint64(start), rows, constants)
        for row in range(rows):
            for j in range(min(LANES, count - start)):
                normals[row, start + j] = constants[row * LANES + j]
