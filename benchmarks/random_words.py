"""Write the generator's raw 32-bit words to standard output, for test batteries.

Each realization contributes as many words as a track of some 170 samples takes, then
the next one follows: the battery sees the seeding by Philox as well as xoshiro128++.

    python -m benchmarks.random_words | dieharder -a -g 200
"""

from __future__ import annotations

import sys

import numpy as np
from numba import uint64

from mcsim.kernels.compilation import kernel
from mcsim.kernels.random import stream_words, xoshiro_next

WORDS_PER_REALIZATION = 512
REALIZATIONS_PER_WRITE = 4096


@kernel
def fill(key: np.uint64, first: np.uint64, words: np.ndarray) -> None:
    """words (realizations, WORDS_PER_REALIZATION) uint32, written."""
    for r in range(words.shape[0]):
        s0, s1, s2, s3 = stream_words(key, first + uint64(r), 0, 0)
        for i in range(words.shape[1]):
            words[r, i], s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)


def main() -> None:
    words = np.empty((REALIZATIONS_PER_WRITE, WORDS_PER_REALIZATION), np.uint32)
    first = 0
    while True:
        fill(np.uint64(1), np.uint64(first), words)
        first += REALIZATIONS_PER_WRITE
        try:
            sys.stdout.buffer.write(words)
        except BrokenPipeError:
            return


if __name__ == "__main__":
    main()
