"""Generator, normals and streams against published answers and exact functions."""

import math

import numpy as np
import pytest
from numba import njit, uint64

from mcsim.kernels import random as kernel_random
from tests.reference import random_numpy


@njit
def philox(c0, c1, c2, c3, k0, k1):
    return kernel_random.philox4x32(
        uint64(c0), uint64(c1), uint64(c2), uint64(c3), uint64(k0), uint64(k1)
    )


@njit
def xoshiro_words(a, b, c, d, count):
    words = np.empty(count, np.uint32)
    for i in range(count):
        words[i], a, b, c, d = kernel_random.xoshiro_next(a, b, c, d)
    return words


@njit
def pairs(radius_words, angle_words):
    z = np.empty((2, len(radius_words)), np.float32)
    for i in range(len(radius_words)):
        z[0, i], z[1, i] = kernel_random.normal_pair(radius_words[i], angle_words[i])
    return z


@njit
def logarithms(words):
    result = np.empty(len(words), np.float32)
    for i in range(len(words)):
        result[i] = kernel_random.minus_two_log(words[i])
    return result


@pytest.mark.parametrize(
    ("counter", "key", "words"),
    [
        # Known answers of the Random123 distribution (kat_vectors, philox4x32 10).
        ((0,) * 4, (0,) * 2, (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
        (
            (0xFFFFFFFF,) * 4,
            (0xFFFFFFFF,) * 2,
            (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD),
        ),
        (
            (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
            (0xA4093822, 0x299F31D0),
            (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
        ),
    ],
)
def test_philox_known_answers(counter, key, words):
    assert philox(*counter, *key) == words
    assert tuple(int(w) for w in random_numpy.philox(counter, key)) == words


def test_xoshiro_known_answers():
    """First words from state 1, 2, 3, 4, as published with the reference C code's ports."""
    state = [np.uint32(i) for i in (1, 2, 3, 4)]
    known = [
        641, 1573767, 3222811527, 3517856514, 836907274,
        4247214768, 3867114732, 1355841295, 495546011, 621204420,
    ]  # fmt: skip
    assert xoshiro_words(*state, 10).tolist() == known


def test_logarithm_is_accurate_to_float32_over_all_words():
    words = np.concatenate(
        [
            np.arange(0, 2**12),
            np.arange(2**32 - 2**12, 2**32),
            np.random.default_rng(0).integers(0, 2**32, 1_000_000),
        ]
    ).astype(np.uint32)
    exact = -2.0 * np.log((words | np.uint32(1)).astype(float) / 2.0**32)
    # Near u = 1 float32 cannot hold u itself: an absolute error of 2 * 2^-24 remains.
    np.testing.assert_allclose(logarithms(words), exact, rtol=3e-7, atol=2.5e-7)


def test_normals_agree_with_exact_functions():
    rng = np.random.default_rng(1)
    radius, angle = rng.integers(0, 2**32, (2, 500_000)).astype(np.uint32)
    exact = random_numpy.normal_pair(radius.astype(np.uint64), angle.astype(np.uint64))
    error = np.abs(pairs(radius, angle) - np.array(exact))
    # -2 ln(u) errs by 2.5e-7 where u is near 1, its root r by 1.25e-7 / r.
    assert (error < 1e-6 + 1.25e-7 / np.hypot(*exact)).all()
    assert np.sqrt(np.mean(error**2)) < 2e-7


N = 2_000_000


@pytest.fixture(scope="module")
def normals():
    """Two rows of N normals each, from one long stream."""
    words = xoshiro_words(*(np.uint32(i) for i in (11, 22, 33, 44)), 2 * N)
    return pairs(words[::2], words[1::2]).astype(float)


def test_moments_of_normals(normals):
    """Raw moments to the 8th order: 0, 1, 0, 3, 0, 15, 0, 105, each within 5 standard errors."""
    z = normals.ravel()
    for order in range(1, 9):
        expected = 0.0 if order % 2 else math.prod(range(1, order, 2))
        variance = math.prod(range(1, 2 * order, 2)) - expected**2
        standard_error = math.sqrt(variance / len(z))
        assert abs(np.mean(z**order) - expected) < 5 * standard_error, order


def test_pairs_are_independent(normals):
    """Products, and products of squares, of the two normals of a pair and of neighbours."""
    x, y = normals
    for a, b in ((x, y), (x[:-1], x[1:]), (y[:-1], x[1:]), (x[:-2], y[2:])):
        assert abs(np.mean(a * b)) < 5 / math.sqrt(len(a))
        # Var(a^2 b^2) = 9 - 1
        assert abs(np.mean(a**2 * b**2) - 1.0) < 5 * math.sqrt(8 / len(a))


def test_uniformity_control_fails_for_biased_normals(normals):
    """The same moment test rejects normals whose spread is off by half a percent."""
    z = 1.005 * normals.ravel()
    assert abs(np.mean(z**2) - 1.0) > 5 * math.sqrt(2 / len(z))


def test_angles_fill_the_circle_evenly(normals):
    """Chi-square over 64 sectors; a shared or stuck sign bit would empty half of them."""
    angle = np.arctan2(normals[1], normals[0])
    counts, _ = np.histogram(angle, bins=64, range=(-np.pi, np.pi))
    chi2 = np.sum((counts - N / 64) ** 2 / (N / 64))
    # 63 degrees of freedom: mean 63, deviation sqrt(126); five deviations.
    assert chi2 < 63 + 5 * math.sqrt(126)


def test_streams_of_neighbouring_realizations_do_not_correlate():
    noise = random_numpy.white_noise(7, np.arange(400), 500).reshape(-1, 400)
    correlation = np.corrcoef(noise.T)
    off_diagonal = correlation[np.triu_indices(400, 1)]
    # 1500 values each: deviation 1/sqrt(1500); 79,800 pairs stay within 5.5 of it.
    assert np.abs(off_diagonal).max() < 5.5 / math.sqrt(1500)
    assert abs(off_diagonal.std() * math.sqrt(1500) - 1.0) < 0.02
