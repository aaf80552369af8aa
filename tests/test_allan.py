"""Allan variance, its scatter, and the coefficients fitted to it."""

import math
import warnings
from dataclasses import replace
from itertools import pairwise

import allantools
import numpy as np
import pytest
from scipy import integrate
from scipy.optimize import nnls
from scipy.signal import lfilter

from mcsim.characterisation.allan import (
    allan_curve,
    allan_terms,
    averaging_factors,
    covariances,
    degrees_of_freedom,
    gauss_markov_variance,
    intervals,
)
from mcsim.characterisation.bootstrap import drawn_blocks, resampled_variances
from mcsim.characterisation.comparison import compare
from mcsim.characterisation.fit import fit_noise
from mcsim.characterisation.nonnegative import nonnegative_squares
from mcsim.characterisation.problem import N, Problem
from mcsim.characterisation.process import GaussMarkov
from mcsim.characterisation.process_fit import settled
from mcsim.errors import InputError
from tests.reference.noise import THESIS, gauss_markov, in_si, static_noise

RATE = 100.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("overlapping", "theirs"), [(True, allantools.oadev), (False, allantools.adev)]
)
def test_deviations_are_those_of_allantools(overlapping, theirs):
    rng = np.random.default_rng(1)
    samples = 9.81 + static_noise(0.01, 0.003, 0.001, RATE, 50_000, rng)
    curve = allan_curve(samples, RATE, overlapping=overlapping)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the few clusters at the end
        tau, deviation, _, _ = theirs(samples, rate=RATE, data_type="freq", taus=curve.tau)
    known = np.isin(np.round(curve.tau * RATE), np.round(tau * RATE))
    assert np.count_nonzero(known) > 30
    np.testing.assert_allclose(curve.deviation[known], deviation, rtol=1e-9)


def test_cluster_times_hold_one_second_and_end_at_a_third():
    for rate in (100.0, 128.0, 3.0):
        factors = averaging_factors(10_000, rate)
        assert round(rate) in factors
        assert np.all(np.diff(factors) > 0)
        assert 2600 < factors[-1] <= 3333


@pytest.mark.slow
@pytest.mark.parametrize(("term", "alpha"), [(1, 0), (2, -1), (3, -2)])
def test_degrees_of_freedom_are_greenhalls(term, alpha):
    """allantools' edf_greenhall; short clusters differ, since flicker and random walk of the
    rate are taken as continuous here and as sampled there."""
    curve = allan_curve(np.random.default_rng(0).standard_normal(1 << 18), 1.0)
    squares = np.zeros(5)
    squares[term] = 1.0
    ours = degrees_of_freedom(curve, squares)
    if term == 1:
        # Clusters of one sample: differences of white noise, correlated by -1/2 with the next.
        assert ours[0] == pytest.approx((1 << 18) / 1.5, rel=1e-4)
    for index in (20, 26, 32, 40):
        theirs = allantools.edf_greenhall(
            alpha=alpha, d=2, m=int(curve.factors[index]), N=(1 << 18) + 1, overlapping=True
        )
        assert ours[index] == pytest.approx(theirs, rel=0.03)


def test_covariance_of_estimates_is_what_simulation_gives():
    """A mix of noises; 400 logs give each correlation to about 1/√400 = 0.05."""
    rng = np.random.default_rng(3)
    n, factors = 4000, np.array([1, 4, 16, 64, 256, 1000])
    mix = (1.0, 0.2, 0.01)
    curves = [
        allan_curve(static_noise(*mix, 1.0, n, rng), 1.0, factors).variance for _ in range(400)
    ]
    curve = allan_curve(np.arange(n) % 7.0, 1.0, factors)
    expected = covariances(curve).of(np.array([0.0, 1.0, 0.04, 1e-4]))
    measured = np.cov(np.array(curves).T)
    deviation = np.sqrt(np.diagonal(expected))
    # A deviation of so skewed values is known to 12 % at most times three.
    np.testing.assert_allclose(np.sqrt(np.diagonal(measured)), deviation, rtol=0.25)
    np.testing.assert_allclose(
        np.corrcoef(np.array(curves).T), expected / np.outer(deviation, deviation), atol=0.16
    )
    # Control: points taken as independent would miss the correlation of neighbours.
    assert np.corrcoef(np.array(curves).T)[4, 5] > 0.3


@pytest.mark.parametrize("overlapping", [True, False])
def test_chi_square_intervals_cover(overlapping):
    rng = np.random.default_rng(5)
    factors = np.array([1, 10, 100, 400])
    hits = np.zeros(4)
    for _ in range(400):
        curve = allan_curve(rng.standard_normal(2000), 1.0, factors, overlapping)
        degrees = degrees_of_freedom(curve, np.array([0.0, 1.0, 0.0, 0.0, 0.0]))
        low, high = intervals(curve, degrees, 0.9)
        truth = 1.0 / np.sqrt(curve.tau)
        hits += (low < truth) & (truth < high)
    # Four standard errors of a share of 0.9 in 400; without overlap they are wider than needed.
    assert np.all(hits / 400 > 0.9 - 4 * math.sqrt(0.09 / 400))
    if overlapping:
        assert np.all(hits / 400 < 0.9 + 4 * math.sqrt(0.09 / 400))


def two_sided_allan(density, tau):
    """Eq. (3.12) by numerical integration: 4 ∫ S(f) sin⁴(πfτ) / (πfτ)² df."""

    def integrand(logarithm):
        f = math.exp(logarithm)
        return f * 4.0 * density(f) * math.sin(math.pi * f * tau) ** 4 / (math.pi * f * tau) ** 2

    low, high = math.log(1e-7 / tau), math.log(40.0 / tau)
    edges = np.linspace(low, high, 400)
    return sum(integrate.quad(integrand, a, b)[0] for a, b in pairwise(edges))


@pytest.mark.parametrize("tau", [0.5, 3.0, 40.0])
def test_terms_follow_from_their_densities(tau):
    """Eq. (3.12) with the table's densities; the tail beyond 40/τ holds under 1 % of white."""
    omega = 2.0 * math.pi
    white, flicker, walk = allan_terms(np.array([tau]))[0, 1:4]
    assert two_sided_allan(lambda _: 1.0, tau) == pytest.approx(white, rel=0.01)
    assert two_sided_allan(lambda f: 1.0 / (omega * f), tau) == pytest.approx(flicker, rel=1e-3)
    assert two_sided_allan(lambda f: (omega * f) ** -2, tau) == pytest.approx(walk, rel=1e-3)
    process = gauss_markov_variance(np.array([tau]), 5.0)[0]
    density = lambda f: 25.0 / (1.0 + (omega * f * 5.0) ** 2)  # noqa: E731
    assert two_sided_allan(density, tau) == pytest.approx(process, rel=2e-3)


def test_gauss_markov_peaks_where_the_table_says():
    tau = np.geomspace(0.1, 100.0, 20_001)
    deviation = np.sqrt(gauss_markov_variance(tau, 5.0))
    peak = np.argmax(deviation)
    assert tau[peak] / 5.0 == pytest.approx(1.89, rel=0.003)
    assert deviation[peak] / math.sqrt(5.0) == pytest.approx(0.437, rel=0.002)
    # Short clusters, where the formula cancels: a random walk of strength 1.
    short = np.array([1e-4])
    assert gauss_markov_variance(short, 5.0)[0] == pytest.approx(1e-4 / 3.0, rel=1e-3)


@pytest.mark.slow
def test_a_day_at_100_hz_gives_back_its_coefficients():
    """14 h of the LSM9DS1's x axis: N within 1 %, B within 10 %, K inside of its interval."""
    truth = in_si(THESIS["LSM9DS1"][0])
    samples = static_noise(*truth, RATE, 14 * 3600 * 100, np.random.default_rng(7))
    fit = fit_noise(allan_curve(samples, RATE))
    assert fit["N"].value == pytest.approx(truth[0], rel=0.01)
    assert fit["B"].value == pytest.approx(truth[1], rel=0.1)
    assert fit["K"].low < truth[2] < fit["K"].high
    for term, value in zip("NB", truth[:2], strict=True):
        assert fit[term].low < value < fit[term].high
    # Control: the one-sided density is another number.
    assert math.sqrt(2.0) * fit["N"].value != pytest.approx(truth[0], rel=0.1)


def drawn_in(found, share):
    """The interval with its ends at a share of their distance from the value."""
    return [found.value + (end - found.value) * share for end in (found.low, found.high)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sensor", "axis", "intervals"),
    [("BNO055", 1, "covariance"), ("Xsens", 2, "covariance"), ("Xsens", 0, "bootstrap")],
)
def test_intervals_of_the_coefficients_cover(sensor, axis, intervals):
    """Logs of 14 h, sampled slowly since only long clusters scatter; 95 % intervals."""
    truth = in_si(THESIS[sensor][axis])
    rng = np.random.default_rng(11)
    trials, hits, narrow = 30, np.zeros(3), np.zeros(3)
    for _ in range(trials):
        curve = allan_curve(static_noise(*truth, 1.0, 50_400, rng), 1.0)
        fit = fit_noise(curve, (8.0, 1e9), intervals=intervals)
        for i, term in enumerate("NBK"):
            c = fit[term]
            hits[i] += c.low < truth[i] < c.high
            low, high = drawn_in(c, 1.0 / 3.0)
            narrow[i] += low < truth[i] < high
    assert np.all(hits / trials > 0.95 - 3.5 * math.sqrt(0.95 * 0.05 / trials))
    # Control: intervals a third as wide do not.
    assert np.all(narrow / trials < 0.8)


@pytest.mark.slow
def test_the_bootstrap_knows_noise_that_is_not_stationary():
    """White noise whose level wanders within minutes: its mean power is known less well."""
    rng = np.random.default_rng(12)
    n, trials, wander = 40_000, 40, 0.5
    hits = dict.fromkeys(("bootstrap", "covariance"), 0)
    for _ in range(trials):
        level = np.exp(gauss_markov(100.0, wander, 1.0, n, rng) - wander**2)
        slow = static_noise(0.0, 0.1, 1e-3, 1.0, n, rng)
        curve = allan_curve(level * rng.standard_normal(n) + slow, 1.0)
        for method in hits:
            found = fit_noise(curve, intervals=method)["N"]
            hits[method] += found.low < 1.0 < found.high
    assert hits["bootstrap"] / trials > 0.95 - 3.5 * math.sqrt(0.95 * 0.05 / trials)
    # Control: the covariance takes the noise for stationary.
    assert hits["covariance"] / trials < 0.7


def test_resampled_curves_are_those_of_blocks_put_together():
    """The mean square of the differences that begin in the blocks, seams left out."""
    rng = np.random.default_rng(14)
    n, factors = 2559, np.array([1, 7])
    samples = rng.standard_normal(n)
    curve = allan_curve(samples, 1.0, factors)
    drawn = drawn_blocks(5, 256)
    found = resampled_variances(curve.stretches, drawn)
    # 256 stretches of ten values of the phase; 32 blocks of eight stretches.
    assert np.all(drawn.sum(axis=1) == 256)
    phase = np.concatenate([[0.0], np.cumsum(samples - samples.mean())])
    for k, m in enumerate(factors):
        middles = np.arange(m, n + 1 - m)
        squares = (phase[middles + m] - 2 * phase[middles] + phase[middles - m]) ** 2 / 2 / m**2
        for row in range(5):
            often = drawn[row][middles // 10]
            assert found[row, k] == pytest.approx(np.average(squares, weights=often), rel=1e-9)
    once = resampled_variances(curve.stretches, np.ones((1, 256)))
    np.testing.assert_allclose(once[0], curve.variance, rtol=1e-12)
    assert np.ptp(drawn) > 2.0
    with pytest.raises(ValueError, match="overlapping"):
        fit_noise(allan_curve(samples, 1.0, overlapping=False))


@pytest.mark.parametrize("terms", [3, 5])
def test_many_small_problems_are_solved_like_one(terms):
    """Against scipy's solver of Lawson and Hanson."""
    rng = np.random.default_rng(terms)
    design = rng.uniform(0.0, 1.0, (20, terms)) + np.arange(20.0)[:, None] ** np.arange(terms) / 9
    targets = 0.5 * rng.standard_normal((200, 20)) + design @ np.maximum(rng.normal(size=terms), 0)
    weights = rng.uniform(0.1, 9.0, targets.shape)
    found = nonnegative_squares(design, targets, weights)
    theirs = [nnls(design * w[:, None], t * w)[0] for t, w in zip(targets, weights, strict=True)]
    np.testing.assert_allclose(found, theirs, atol=1e-9)
    assert 0.1 < np.mean(found == 0.0) < 0.9


@pytest.mark.slow
def test_further_terms_enter_only_where_they_are():
    rng = np.random.default_rng(13)
    n = 100_000
    white = static_noise(0.01, 0.0, 0.0, 10.0, n, rng)
    assert set(fit_noise(allan_curve(white, 10.0)).coefficients) == {"N", "B", "K"}
    ramp = fit_noise(allan_curve(white + 1e-6 * np.arange(n), 10.0))
    assert ramp["R"].low < 1e-5 < ramp["R"].high
    # Q: a rate that is the difference of a phase with white errors of deviation Q.
    phase = 0.02 * rng.standard_normal(n + 1)
    quantised = fit_noise(allan_curve(white + 10.0 * np.diff(phase), 10.0))
    assert quantised["Q"].value == pytest.approx(0.02, rel=0.02)


@pytest.mark.slow
def test_a_gauss_markov_bias_is_recognised():
    rng = np.random.default_rng(17)
    samples = gauss_markov(60.0, 0.002, 10.0, 300_000, rng)
    samples += static_noise(0.001, 0.0, 0.0, 10.0, 300_000, rng)
    fit = fit_noise(allan_curve(samples, 10.0))
    found = fit.gauss_markov
    assert found is not None
    assert found.coefficient(N) == pytest.approx(0.001, rel=0.02)
    # 500 correlation times: the deviation is known to about √(1/500) = 4 %.
    assert found.model.correlation_time == pytest.approx(60.0, rel=0.3)
    assert found.model.deviation == pytest.approx(0.002, rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mix", "process", "answer"),
    [
        ((0.0, 0.0), (1000.0, 2e-3), "process"),  # a fiftieth of the log
        ((5e-4, 0.0), (1000.0, 2e-3), "process"),
        ((5e-4, 0.0), None, "powers"),
        ((0.0, 1e-4), None, "powers"),
        ((5e-4, 1e-5), None, "powers"),
        ((0.0, 0.0), (10_000.0, 2e-3), "powers"),  # a fifth of the log looks like a random walk
    ],
)
def test_gauss_markov_and_powers_are_told_apart(mix, process, answer):
    """Logs of 14 h; each answer is right in 96 to 100 % (benchmarks/bias_models.txt)."""
    rng = np.random.default_rng(21)
    trials, hits, alike = 12, 0, []
    for _ in range(trials):
        samples = static_noise(1.4e-3, *mix, 1.0, 50_400, rng)
        if process is not None:
            samples += gauss_markov(*process, 1.0, 50_400, rng)
        fit = fit_noise(allan_curve(samples, 1.0), (4.0, 1e9), intervals="covariance")
        hits += (fit.gauss_markov is not None) == (answer == "process")
        alike.append(fit.comparison.shortest_alike)
    # Of 96 %, two wrong of twelve have a chance of 8 %, three of 1 %.
    assert hits >= trials - 2
    if process is not None and answer == "powers":
        # What is taken for a random walk is said to be possible: longer than the bound.
        assert sum(time is not None and time < process[0] for time in alike) >= trials - 2


@pytest.mark.slow
def test_fits_of_the_comparison_solve_their_equations():
    """The curve of a known model comes back, if its log is so long that nothing scatters."""
    rng = np.random.default_rng(22)
    curve = allan_curve(rng.standard_normal(50_000), 1.0, averaging_factors(50_000, 1.0)[::2])
    squares = np.array([0.0, 1.0, 0.01, 1e-6, 0.0])
    process = GaussMarkov(300.0, 0.1)
    exact = allan_terms(curve.tau) @ squares + process.allan_variance(curve.tau)
    problem = Problem(curve.tau, exact, covariances(replace(curve, length=1e8)))
    found = compare(problem, (1, 2, 3), squares).process
    assert found.model.correlation_time == pytest.approx(300.0, rel=0.1)
    assert found.model.deviation == pytest.approx(0.1, rel=0.1)
    assert found.coefficient(N) == pytest.approx(1.0, rel=0.01)
    close = settled(problem, found, 0.95)
    assert close.time_low < 300.0 < close.time_high < 1.2 * close.time_low
    assert close.deviation_low < 0.1 < close.deviation_high < 1.2 * close.deviation_low
    # σ² is the area below the density on both sides.
    frequency = np.geomspace(1e-7, 1e3, 100_001)
    area = 2.0 * np.trapezoid(process.density(frequency), frequency)
    assert area == pytest.approx(process.deviation**2, rel=1e-3)


@pytest.mark.slow
def test_a_low_pass_filter_shifts_the_fit_and_not_its_result():
    """Ten-sample averages of white noise logged at full rate: short clusters know too little."""
    rng = np.random.default_rng(23)
    samples = np.convolve(rng.standard_normal(400_009), np.full(10, 0.1), "valid")
    fit = fit_noise(allan_curve(samples, 1.0))
    assert fit.tau_from >= 10.0
    assert fit["N"].value == pytest.approx(1.0, rel=0.03)
    # Control: with the short clusters the same fit fails.
    assert fit_noise(allan_curve(samples, 1.0), (1.0, 1e9))["N"].value != pytest.approx(1, rel=0.1)


@pytest.mark.slow
def test_intervals_of_n_hold_beside_a_first_order_filter():
    """A start inside of its decay holds less often; see benchmarks/interval_coverage.txt."""
    rng, decay, hits, inside = np.random.default_rng(24), math.exp(-0.3), 0, 0
    for _ in range(30):
        white = rng.standard_normal(20_200)
        samples = lfilter([1.0 - decay], [1.0, -decay], white)[200:]
        curve = allan_curve(samples, 1.0)
        fit = fit_noise(curve)
        assert fit.tau_from > 3.0 / 0.3
        hits += fit["N"].low < 1.0 < fit["N"].high
        early = fit_noise(curve, (6.0, 1e9))
        inside += early["N"].low < 1.0 < early["N"].high
    assert hits >= 25  # of a share of 0.95, 25 or more in 98.4 %
    assert inside < hits


@pytest.mark.slow
def test_intervals_of_n_hold_beside_a_gauss_markov_process():
    rng = np.random.default_rng(25)
    for _ in range(4):
        samples = static_noise(2e-3, 0.0, 0.0, 2.0, 14_400, rng)
        fit = fit_noise(allan_curve(samples + gauss_markov(40.0, 3e-3, 2.0, 14_400, rng), 2.0))
        assert fit.gauss_markov is not None
        assert fit["N"].low < 2e-3 < fit["N"].high
        assert fit["N"].high / fit["N"].low < 1.2
        # Control: N of the fit without the process is off by more than the interval.
        assert not fit["N"].low < fit.squares[N] ** 0.5 < fit["N"].high


def test_a_ramp_does_not_scatter():
    """Degrees of freedom of white noise and a ramp, against 600 logs."""
    rng, factors, ramp = np.random.default_rng(26), np.array([10, 300]), 2e-3
    drift = ramp * np.arange(1000.0)
    curves = [allan_curve(rng.standard_normal(1000) + drift, 1.0, factors) for _ in range(600)]
    variances = np.array([curve.variance for curve in curves])
    squares = np.array([0.0, 1.0, 0.0, 0.0, ramp**2])
    degrees = degrees_of_freedom(curves[0], squares)
    measured = 2.0 * variances.mean(axis=0) ** 2 / variances.var(axis=0)
    np.testing.assert_allclose(degrees, measured, rtol=0.25)
    # Control: white noise alone would have far fewer at the longest clusters.
    white = degrees_of_freedom(curves[0], np.array([0.0, 1.0, 0.0, 0.0, 0.0]))
    assert degrees[1] > 5.0 * white[1]


@pytest.mark.parametrize(
    ("samples", "factors", "message"),
    [(np.zeros(10), None, "at least 16"), (np.zeros(100), np.array([51]), "1 to 50")],
)
def test_impossible_requests_are_refused(samples, factors, message):
    with pytest.raises(InputError, match=message):
        allan_curve(samples, 1.0, factors)
