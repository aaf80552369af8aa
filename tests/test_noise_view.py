"""Distribution, autocorrelation and course of the bias of a log."""

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter

from mcsim.characterisation.autocorrelation import autocorrelation_of, autocovariance
from mcsim.characterisation.bias import SMOOTHING, smooth
from mcsim.characterisation.course import bias_course, kalman_deviation
from mcsim.characterisation.normality import fast_part, histogram, is_coarse, normality
from mcsim.characterisation.process import GaussMarkov
from tests.reference.noise import gauss_markov

RATE, N = 50.0, 10_000


def white(generator, n=N):
    return generator.standard_normal(n)


def rounded(generator):
    return np.round(white(generator) / 1.33 + 0.4) * 1.33


def filtered(generator):
    return lfilter([1.0], [1.0, -0.9], white(generator))


def wandering(generator):
    return white(generator) + 0.02 * np.cumsum(white(generator))


def test_white_noise_has_the_k_squared_of_scipy():
    """The correlation of white noise is taken from the sample: it changes n by some 1e-4."""
    for seed in range(5):
        noise = white(np.random.default_rng(seed), 50_000)
        ours, theirs = normality(noise), stats.normaltest(noise)
        assert ours.statistic == pytest.approx(theirs.statistic, rel=2e-3)
        assert ours.p == pytest.approx(theirs.pvalue, rel=5e-3)
        assert ours.skewness == pytest.approx(stats.skew(noise))
        assert ours.excess == pytest.approx(stats.kurtosis(noise))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "step", "naive"),
    [(white, None, 0.05), (filtered, None, 0.5), (wandering, None, 0.5), (rounded, 1.33, 0.05)],
)
def test_a_normal_log_is_rejected_as_rarely_as_the_level_says(make, step, naive):
    """Level 5 %, 200 logs: ± 0.0154.  The control is the same test without regard for
    correlation: it rejects more than half of the logs that are low-passed, or wander."""
    logs = [make(np.random.default_rng(seed)) for seed in range(200)]
    rejected = np.mean([normality(fast_part(log, RATE), step).p < 0.05 for log in logs])
    assert rejected == pytest.approx(0.05, abs=3 * 0.0154)
    assert np.mean([stats.normaltest(log).pvalue < 0.05 for log in logs]) > naive - 3 * 0.0154


def test_a_histogram_test_rejects_what_is_only_rounded():
    """The control of rounding: Kolmogorov and Smirnov's test of the same log."""
    log = rounded(np.random.default_rng(1))
    assert normality(fast_part(log, RATE), 1.33).is_normal
    assert stats.kstest(log / log.std(), "norm").pvalue < 1e-9


def test_noise_that_is_not_normal_is_called_so():
    generator = np.random.default_rng(2)
    found = normality(fast_part(generator.standard_t(10, N), RATE))
    assert not found.is_normal
    # Student's t with ν degrees of freedom has the excess 6 / (ν - 4).
    assert found.excess == pytest.approx(1.0, abs=0.3)
    skewed = normality(fast_part(generator.gamma(100.0, size=N), RATE))
    assert not skewed.is_normal
    assert skewed.skewness == pytest.approx(2.0 / np.sqrt(100.0), abs=4 * skewed.u_skewness)


def test_rounding_takes_nothing_from_the_moments():
    """Skewness of the noise before it was rounded, by Sheppard's corrections."""
    noise = np.random.default_rng(3).gamma(25.0, size=400_000) / 5.0
    found = normality(np.round(noise / 1.2) * 1.2, 1.2)
    assert found.skewness == pytest.approx(0.4, abs=4 * found.u_skewness)
    assert found.excess == pytest.approx(0.24, abs=6 * found.u_excess)


def test_steps_that_are_too_coarse_are_told():
    noise = white(np.random.default_rng(4))
    assert is_coarse(np.round(noise / 2.0) * 2.0, 2.0)
    assert not is_coarse(np.round(noise) * 1.0, 1.0)
    assert not is_coarse(noise, None)


def test_bins_hold_whole_steps_and_every_sample():
    noise = rounded(np.random.default_rng(5))
    found = histogram(noise, 1.33)
    assert found.counts.sum() == len(noise)
    assert np.diff(found.edges) / 1.33 == pytest.approx(np.round(np.diff(found.edges) / 1.33))
    assert found.expected.sum() == pytest.approx(len(noise), rel=1e-3)
    fine = histogram(white(np.random.default_rng(6)))
    chance = np.sum((fine.counts - fine.expected) ** 2 / np.maximum(fine.expected, 1.0))
    assert chance < 2.0 * len(fine.counts)


def test_autocovariance_is_that_of_numpy():
    values = np.random.default_rng(7).standard_normal(300).cumsum()
    centred = values - values.mean()
    expected = np.correlate(centred, centred, "full")[299:] / 300
    np.testing.assert_allclose(autocovariance(values), expected, atol=1e-10)
    np.testing.assert_allclose(autocovariance(values, 20), expected[:21], atol=1e-10)


def test_the_band_holds_95_per_cent_where_the_correlation_has_ended():
    """A moving average of five samples: beyond lag 4 nothing is correlated.  The control is the
    band of white noise, 1.96 / √n, which is too narrow here."""
    inside, control = [], []
    for seed in range(300):
        noise = np.convolve(white(np.random.default_rng(seed), 2000), np.ones(5), "valid")
        found = autocorrelation_of(noise, 1.0, 5, 200)
        inside.append(np.abs(found.values) < found.band)
        control.append(np.abs(found.values) < 1.96 / np.sqrt(len(noise)))
    assert np.mean(inside) == pytest.approx(0.95, abs=0.02)
    assert np.mean(control) < 0.80


def test_lags_are_in_seconds_and_begin_at_the_shortest():
    found = autocorrelation_of(white(np.random.default_rng(8)), 0.02, 1, 500)
    assert found.lags[0] == 0.02
    assert found.lags[-1] == pytest.approx(10.0)
    assert found.variance == pytest.approx(1.0, abs=0.05)


MODEL = GaussMarkov(20.0, 0.4)


def test_the_filters_deviation_is_that_of_the_recursion():
    decay, noise = np.exp(-1.0 / (RATE * MODEL.correlation_time)), 0.7
    p, after = MODEL.deviation**2, []
    for k in range(500):
        p = p if k == 0 else decay**2 * p + MODEL.deviation**2 * (1.0 - decay**2)
        p = p * noise**2 / (p + noise**2)
        after.append(np.sqrt(p))
    found = kalman_deviation(MODEL, noise, RATE, np.arange(1.0, 501.0))
    np.testing.assert_allclose(found, after, rtol=1e-9)


def test_the_band_of_the_tracked_bias_holds_it_in_95_per_cent_of_the_time():
    """40 logs of 2000 s, 100 correlation times each: the share scatters by less than 0.01.  The
    control is the filter's own deviation taken for a band."""
    inside, control = [], []
    for seed in range(40):
        generator = np.random.default_rng(seed)
        bias = gauss_markov(MODEL.correlation_time, MODEL.deviation, RATE, 100_000, generator)
        log = bias + 0.1 * np.sqrt(RATE) * white(generator, len(bias))
        found = bias_course(log, RATE, 0.1, SMOOTHING, MODEL)
        at = np.round(found.time * RATE).astype(int) - 1
        error = np.abs(found.tracked - (bias[at] - log.mean()))
        inside.append(error < found.tracked_band)
        control.append(error < found.tracked_band / 1.96)
    assert np.mean(inside) == pytest.approx(0.95, abs=0.015)
    assert np.mean(control) < 0.75


def test_the_measured_bias_is_the_moving_average():
    log = np.random.default_rng(9).standard_normal(30_000)
    found = bias_course(log, RATE, 1.0 / np.sqrt(RATE), SMOOTHING, None)
    np.testing.assert_array_equal(found.measured, smooth(log, RATE).values[::1])
    assert found.tracked is None
    assert np.mean(np.abs(found.measured) < found.measured_band) == pytest.approx(0.95, abs=0.05)
    assert found.time[0] == SMOOTHING / 2.0
