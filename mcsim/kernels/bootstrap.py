"""Bootstrap of moments: one set of resampling counts serves every error.

The counts are multinomial: how often each of ``n`` items occurs in a resample
of ``n``.  They come from the project's own generator, so that intervals are as
reproducible as the errors themselves.
"""

from __future__ import annotations

import numpy as np
from numba import uint32, uint64
from numpy.typing import NDArray

from mcsim.kernels.compilation import kernel
from mcsim.kernels.random import stream_words, xoshiro_next

#: Resamples summed side by side.
LANES = 64


@kernel
def resampling_counts(key: np.uint64, counts: NDArray[np.float32]) -> None:
    """Fill ``counts`` (n items, b resamples) with multinomial(n, 1/n) columns (float32)."""
    n, resamples = counts.shape
    counts[:] = 0.0
    for b in range(resamples):
        s0, s1, s2, s3 = stream_words(key, uint64(b), 0, 0)
        for _ in range(n):
            word, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
            # Lemire's multiplication maps 32 bits to 0 ... n - 1; bias below n / 2^32.
            item = uint32((uint64(word) * uint64(n)) >> uint64(32))
            counts[item, b] += np.float32(1.0)


@kernel
def resampled_sums(
    counts: NDArray[np.float32], items: NDArray[np.float32], sums: NDArray[np.float32]
) -> None:
    """sums[m, b] = sum over i of counts[i, b] * items[m, i], in a fixed order.

    ``counts`` (n, b), ``items`` (m, n) with deviations of about one, ``sums`` (m, b), written.
    """
    n, resamples = counts.shape
    rows = items.shape[0]
    # A tile of resamples at a time, four items between loading and storing their sums.
    weights = np.zeros(4 * LANES, np.float32)
    tile = np.empty(rows * LANES, np.float32)
    for start in range(0, resamples, LANES):
        width = min(LANES, resamples - start)
        tile[:] = np.float32(0.0)
        for first in range(0, n, 4):
            for k in range(4):
                for b in range(width):
                    inside = first + k < n
                    weights[k * LANES + b] = counts[first + k, start + b] if inside else 0.0
            for m in range(rows):
                row = m * LANES
                x0 = items[m, first]
                x1 = items[m, first + 1] if first + 1 < n else np.float32(0.0)
                x2 = items[m, first + 2] if first + 2 < n else np.float32(0.0)
                x3 = items[m, first + 3] if first + 3 < n else np.float32(0.0)
                for b in range(LANES):
                    total = tile[row + b]
                    total = total + x0 * weights[b]
                    total = total + x1 * weights[LANES + b]
                    total = total + x2 * weights[2 * LANES + b]
                    total = total + x3 * weights[3 * LANES + b]
                    tile[row + b] = total
        for m in range(rows):
            for b in range(width):
                sums[m, start + b] = tile[m * LANES + b]
