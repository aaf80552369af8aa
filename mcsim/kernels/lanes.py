"""Random numbers for blocks of realizations side by side; every case draws them here.

Scratch arrays are flat, one row of ``LANES`` values after the other.
"""

from __future__ import annotations

from numba import uint64

from mcsim.kernels.compilation import scalar
from mcsim.kernels.random import normal_pair, stream_words, xoshiro_next

#: Realizations side by side.
LANES = 128
#: Normals drawn at a time from a stream, and the samples of three channels that they serve.
NORMALS, GROUP = 12, 4
#: Streams of a realization: white noise of the samples, constants drawn once.
WHITE_NOISE, CONSTANTS = 0, 1


@scalar
def seed_lanes(key, first, stream, random_state):
    """Put the xoshiro states of ``LANES`` realizations from ``first`` on into place."""
    for j in range(LANES):
        s0, s1, s2, s3 = stream_words(key, first + uint64(j), stream, 0)
        random_state[j] = s0
        random_state[LANES + j] = s1
        random_state[2 * LANES + j] = s2
        random_state[3 * LANES + j] = s3


@scalar
def draw_normals(key, first, stream, count, normals):
    """The first ``count`` normals (a multiple of four) of a stream, for each lane."""
    for block in range(count // 4):
        row = 4 * block * LANES
        for j in range(LANES):
            w0, w1, w2, w3 = stream_words(key, first + uint64(j), stream, block)
            z0, z1 = normal_pair(w0, w1)
            z2, z3 = normal_pair(w2, w3)
            normals[row + j] = z0
            normals[row + LANES + j] = z1
            normals[row + 2 * LANES + j] = z2
            normals[row + 3 * LANES + j] = z3


@scalar
def draw_constants(key, first, rows, constants):
    """Normals per lane for what a realization draws once; ``rows`` is a multiple of four."""
    draw_normals(key, first, CONSTANTS, rows, constants)


@scalar
def take_constants(given, start, filled, rows, constants):
    """The same from an array (rows, count), for the realizations ``start`` and following."""
    for row in range(rows):
        for j in range(filled):
            constants[row * LANES + j] = given[row, start + j]


@scalar
def draw_group(random_state, normals):
    """Twelve normals per lane: three channels of ``GROUP`` samples.

    Unrolled by hand; in a loop over pairs LLVM does not vectorise over lanes.
    """
    for j in range(LANES):
        s0 = random_state[j]
        s1 = random_state[LANES + j]
        s2 = random_state[2 * LANES + j]
        s3 = random_state[3 * LANES + j]
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[j], normals[LANES + j] = normal_pair(a, b)
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[2 * LANES + j], normals[3 * LANES + j] = normal_pair(a, b)
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[4 * LANES + j], normals[5 * LANES + j] = normal_pair(a, b)
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[6 * LANES + j], normals[7 * LANES + j] = normal_pair(a, b)
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[8 * LANES + j], normals[9 * LANES + j] = normal_pair(a, b)
        a, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        b, s0, s1, s2, s3 = xoshiro_next(s0, s1, s2, s3)
        normals[10 * LANES + j], normals[11 * LANES + j] = normal_pair(a, b)
        random_state[j] = s0
        random_state[LANES + j] = s1
        random_state[2 * LANES + j] = s2
        random_state[3 * LANES + j] = s3
