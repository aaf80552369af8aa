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


@pytest.mark.slow
def test_xoshiro_known_answers():
    """First words from state 1, 2, 3, 4, as published with the reference C code's ports."""
    state = [np.uint32(i) for i in (1, 2, 3, 4)]
    known = [
        641, 1573767, 3222811527, 3517856514, 836907274,
        4247214768, 3867114732, 1355841295, 495546011, 621204420,
    ]  # fmt: skip
    assert xoshiro_words(*state, 10).tolist() == known


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_moments_of_normals(normals):
    """Raw moments to the 8th order: 0, 1, 0, 3, 0, 15, 0, 105, each within 5 standard errors."""
    z = normals.ravel()
    for order in range(1, 9):
        expected = 0.0 if order % 2 else math.prod(range(1, order, 2))
        variance = math.prod(range(1, 2 * order, 2)) - expected**2
        standard_error = math.sqrt(variance / len(z))
        assert abs(np.mean(z**order) - expected) < 5 * standard_error, order


@pytest.mark.slow
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


REALIZATIONS, SAMPLES = 100_000, 336  # three channels: 100.8 million normals
BINS, REACH = 400, 8.0


@njit(nogil=True)
def survey(key, realizations, samples):
    """Sums over the white noise of many realizations, drawn as the planar kernel draws it.

    Channel k of sample i is normal 3 i + k of the realization's stream.
    """
    powers = np.zeros((3, 9))
    cross = np.zeros((3, 3, 2))
    serial = np.zeros((3, 2))
    histogram = np.zeros((3, BINS), np.int64)
    z = np.zeros(3)
    before = np.zeros(3)
    for r in range(realizations):
        s0, s1, s2, s3 = kernel_random.stream_words(uint64(key), uint64(r), 0, 0)
        spare = 0.0
        has_spare = False
        for i in range(samples):
            for k in range(3):
                if has_spare:
                    z[k] = spare
                    has_spare = False
                else:
                    a, s0, s1, s2, s3 = kernel_random.xoshiro_next(s0, s1, s2, s3)
                    b, s0, s1, s2, s3 = kernel_random.xoshiro_next(s0, s1, s2, s3)
                    first, second = kernel_random.normal_pair(a, b)
                    z[k] = first
                    spare = second
                    has_spare = True
                power = 1.0
                for order in range(9):
                    powers[k, order] += power
                    power *= z[k]
                place = int((z[k] + REACH) / (2 * REACH) * BINS)
                histogram[k, min(max(place, 0), BINS - 1)] += 1
            for k in range(3):
                for m in range(k):
                    cross[k, m, 0] += z[k] * z[m]
                    cross[k, m, 1] += z[k] ** 2 * z[m] ** 2 - 1.0
                if i > 0:
                    serial[k, 0] += z[k] * before[k]
                    serial[k, 1] += z[k] ** 2 * before[k] ** 2 - 1.0
            before[:] = z
    return powers, cross, serial, histogram


@pytest.fixture(scope="module")
def surveyed():
    return survey(2026, REALIZATIONS, SAMPLES)


@pytest.mark.slow
def test_survey_draws_what_the_twin_draws():
    """The survey's first moments over a few realizations equal those of the numpy twin."""
    powers, *_ = survey(5, 20, 50)
    twin = random_numpy.white_noise(5, np.arange(20), 50)
    np.testing.assert_allclose(powers[:, 1], twin.sum(axis=(0, 2)), rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(powers[:, 2], (twin**2).sum(axis=(0, 2)), rtol=1e-5)


@pytest.mark.slow
def test_moments_to_the_eighth_order_of_a_hundred_million(surveyed):
    n = REALIZATIONS * SAMPLES
    for channel in surveyed[0]:
        assert channel[0] == n
        for order in range(1, 9):
            expected = 0.0 if order % 2 else math.prod(range(1, order, 2))
            error = math.sqrt((math.prod(range(1, 2 * order, 2)) - expected**2) / n)
            assert abs(channel[order] / n - expected) < 5 * error, order


@pytest.mark.slow
def test_channels_and_neighbours_of_a_hundred_million_are_independent(surveyed):
    _, cross, serial, _ = surveyed
    n = REALIZATIONS * SAMPLES
    pairs_of_channels = [cross[k, m] for k in range(3) for m in range(k)]
    for product, squares in (*pairs_of_channels, *serial):
        assert abs(product) < 5 * math.sqrt(n)
        # Var(z^2 y^2) = 9 - 1
        assert abs(squares) < 5 * math.sqrt(8 * n)


@pytest.mark.slow
def test_distribution_and_tails_of_a_hundred_million(surveyed):
    """Chi-square over bins of 0.04 sigma, and the counts beyond 4, 5 and 6 sigma."""
    from scipy.stats import chi2, norm, poisson

    histogram = surveyed[3].sum(axis=0)
    n = histogram.sum()
    edges = np.linspace(-REACH, REACH, BINS + 1)
    expected = n * np.diff(norm.cdf(edges))
    inner = expected > 50
    statistic = np.sum((histogram[inner] - expected[inner]) ** 2 / expected[inner])
    assert chi2.sf(statistic, inner.sum()) > 1e-5
    for sigmas in (4.0, 5.0, 6.0):
        beyond = histogram[np.abs(edges[:-1] + edges[1:]) / 2 > sigmas].sum()
        mean = 2 * n * norm.sf(sigmas)
        assert poisson.ppf(1e-5, mean) <= beyond <= poisson.isf(1e-5, mean), sigmas


def test_variance_of_the_normals_is_one_to_a_ten_millionth():
    """Control variates rest on it. Midpoints of equal bins integrate both factors exactly."""
    words = (np.arange(2**22, dtype=np.uint64) * 2**10 + 2**9).astype(np.uint32)
    radius_squared = logarithms(words).astype(float)
    exact = -2.0 * np.log((words | np.uint32(1)).astype(float) / 2.0**32)
    assert abs(np.mean(radius_squared - exact)) < 1e-7
    one = np.full(len(words), np.uint32(0x5E2D58D9))  # a radius of about one
    z = pairs(one, words).astype(float)
    scale = float(logarithms(one[:1])[0])
    assert abs(np.mean(z[0] ** 2) / scale - 0.5) < 1e-7
    assert abs(np.mean(z[1] ** 2) / scale - 0.5) < 1e-7
