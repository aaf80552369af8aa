"""Bootstrap of moments: one set of resampling counts serves every error.

The counts are multinomial: how often each of ``n`` items occurs in a resample
of ``n``.  They come from the project's own generator, so that intervals are as
reproducible as the errors themselves.
"""

from __future__ import annotations

import numpy as np
from numba import uint32, uint64
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel, scalar
from mcsim.kernels.random import stream_words, xoshiro_next

#: Resamples summed side by side.
LANES = 256


@kernel
def resampling_counts(key: np.uint64, counts: NDArray[np.uint8]) -> None:
    """Fill ``counts`` (n items, b resamples) with multinomial(n, 1/n) columns.

    A count beyond 255 needs more than 255 items, and then does not happen.
    """
    n, resamples = counts.shape
    counts[:] = 0
    for b in range(resamples):
        s0, s1, s2, s3 = stream_words(key, uint64(b), 0, 0)
        for _ in range(n):
            word, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
            # Lemire's multiplication maps 32 bits to 0 ... n - 1; bias below n / 2^32.
            item = uint32((uint64(word) * uint64(n)) >> uint64(32))
            counts[item, b] += np.uint8(1)


@scalar
def _add_items(x, y, z, w, weights, tile):
    """Add four items of four rows (one tuple per row) to a tile of four rows of lanes."""
    for b in range(LANES):
        w0 = weights[b]
        w1 = weights[LANES + b]
        w2 = weights[2 * LANES + b]
        w3 = weights[3 * LANES + b]
        tile[b] = tile[b] + x[0] * w0 + x[1] * w1 + x[2] * w2 + x[3] * w3
        tile[LANES + b] = tile[LANES + b] + y[0] * w0 + y[1] * w1 + y[2] * w2 + y[3] * w3
        tile[2 * LANES + b] = tile[2 * LANES + b] + z[0] * w0 + z[1] * w1 + z[2] * w2 + z[3] * w3
        tile[3 * LANES + b] = tile[3 * LANES + b] + w[0] * w0 + w[1] * w1 + w[2] * w2 + w[3] * w3


@scalar
def _four_items(items, row, first):
    """Items ``first`` and following of a row; zero beyond either end."""
    rows, n = items.shape
    zero = np.float32(0.0)
    if row >= rows:
        return zero, zero, zero, zero
    return (
        items[row, first],
        items[row, first + 1] if first + 1 < n else zero,
        items[row, first + 2] if first + 2 < n else zero,
        items[row, first + 3] if first + 3 < n else zero,
    )


@kernel
def resampled_sums(
    counts: NDArray[np.uint8], items: NDArray[np.float32], sums: NDArray[np.float32]
) -> None:
    """sums[m, b] = sum over i of counts[i, b] * items[m, i], in a fixed order.

    ``counts`` (n, b), ``items`` (m, n) with deviations of about one, ``sums`` (m, b), written.
    """
    n, resamples = counts.shape
    rows = items.shape[0]
    fours = (rows + 3) // 4
    # A tile of resamples at a time: four items of four rows between loading and storing sums.
    weights = np.zeros(4 * LANES, np.float32)
    tile = np.empty(fours * 4 * LANES, np.float32)
    for start in range(0, resamples, LANES):
        width = min(LANES, resamples - start)
        tile[:] = np.float32(0.0)
        for first in range(0, n, 4):
            for k in range(4):
                if first + k < n:
                    row_of_counts = counts[first + k, start : start + width]
                    row_of_weights = weights[k * LANES : k * LANES + width]
                    for b in range(width):
                        row_of_weights[b] = np.float32(row_of_counts[b])
            for four in range(fours):
                row = 4 * four
                _add_items(
                    _four_items(items, row, first),
                    _four_items(items, row + 1, first),
                    _four_items(items, row + 2, first),
                    _four_items(items, row + 3, first),
                    weights,
                    tile[row * LANES : (row + 4) * LANES],
                )
        for m in range(rows):
            for b in range(width):
                sums[m, start + b] = tile[m * LANES + b]
