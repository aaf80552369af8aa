"""The strapdown's linear model: weights against finite differences, moments against sampling."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad

from mcsim.kernels.strapdown import Motion
from mcsim.simulation.lengths import length_quantile, mean_length
from tests.strapdown import EVERYTHING, LEANING, RULES, constants_of, problem, with_errors

#: Errors in the order of the weights: along, across, height, course, roll, pitch, heading.
ORDER = [0, 1, 2, 7, 4, 5, 6]
#: Constants that move the initial state, and where they move it.
STARTS = {3: [3], 4: [7, 8], 5: [7], 6: [8], 15: [5], 16: [6]}


def end_errors(p, change):
    """Undisturbed end errors after a change of the signals or the initial state."""
    signals, start = p.signals.copy(), np.array(p._start)
    change(signals, start)
    shifted = replace(p, signals=signals)
    shifted.__dict__["_start"] = Motion(*map(float, start))
    return shifted.method_errors()[ORDER]


def slope(p, change, step):
    up = end_errors(p, lambda s, x: change(s, x, step))
    down = end_errors(p, lambda s, x: change(s, x, -step))
    return (up - down) / (2 * step)


def at(*where):
    """A change of one or several signals or initial values."""

    def change(signals, start, step):
        target = start if where[0] == "start" else signals
        target[where[1:] if where[0] != "start" else where[1]] += step

    return change


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("sampling", ["fir", "average"])
def test_weights_are_derivatives(rule, sampling):
    """Central differences of the kernel itself, for samples, offsets and the initial state."""
    p = problem({**EVERYTHING, "reconstruction.integration": rule, "sensors.sampling": sampling})
    w = p.weights
    largest = np.abs(w.samples).max(axis=(1, 2))
    # The kernel's row of a sample: the forward Euler rule is one behind.
    behind = 1 if rule == "forward_euler" else 0
    for i in (0, 1, 2, 77, p.n_samples - 1, p.n_samples):
        if i < behind:
            continue
        for channel in range(6):
            expected = slope(p, at("signals", i - behind, channel), 1e-4)
            ours = w.samples[:, i, channel]
            assert np.all(np.abs(ours - expected) <= 1e-4 * np.abs(expected) + 1e-5 * largest)
    for channel in range(6):
        expected = slope(p, at("signals", slice(None), channel), 1e-6)
        atol = 1e-6 * np.abs(expected).max()
        np.testing.assert_allclose(
            w.samples[:, :, channel].sum(axis=1), expected, rtol=1e-4, atol=atol
        )
    for column, places in STARTS.items():
        expected = slope(p, at("start", places), 1e-5)
        atol = 1e-7 * np.abs(expected).max()
        np.testing.assert_allclose(w.constants[:, column], expected, rtol=1e-4, atol=atol)


@pytest.mark.parametrize("rule", ["rectangular", "forward_euler", "two_sample"])
@pytest.mark.parametrize("levelled", [False, True])
def test_controls_follow_the_errors_and_their_moments_are_exact(rule, levelled):
    """Small disturbances: controls equal errors; their moments hold within sampling error."""
    p = problem(
        {
            **EVERYTHING,
            "reconstruction.integration": rule,
            "initial.levelling": {"duration": "2 s"} if levelled else None,
        }
    )
    n = 50_000
    sample = p.simulate(11, 0, n, controls=True)
    u = sample.errors - p.method_errors()[:, None]
    residual = (u - sample.controls).std(axis=1) / u.std(axis=1)
    assert (residual < 0.03).all()
    mean, second = p.linear.mean, p.linear.second_moment
    spread = np.sqrt(second - mean**2)
    assert np.abs((sample.controls.mean(axis=1) - mean) / spread).max() < 5 / np.sqrt(n)
    c2 = sample.controls**2
    assert np.abs((c2.mean(axis=1) - second) / c2.std(axis=1)).max() < 5 / np.sqrt(n)


def test_one_source_alone_is_its_share():
    p = problem(EVERYTHING)
    for source, keep in (
        ("accelerometer miscalibration", [0, 1, 12]),
        ("gyroscope miscalibration", [2, 13, 14]),
        ("initial tilt error", [15, 16]),
    ):
        only = np.zeros(24)
        only[keep] = constants_of(p)[keep]
        alone = with_errors(p, np.zeros(6), only)
        deviation = alone.simulate(3, 0, 20_000).errors.std(axis=1)
        expected = np.sqrt(p.linear.variances[source])
        np.testing.assert_allclose(deviation[ORDER], expected[ORDER], rtol=0.03, atol=2e-4)


def test_the_planar_algorithm_has_a_linear_model_in_space():
    p = problem({**EVERYTHING, "reconstruction.algorithm": "planar"})
    n = 50_000
    sample = p.simulate(11, 0, n, controls=True)
    u = sample.errors - p.method_errors()[:, None]
    disturbed = [0, 1, 3, 6, 7]
    residual = (u - sample.controls).std(axis=1)[disturbed] / u.std(axis=1)[disturbed]
    assert (residual < 0.03).all()
    assert np.abs(u[2]).max() == 0.0
    # Roll and pitch err by the tilt that nobody knows, exactly as their controls do.
    np.testing.assert_allclose(u[[4, 5]], sample.controls[[4, 5]], atol=1e-12)
    mean, second = p.linear.mean[3], p.linear.second_moment[3]
    control = sample.controls[3]
    assert abs(control.mean() - mean) < 5 * control.std() / np.sqrt(n)
    assert abs((control**2).mean() - second) < 5 * (control**2).std() / np.sqrt(n)


@pytest.mark.parametrize("p", [0.05, 0.5, 0.95, 0.999])
def test_quantiles_of_spatial_normal_vectors(p):
    """Maxwell, non-central chi and half-normal lengths, and those of a flat vector."""
    zero, unit = np.zeros(3), np.eye(3)
    assert length_quantile(zero, unit, p) == pytest.approx(stats.maxwell.ppf(p), rel=1e-9)
    for centre, scale in (([3.0, 1.0, 2.0], 0.5), ([300.0, 1.0, 2.0], 0.01)):
        offset = np.array(centre)
        expected = scale * np.sqrt(stats.ncx2.ppf(p, 3, offset @ offset / scale**2))
        assert length_quantile(offset, scale**2 * unit, p) == pytest.approx(expected, rel=1e-9)
    line = np.diag([0.0, 4.0, 0.0])
    assert length_quantile(zero, line, p) == pytest.approx(2 * stats.halfnorm.ppf(p), rel=1e-6)
    flat = np.diag([1.0, 0.0, 1.0])
    assert length_quantile(zero, flat, p) == pytest.approx(stats.rayleigh.ppf(p), rel=1e-6)


@pytest.mark.parametrize("narrow", [0.5, 1e-2, 1e-4])
@pytest.mark.parametrize("centre", [(0.0, 0.0), (0.3, 0.8), (5.0, 20.0)])
def test_quantiles_of_elongated_plane_vectors(narrow, centre):
    """Against scipy's adaptive integration over the narrow axis, the wide one in closed form."""
    x, y = stats.norm(centre[0], narrow), stats.norm(centre[1], 1.0)
    r = length_quantile(np.array(centre), np.diag([narrow**2, 1.0]), 0.7)

    def slice_within(z):
        half = np.sqrt(max(r**2 - z**2, 0.0))
        return x.pdf(z) * (y.cdf(half) - y.cdf(-half))

    ends = np.clip(centre[0] + narrow * np.linspace(-9.0, 9.0, 19), -r, r)
    below = sum(quad(slice_within, a, b)[0] for a, b in pairwise(ends))
    assert below == pytest.approx(0.7, abs=1e-8)


def test_quantiles_far_from_zero():
    """The expansion takes over at 300 deviations: no step there, and right beyond."""
    for offset in (299.0, 301.0, 3000.0):
        centre = np.array([0.0, offset, 0.0])
        expected = np.sqrt(stats.ncx2.ppf(0.9, 3, offset**2))
        assert length_quantile(centre, np.eye(3), 0.9) == pytest.approx(expected, abs=2e-5)


def test_mean_length_in_space():
    assert mean_length(np.zeros(3), np.eye(3)) == pytest.approx(stats.maxwell.mean(), rel=1e-12)
    centre, covariance = np.array([0.7, -0.4, 0.3]), np.diag([0.9, 0.5, 0.1])
    rng = np.random.default_rng(5)
    lengths = np.linalg.norm(
        centre + rng.standard_normal((10**6, 3)) * [0.9**0.5, 0.5**0.5, 0.1**0.5], axis=1
    )
    assert mean_length(centre, covariance) == pytest.approx(
        lengths.mean(), abs=5 * lengths.std() / 1000
    )


# The sensors' error terms, which every case measures with


TERMS = {
    "accelerometer scale factor": {"sensors.accelerometer.scale_factor_error": "0.2 %"},
    "gyroscope scale factor": {"sensors.gyroscope.scale_factor_error": "0.5 %"},
    "accelerometer misalignment": {"sensors.accelerometer.misalignment": "0.1 °"},
    "gyroscope misalignment": {"sensors.gyroscope.misalignment": "1 °"},
    "gyroscope g-sensitivity": {"sensors.gyroscope.g_sensitivity": "0.005 °/s/g"},
    "accelerometer turn-on bias": {"sensors.accelerometer.turn_on_bias": "1 mg"},
    "accelerometer bias instability": {"sensors.accelerometer.bias_instability": "1 mg"},
    "gyroscope random walk": {"sensors.gyroscope.rate_random_walk": "0.01 °/s/√s"},
    "gyroscope Gauss-Markov drift": {
        "sensors.gyroscope.gauss_markov": {"deviation": "0.02 °/s", "correlation_time": "3 s"}
    },
    "gyroscope spikes": {"sensors.gyroscope.spikes": {"rate": "2 Hz", "amplitude": "0.3 °/s"}},
    "sample-time jitter": {"sensors.time_jitter": "0.1 ms"},
}
SILENT = {
    "sensors.accelerometer.noise_density": "0 m/s^2/√Hz",
    "sensors.gyroscope.noise_density": "0 °/s/√Hz",
}


@pytest.mark.parametrize("rule", ["rectangular", "forward_euler", "two_sample"])
@pytest.mark.parametrize("source", TERMS)
def test_each_error_term_alone_has_the_linear_models_deviation(source, rule):
    n = 10_000
    values = {**SILENT, **LEANING, **TERMS[source], "reconstruction.integration": rule}
    p = problem(values)
    deviation = (p.simulate(7, 0, n).errors - p.method_errors()[:, None]).std(axis=1)
    expected = np.sqrt(p.linear.variances[source])
    # Beside the sampling error, terms of second order show where the first order vanishes.
    for rows in ([0, 1, 2], [4, 5, 6, 7]):
        np.testing.assert_allclose(
            deviation[rows],
            expected[rows],
            rtol=5 / np.sqrt(2 * n) + 0.01,
            atol=0.02 * expected[rows].max(),
        )


def test_misaligned_accelerometers_level_the_attitude_wrongly():
    """The tilt of a misaligned axis is levelled away: the track hardly sees gravity."""
    n = 10_000
    values = {**SILENT, "sensors.accelerometer.misalignment": "0.5 °"}
    levelled = problem({**values, "initial.levelling": {"duration": "1 s"}})
    errors = levelled.simulate(3, 0, n).errors
    roll = errors[4].std()
    assert np.degrees(roll) == pytest.approx(0.5, rel=5 / np.sqrt(2 * n) + 0.01)
    expected = np.sqrt(levelled.linear.second_moment)
    np.testing.assert_allclose(errors[:2].std(axis=1), expected[:2], rtol=0.05)
    assert errors[0].std() < 0.2 * problem(values).simulate(3, 0, n).errors[0].std()


@pytest.mark.parametrize("rule", ["rectangular", "two_sample"])
def test_controls_hold_for_all_error_terms(rule):
    controlled = {
        path: value
        for name, term in TERMS.items()
        if "spikes" not in name and "jitter" not in name
        for path, value in term.items()
    }
    levelling = {"initial.levelling": {"duration": "1 s"}}
    p = problem({**LEANING, **controlled, **levelling, "reconstruction.integration": rule})
    sample = p.simulate(11, 0, 10_000, controls=True)
    u = sample.errors - p.method_errors()[:, None]
    residual = (u - sample.controls).std(axis=1) / u.std(axis=1)
    assert (residual < 0.05).all()
    parts = [p.simulate(11, first, 100, controls=True) for first in (0, 100)]
    both = np.concatenate([part.errors for part in parts], axis=1)
    np.testing.assert_array_equal(both, sample.errors[:, :200])
    nets = p.simulate(11, 0, 4096, net=64).errors.std(axis=1)
    np.testing.assert_allclose(nets, sample.errors.std(axis=1), rtol=0.1)


@pytest.mark.parametrize("source", ["accelerometer misalignment", "gyroscope misalignment"])
def test_misalignment_leaks_gravity_and_roll_into_the_planar_algorithm(source):
    """Channels that the planar algorithm does not read show in those that it does."""
    n = 10_000
    values = {**SILENT, "body.roll.gradient": "1 °/(m/s²)", **TERMS[source]}
    flat = problem({**values, "reconstruction.algorithm": "planar"})
    deviation = (flat.simulate(7, 0, n).errors - flat.method_errors()[:, None]).std(axis=1)
    expected = np.sqrt(flat.linear.variances[source])
    rows = [0, 1, 6, 7]
    np.testing.assert_allclose(
        deviation[rows],
        expected[rows],
        rtol=5 / np.sqrt(2 * n) + 0.01,
        atol=0.02 * expected[rows].max(),
    )
    if source == "accelerometer misalignment":
        # 0.1° of gravity over the drive, in both components.
        time = flat.n_samples * flat.planar.interval
        leak = np.radians(0.1) * 9.80665 * time**2 / 2
        assert deviation[0] == pytest.approx(leak, rel=0.1)
    else:
        assert deviation[6] > 0.0
