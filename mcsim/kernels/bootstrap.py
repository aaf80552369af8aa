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

_LANES = 64


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
    counts: NDArray[np.float32], items: NDArray[np.float64], sums: NDArray[np.float64]
) -> None:
    """sums[m, b] = sum over i of counts[i, b] * items[m, i], in a fixed order.

    ``counts`` float32 (n, b), ``items`` float64 (m, n), ``sums`` float64 (m, b), written.
    """
    n, resamples = counts.shape
    for start in range(0, resamples, _LANES):
        stop = min(start + _LANES, resamples)
        for m in range(items.shape[0]):
            for b in range(start, stop):
                sums[m, b] = 0.0
            for i in range(n):
                x = items[m, i]
                for b in range(start, stop):
                    sums[m, b] += counts[i, b] * x
