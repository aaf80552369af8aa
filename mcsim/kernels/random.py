"""Random numbers keyed by realization: Philox seeds one xoshiro128++ each.

A realization owns numbered *streams*.  The state of a stream is one Philox
block, ``philox(key, (realization, stream, block))``, so it depends on nothing
but the key, the realization's index and the stream's number: not on threads,
blocks, order, or how many other realizations exist.

* Philox4x32-10: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy
  as 1, 2, 3" (SC11), section 4.3.
* xoshiro128++ 1.0: Blackman, Vigna, "Scrambled linear pseudorandom number
  generators" (ACM TOMS 47, 2021).
* Normals: Box-Muller without branches in float32; the tail ends at 6.66 sigma.

All functions are scalar; kernels call them inside a loop over lanes, which
LLVM turns into vector instructions.
"""

from __future__ import annotations

import math

import numpy as np
from numba import float32, int32, uint32, uint64

from mcsim.kernels.compilation import scalar

_PHILOX_M0 = np.uint64(0xD2511F53)
_PHILOX_M1 = np.uint64(0xCD9E8D57)
_PHILOX_W0 = np.uint64(0x9E3779B9)
_PHILOX_W1 = np.uint64(0xBB67AE85)
_LOW32 = np.uint64(0xFFFFFFFF)
_SHIFT32 = np.uint64(32)

_HALF_TURN_PER_COUNT = np.float32(math.pi * 2.0**-32)
_MINUS_TWO_LN2 = np.float32(-2.0 * math.log(2.0))
#: Bits of sqrt(1/2) in float32, and of 2^32 sqrt(1/2).
_SQRT_HALF = np.int32(0x3F3504F3)
_SCALED_SQRT_HALF = np.int32(0x3F3504F3 + (32 << 23))
_MANTISSA = np.int32(0x7FFFFF)

# Polynomials fitted by iteratively reweighted least squares so that the largest
# error over the interval is smallest; tests/test_random.py measures them.
# -2 log(1 + x) = x (-2 + x (1 + x P(x))) for sqrt(1/2) <= 1 + x <= sqrt(2), relative
# error 3.2e-8; the list holds P.
_LOG = tuple(
    np.float32(-2.0 * c)
    for c in (
        0.3333391073777224,
        -0.25001337037293414,
        0.1996306377635913,
        -0.1657758469782377,
        0.1491476822659923,
        -0.14267486774473648,
        0.08700434526798363,
    )
)
# sin(x) = x S(x^2), relative error 5.4e-9; cos(x) = C(x^2), absolute error 4.7e-8; |x| <= pi/2
_SIN = tuple(
    np.float32(c)
    for c in (
        0.9999999946860089,
        -0.16666656684006798,
        0.008333025138960927,
        -0.00019807418727011848,
        2.6019030671452135e-06,
    )
)
_COS = tuple(
    np.float32(c)
    for c in (
        0.9999999534666658,
        -0.49999905347070356,
        0.041663584692980336,
        -0.0013853704307406794,
        2.3153931642230535e-05,
    )
)


@scalar
def philox4x32(c0, c1, c2, c3, k0, k1):
    """Ten rounds of Philox4x32 on 32-bit values held in uint64; four words back."""
    for _ in range(10):
        p0 = _PHILOX_M0 * c0
        p1 = _PHILOX_M1 * c2
        c0 = (p1 >> _SHIFT32) ^ c1 ^ k0
        c1 = p1 & _LOW32
        c2 = (p0 >> _SHIFT32) ^ c3 ^ k1
        c3 = p0 & _LOW32
        k0 = (k0 + _PHILOX_W0) & _LOW32
        k1 = (k1 + _PHILOX_W1) & _LOW32
    return c0, c1, c2, c3


@scalar
def stream_words(key, realization, stream, block):
    """The four 32-bit words of one block of a realization's stream.

    ``key`` and ``realization`` are uint64, ``stream`` and ``block`` below 2^32.
    """
    w0, w1, w2, w3 = philox4x32(
        realization & _LOW32,
        realization >> _SHIFT32,
        uint64(stream),
        uint64(block),
        key & _LOW32,
        key >> _SHIFT32,
    )
    return uint32(w0), uint32(w1), uint32(w2), uint32(w3)


@scalar
def _rotate_left(x, k):
    return uint32(x << uint32(k)) | uint32(x >> uint32(32 - k))


@scalar
def xoshiro_next(s0, s1, s2, s3):
    """One step of xoshiro128++: the output word and the four words of the new state."""
    word = uint32(_rotate_left(uint32(s0 + s3), 7) + s0)
    t = uint32(s1 << uint32(9))
    s2 = uint32(s2 ^ s0)
    s3 = uint32(s3 ^ s1)
    s1 = uint32(s1 ^ s2)
    s0 = uint32(s0 ^ s3)
    s2 = uint32(s2 ^ t)
    s3 = _rotate_left(s3, 11)
    return word, s0, s1, s2, s3


@scalar
def minus_two_log(word):
    """-2 ln(u) in float32 for u = (word | 1) / 2^32: the centres of 2^31 equal bins."""
    bits = np.float32(uint32(word | uint32(1))).view(np.int32)
    # Split u = 2^exponent * m with sqrt(1/2) <= m < sqrt(2).
    shifted = int32(bits - _SCALED_SQRT_HALF)
    exponent = float32(int32(shifted >> int32(23)))
    x = np.int32((shifted & _MANTISSA) + _SQRT_HALF).view(np.float32) - float32(1.0)
    p = _LOG[6]
    p = p * x + _LOG[5]
    p = p * x + _LOG[4]
    p = p * x + _LOG[3]
    p = p * x + _LOG[2]
    p = p * x + _LOG[1]
    p = p * x + _LOG[0]
    p = p * x + float32(1.0)
    p = p * x + float32(-2.0)
    return p * x + exponent * _MINUS_TWO_LN2


@scalar
def normal_pair(word_radius, word_angle):
    """Two independent standard normals (float32) from two 32-bit words (Box-Muller).

    The angle lies in -pi/2 ... pi/2; the second word's lowest bit, which is far below
    the angle's resolution in float32, is the sign that completes the circle.
    """
    r = np.float32(np.sqrt(minus_two_log(word_radius)))
    r = np.uint32(r.view(np.uint32) | uint32(word_angle << uint32(31))).view(np.float32)
    a = float32(int32(word_angle)) * _HALF_TURN_PER_COUNT
    a2 = a * a
    s = _SIN[4]
    s = s * a2 + _SIN[3]
    s = s * a2 + _SIN[2]
    s = s * a2 + _SIN[1]
    s = s * a2 + _SIN[0]
    c = _COS[4]
    c = c * a2 + _COS[3]
    c = c * a2 + _COS[2]
    c = c * a2 + _COS[1]
    c = c * a2 + _COS[0]
    return r * c, r * (s * a)
