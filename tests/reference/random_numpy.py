"""The project's random numbers written again, in plain numpy, from the papers.

Philox4x32-10 (Salmon et al., SC11), xoshiro128++ (Blackman & Vigna), Box-Muller with
the exact logarithm, sine and cosine in float64.
"""

from __future__ import annotations

import numpy as np

MASK = np.uint64(0xFFFFFFFF)


def philox(counter, key):
    """Counter (4, …) and key (2,) of 32-bit words to four words."""
    c = [np.asarray(x, np.uint64) for x in counter]
    k = [np.uint64(x) for x in key]
    for _ in range(10):
        a = np.uint64(0xD2511F53) * c[0]
        b = np.uint64(0xCD9E8D57) * c[2]
        c = [
            (b >> np.uint64(32)) ^ c[1] ^ k[0],
            b & MASK,
            (a >> np.uint64(32)) ^ c[3] ^ k[1],
            a & MASK,
        ]
        k = [(k[0] + np.uint64(0x9E3779B9)) & MASK, (k[1] + np.uint64(0xBB67AE85)) & MASK]
    return c


def stream_words(key: int, realizations, stream: int, block: int):
    r = np.asarray(realizations, np.uint64)
    counter = (r & MASK, r >> np.uint64(32), np.full_like(r, stream), np.full_like(r, block))
    return philox(counter, (key & 0xFFFFFFFF, key >> 32))


def _rotate(x, k):
    return ((x << np.uint64(k)) | (x >> np.uint64(32 - k))) & MASK


def xoshiro(state):
    """One step for every realization; the words, and the new state."""
    s0, s1, s2, s3 = state
    word = (_rotate((s0 + s3) & MASK, 7) + s0) & MASK
    t = (s1 << np.uint64(9)) & MASK
    s2 = s2 ^ s0
    s3 = s3 ^ s1
    s1 = s1 ^ s2
    s0 = s0 ^ s3
    s2 = s2 ^ t
    return word, [s0, s1, s2, _rotate(s3, 11)]


def normal_pair(radius_word, angle_word):
    """Box-Muller; the second word's lowest bit is also the sign that completes the circle."""
    u = (radius_word | np.uint64(1)).astype(float) / 2.0**32
    r = np.sqrt(-2.0 * np.log(u))
    r = np.where(angle_word & np.uint64(1), -r, r)
    word = angle_word.astype(np.int64)
    signed = np.where(word >= 2**31, word - 2**32, word)
    angle = signed * (np.pi / 2.0**32)
    return r * np.cos(angle), r * np.sin(angle)


def constants(key: int, realizations, stream: int = 1) -> np.ndarray:
    """The twelve normals that a realization draws once, (12, r)."""
    rows = []
    for block in range(3):
        w = stream_words(key, realizations, stream, block)
        rows += [*normal_pair(w[0], w[1]), *normal_pair(w[2], w[3])]
    return np.array(rows)


def white_noise(key: int, realizations, samples: int, stream: int = 0) -> np.ndarray:
    """White noise (samples, 3, r) of samples 1 ... n, four samples drawn at a time."""
    state = stream_words(key, realizations, stream, 0)
    rows = []
    for _ in range(-(-samples // 4) * 6):
        a, state = xoshiro(state)
        b, state = xoshiro(state)
        rows += normal_pair(a, b)
    return np.array(rows).reshape(-1, 3, len(realizations))[:samples]
