"""Estimates and intervals: closed forms, scipy's bootstrap, measured coverage, edge cases."""

import math

import numpy as np
import pytest
from scipy import stats

from mcsim.statistics import (
    KEPT,
    MOST_ITEMS,
    Collector,
    Reference,
    estimate,
    estimate_errors,
)

SAMPLE = np.random.default_rng(42).gamma(3.0, 1.0, (1, 800)) - 2.0


def rms(x, axis=-1):
    return np.sqrt(np.mean(x**2, axis=axis))


def test_values_are_numpys():
    errors = np.random.default_rng(0).standard_normal((3, 501))
    value = estimate_errors(errors, 3.0, 500, 1).value
    np.testing.assert_allclose(value[:, 0], errors.mean(axis=1), rtol=1e-12)
    np.testing.assert_allclose(value[:, 1], errors.std(axis=1), rtol=1e-12)
    np.testing.assert_allclose(value[:, 2], rms(errors), rtol=1e-12)
    np.testing.assert_allclose(value[:, 3], np.median(errors, axis=1), rtol=1e-12)
    np.testing.assert_allclose(value[:, 4], np.quantile(errors, 0.95, axis=1), rtol=1e-12)


def test_rms_squared_is_mean_squared_plus_variance():
    value = estimate_errors(SAMPLE, 3.0, 500, 1).value[0]
    assert value[2] ** 2 == pytest.approx(value[0] ** 2 + value[1] ** 2, rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("sigmas", [2.0, 3.0])
@pytest.mark.parametrize(("index", "statistic"), [(0, np.mean), (1, np.std), (2, rms)])
def test_intervals_agree_with_scipys_bca_bootstrap(sigmas, index, statistic):
    """A skewed sample. 20,000 resamples leave about 0.03 sigma of noise in each end."""
    ours = estimate_errors(SAMPLE, sigmas, 20_000, 7)
    level = 2 * stats.norm.cdf(sigmas) - 1
    theirs = stats.bootstrap(
        SAMPLE,
        statistic,
        confidence_level=level,
        n_resamples=20_000,
        batch=1000,
        method="BCa",
        rng=np.random.default_rng(1),
    ).confidence_interval
    sigma = (theirs.high - theirs.low) / (2 * sigmas)
    assert ours.low[0, index] == pytest.approx(theirs.low, abs=0.25 * sigma)
    assert ours.high[0, index] == pytest.approx(theirs.high, abs=0.25 * sigma)


@pytest.mark.parametrize("sigmas", [1.0, 2.0, 3.0])
@pytest.mark.parametrize(("index", "p"), [(3, 0.5), (4, 0.95)])
def test_percentile_intervals_are_scipys_exact_ones(sigmas, index, p):
    """scipy.stats.quantile_test inverts one-sided tests: ask it for each end alone."""
    ours = estimate_errors(SAMPLE, sigmas, 500, 7)
    level = stats.norm.cdf(sigmas)
    low = stats.quantile_test(SAMPLE[0], p=p, alternative="greater").confidence_interval(level)
    high = stats.quantile_test(SAMPLE[0], p=p, alternative="less").confidence_interval(level)
    ordered = np.sort(SAMPLE[0])
    for end, theirs in ((ours.low, low.low), (ours.high, high.high)):
        rank, expected = np.searchsorted(ordered, [end[0, index], theirs])
        assert rank == expected


def coverage(n: int, sigmas: float, trials: int, shrink: float = 1.0) -> np.ndarray:
    """How often the intervals hold the truth; normal errors with mean 1 and deviation 2."""
    truth = [1.0, 2.0, math.sqrt(5.0), 1.0, 1.0 + 2.0 * stats.norm.ppf(0.95)]
    rng = np.random.default_rng(2)
    hits = np.zeros(len(truth))
    for _ in range(trials // 50):
        e = estimate_errors(1.0 + 2.0 * rng.standard_normal((50, n)), sigmas, 500, 3)
        low = e.value - shrink * (e.value - e.low)
        high = e.value + shrink * (e.high - e.value)
        hits += np.sum((low <= truth) & (truth <= high), axis=0)
    return hits


TRIALS = 2000


@pytest.mark.slow
@pytest.mark.parametrize("n", [300, 5000])
def test_coverage_at_two_sigma(n):
    """Binomial bounds at 1e-5; the bootstrap's own error at n = 300 is allowed one percent."""
    level = 2 * stats.norm.cdf(2.0) - 1
    hits = coverage(n, 2.0, TRIALS)
    least = stats.binom.ppf(1e-5, TRIALS, level - 0.01)
    most = stats.binom.ppf(1 - 1e-5, TRIALS, min(level + 0.015, 1.0))
    assert np.all(hits >= least), hits / TRIALS
    assert np.all(hits <= most), hits / TRIALS


def test_coverage_at_three_sigma():
    level = 2 * stats.norm.cdf(3.0) - 1
    hits = coverage(1000, 3.0, TRIALS)
    assert np.all(hits >= stats.binom.ppf(1e-5, TRIALS, level - 0.002)), hits / TRIALS


def test_coverage_control_must_fail():
    """Intervals a third too narrow are noticed by the same bound."""
    level = 2 * stats.norm.cdf(2.0) - 1
    hits = coverage(300, 2.0, TRIALS, shrink=0.7)
    assert np.all(hits < stats.binom.ppf(1e-5, TRIALS, level - 0.01))


def test_groups_give_the_width_that_single_items_give():
    """Beyond MOST_ITEMS groups are resampled: the width follows 1/sqrt(n) across the border."""
    rng = np.random.default_rng(9)
    widths = []
    for n in (MOST_ITEMS, 4 * MOST_ITEMS):
        e = estimate_errors(rng.standard_normal((20, n)), 3.0, 2000, 1)
        widths.append(np.mean(e.high[:, :3] - e.low[:, :3], axis=0))
    np.testing.assert_allclose(widths[0] / widths[1], 2.0, rtol=0.06)


def test_equal_errors_have_intervals_of_no_width():
    e = estimate_errors(np.full((1, 100), -0.1), 3.0, 500, 1)
    np.testing.assert_array_equal(e.value[0], [-0.1, 0.0, 0.1, -0.1, -0.1])
    np.testing.assert_array_equal(e.low, e.value)
    np.testing.assert_array_equal(e.high, e.value)
    assert e.degenerate.tolist() == [True]


def test_all_zero_errors():
    e = estimate_errors(np.zeros((2, 50)), 3.0, 500, 1)
    assert not np.any(e.value)
    assert not np.any(e.high)


def test_one_realization_has_values_and_no_intervals():
    e = estimate_errors(np.array([[0.5], [-2.0]]), 3.0, 500, 1)
    np.testing.assert_array_equal(e.value[:, 0], [0.5, -2.0])
    np.testing.assert_array_equal(e.value[:, 2], [0.5, 2.0])
    assert np.isnan(e.low).all()
    assert np.isnan(e.high).all()


def test_undefined_errors_stay_undefined():
    errors = np.random.default_rng(0).standard_normal((2, 100))
    errors[1] = np.nan
    e = estimate_errors(errors, 3.0, 500, 1)
    assert np.isfinite(e.value[0]).all()
    assert np.isnan(e.value[1]).all()
    assert not e.degenerate.any()


@pytest.mark.parametrize("n", [2, 3, 10])
def test_few_realizations_never_crash_and_never_cross(n):
    e = estimate_errors(np.random.default_rng(n).standard_normal((5, n)), 3.0, 500, 1)
    assert np.all(e.low <= e.value)
    assert np.all(e.value <= e.high)
    assert np.all(e.low[:, 1:3] >= 0.0)


def test_an_outlier_does_not_break_the_acceleration():
    errors = np.zeros((1, 1000))
    errors[0, 0] = 1e6
    e = estimate_errors(errors, 3.0, 500, 1)
    assert np.isfinite([e.low, e.high]).all()


def test_streams_of_any_length_keep_exact_percentiles():
    """Beyond KEPT realizations only those near a percentile are kept: numpy agrees exactly."""
    errors = np.random.default_rng(5).standard_normal((2, KEPT + 70_000))
    e = estimate_errors(errors, 3.0, 200, 1)
    np.testing.assert_allclose(e.value[:, 3], np.median(errors, axis=1), rtol=1e-12)
    np.testing.assert_allclose(e.value[:, 4], np.quantile(errors, 0.95, axis=1), rtol=1e-12)
    np.testing.assert_allclose(e.value[:, 2], rms(errors), rtol=1e-12)
    ordered = np.sort(errors[0])
    for end in (e.low[0, 4], e.high[0, 4]):
        assert end in ordered


def test_pieces_and_their_order_do_not_matter():
    """Cells are summed whole, whatever piece they come in; percentiles are sorted."""
    errors = np.random.default_rng(6).standard_normal((1, 3 * KEPT))
    none = np.empty((1, 0))
    results = []
    for piece, backwards in ((4096, False), (8192, False), (4096, True)):
        c = Collector(errors.shape[1], Reference(np.zeros(1)))
        early = list(range(0, KEPT, piece))
        late = list(range(KEPT, errors.shape[1], piece))
        if backwards:
            early, late = early[::-1], late[::-1]
        for first in early + late:
            c.add(first, np.ascontiguousarray(errors[:, first : first + piece]), none)
        results.append(estimate(c, 3.0, 200, 1))
    for other in results[1:]:
        for name in ("value", "low", "high"):
            assert np.array_equal(getattr(results[0], name), getattr(other, name))


def test_scatter_of_rounding_alone_has_no_width_and_no_warnings():
    errors = -17.6 * (1.0 + 1.2e-16 * (np.arange(2000) % 3))[None]
    assert len(np.unique(errors)) > 1
    e = estimate_errors(errors, 3.0, 200, 1)
    np.testing.assert_allclose(e.high - e.low, 0.0, atol=1e-13)
