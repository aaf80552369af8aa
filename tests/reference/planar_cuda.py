"""The kernels' scalar functions, compiled for CUDA: one realization per thread.

Run as a program with ``MCSIM_TARGET=cuda``; with ``NUMBA_ENABLE_CUDASIM=1`` it needs no GPU.  It
reads the arguments of a run from one ``.npz`` file and writes words, normals and end states to
another.
"""

from __future__ import annotations

import sys

import numpy as np
from numba import cuda, uint64

from mcsim.kernels import planar, planar_steps, random
from mcsim.kernels.lanes import WHITE_NOISE

State = planar_steps.State
step = planar.Planar.STEPS[planar.RECTANGULAR].function


@cuda.jit
def _simulate(key, signals, white, start, words, normals, ends):
    r = cuda.grid(1)
    if r < ends.shape[1]:
        s0, s1, s2, s3 = random.stream_words(key[0], uint64(r), WHITE_NOISE, 0)
        moving = State(start[0], start[1], start[2], start[3], start[4], start[5])
        for i in range(0, len(signals) - 1, 2):
            for pair in range(3):
                a, s0, s1, s2, s3 = random.xoshiro_next(s0, s1, s2, s3)
                b, s0, s1, s2, s3 = random.xoshiro_next(s0, s1, s2, s3)
                words[3 * i + 2 * pair, r] = a
                words[3 * i + 2 * pair + 1, r] = b
                x, y = random.normal_pair(a, b)
                normals[3 * i + 2 * pair, r] = x
                normals[3 * i + 2 * pair + 1, r] = y
            for k in range(2):
                row = 3 * (i + k)
                read = (
                    signals[i + k + 1, 0] + white[0] * normals[row, r],
                    signals[i + k + 1, 1] + white[1] * normals[row + 1, r],
                    signals[i + k + 1, 2] + white[2] * normals[row + 2, r],
                )
                moving = step(0, moving, read)  # the rectangular rule needs no number of the system
        ends[0, r], ends[1, r] = moving.c, moving.s
        ends[2, r], ends[3, r] = moving.vl, moving.vd
        ends[4, r], ends[5, r] = moving.pl, moving.pd


def main(given: str, result: str) -> None:
    arguments = np.load(given)
    count = int(arguments["count"])
    samples = len(arguments["signals"]) - 1
    words = np.zeros((3 * samples, count), np.uint32)
    normals = np.zeros((3 * samples, count), np.float32)
    ends = np.zeros((6, count))
    with np.errstate(over="ignore"):  # words wrap around
        _simulate[1, count](
            arguments["key"], arguments["signals"], arguments["white"], arguments["start"],
            words, normals, ends,
        )  # fmt: skip
    np.savez(result, words=words, normals=normals, ends=ends)


if __name__ == "__main__":
    main(*sys.argv[1:])
