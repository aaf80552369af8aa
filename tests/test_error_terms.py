"""Every error term in the planar kernel against closed forms; the traps that others fell into."""

import math

import numpy as np
import pytest

import mcsim
from mcsim import InputError
from mcsim.sensor_terms.mechanisms.low_pass import LowPass
from mcsim.sensors.coloured import after_calibration, folded, innovations_of
from mcsim.sensors.filters import behind_filters
from tests.conftest import ALL_ERRORS, NO_NOISE, problem, processes_of, scenario

INTERVAL = 0.01
STRAIGHT = {
    "trajectory": {"shape": "straight", "length": "100 m", "speed": "20 m/s", "lead": "0.1 s"},
    "sensors.sampling": "none",
}
QUIET = {**STRAIGHT, **NO_NOISE}
N = 20_000
#: Five sampling errors of a standard deviation from N realizations.
CLOSE = 5 / math.sqrt(2 * N)
TERMS = {
    "accelerometer scale factor": {"sensors.accelerometer.scale_factor_error": "0.5 %"},
    "gyroscope scale factor": {"sensors.gyroscope.scale_factor_error": "0.5 %"},
    "accelerometer misalignment": {"sensors.accelerometer.misalignment": "0.2 °"},
    "accelerometer turn-on bias": {"sensors.accelerometer.turn_on_bias": "2 mg"},
    "gyroscope g-sensitivity": {"sensors.gyroscope.g_sensitivity": "0.01 °/s/g"},
    "accelerometer bias instability": {"sensors.accelerometer.bias_instability": "1 mg"},
    "gyroscope bias instability": {"sensors.gyroscope.bias_instability": "100 °/h"},
    "accelerometer random walk": {"sensors.accelerometer.acceleration_random_walk": "1e-3 m/s²/√s"},
    "gyroscope random walk": {"sensors.gyroscope.rate_random_walk": "0.02 °/s/√s"},
    "accelerometer Gauss-Markov drift": {
        "sensors.accelerometer.gauss_markov": {"deviation": "1 mg", "correlation_time": "0.5 s"}
    },
    "gyroscope Gauss-Markov drift": {
        "sensors.gyroscope.gauss_markov": {"deviation": "0.02 °/s", "correlation_time": "3 s"}
    },
    "gyroscope spikes": {"sensors.gyroscope.spikes": {"rate": "2 Hz", "amplitude": "0.5 °/s"}},
    "sample-time jitter": {"sensors.time_jitter": "0.1 ms"},
}
EVERY = {path: value for term in TERMS.values() for path, value in term.items()}


def processes(**terms):
    values = {"bias_instability": 0.0, "random_walk": 0.0, "drift": 0.0, "correlation_time": 1.0}
    return processes_of(**{**values, **terms}, interval=INTERVAL, duration=5.0)


def covariance_of(p, white, n):
    """Covariance (n, n) of the noise that the innovations make."""
    unit = folded(np.eye(n), innovations_of(p, white, n))
    return unit @ unit.T


# Coloured noise: the covariance of what the kernels draw is the process's own, to rounding.


def test_gauss_markov_is_stationary_from_the_first_sample():
    lag = np.abs(np.subtract.outer(np.arange(60), np.arange(60))) * INTERVAL
    p = processes(drift=0.3, correlation_time=0.2)
    expected = 0.09 * np.exp(-lag / 0.2)
    np.testing.assert_allclose(covariance_of(p, 0.0, 60), expected, rtol=1e-9)
    # The control: started at zero it would still be growing.
    grown = 0.09 * (1.0 - np.exp(-2.0 * INTERVAL * np.arange(60) / 0.2))
    assert abs(grown[5] / expected[5, 5] - 1.0) > 0.5


def test_infinite_correlation_time_is_a_constant_and_not_white_noise():
    p = processes(drift=0.3, correlation_time=math.inf)
    np.testing.assert_allclose(covariance_of(p, 0.0, 40), 0.09, rtol=1e-9)


def test_random_walk_grows_with_time_whatever_the_rate():
    index = np.arange(50)
    expected = 0.2**2 * INTERVAL * np.minimum.outer(index, index)
    p = processes(random_walk=0.2)
    np.testing.assert_allclose(covariance_of(p, 0.0, 50), expected, atol=1e-15)
    finer = processes_of(0.0, 0.2, 0.0, 1.0, INTERVAL / 4, 5.0)
    np.testing.assert_allclose(
        covariance_of(finer, 0.0, 200)[::4, ::4], expected, rtol=1e-9, atol=1e-15
    )


def test_white_noise_adds_to_the_diagonal():
    p = processes(drift=0.3, correlation_time=0.2, random_walk=0.1, bias_instability=0.05)
    difference = covariance_of(p, 0.7, 80) - covariance_of(p, 0.0, 80)
    np.testing.assert_allclose(difference, 0.49 * np.eye(80), atol=1e-12)


def test_flicker_has_the_allan_deviation_of_theory():
    """0.664 B from five samples to a tenth of the run, within 3 %."""
    n = 2000
    p = processes_of(1.0, 0.0, 0.0, 1.0, INTERVAL, n * INTERVAL)
    covariance = covariance_of(p, 0.0, n)
    for m in (5, 20, 60, 200):
        difference = np.zeros(n)
        difference[:m], difference[m : 2 * m] = -1.0 / m, 1.0 / m
        allan = math.sqrt(0.5 * difference @ covariance @ difference)
        assert allan == pytest.approx(math.sqrt(2.0 * math.log(2.0) / math.pi), rel=0.03)


# In the kernel


def end(overrides, row, n=N):
    p = problem({**QUIET, **overrides})
    return p.simulate(5, 0, n).errors[row] - p.method_errors()[row]


HEADING, ALONG = 3, 0
DURATION = 5.2


def test_drifts_of_the_gyroscope_integrate_to_known_headings():
    """Sums over samples of sampled processes, in closed form."""
    n = round(DURATION / INTERVAL)
    drift = end(TERMS["gyroscope Gauss-Markov drift"], HEADING).std()
    decay = math.exp(-INTERVAL / 3.0)
    lags = np.arange(1, n)
    variance = n + 2.0 * np.sum((n - lags) * decay**lags)
    expected = math.radians(0.02) * INTERVAL * math.sqrt(variance)
    assert drift == pytest.approx(expected, rel=CLOSE)
    walk = end(TERMS["gyroscope random walk"], HEADING).std()
    # K sqrt(dt) steps, each counted in every later sample: K^2 dt^3 sum k^2.
    expected = math.radians(0.02) * math.sqrt(INTERVAL**3 * np.sum(np.arange(1, n + 1.0) ** 2))
    assert walk == pytest.approx(expected, rel=CLOSE)
    assert walk == pytest.approx(math.radians(0.02) * math.sqrt(DURATION**3 / 3), rel=0.02)


def test_random_walk_does_not_depend_on_the_rate():
    term = TERMS["gyroscope random walk"]
    slow = end(term, HEADING).std()
    fast = end({**term, "sensors.rate": "400 Hz"}, HEADING, 5000).std()
    assert fast == pytest.approx(slow, rel=5 / math.sqrt(2 * 5000) + 0.01)
    # The control: steps scaled with dt would halve it twice over.
    assert abs(slow / 2.0 / fast - 1.0) > 0.3


def test_g_sensitivity_sees_gravity():
    heading = end(TERMS["gyroscope g-sensitivity"], HEADING).std()
    assert heading == pytest.approx(math.radians(0.01) * DURATION, rel=CLOSE)


def test_spikes_are_rare_and_of_either_sign():
    p = problem({**QUIET, "sensors.accelerometer.spikes": {"rate": "1 Hz", "amplitude": "1 m/s²"}})
    histories = p.history(3, 0, 400)
    # On a straight run the along velocity is the sum of the accelerometer's spikes.
    jumps = np.diff(np.diff(histories.tracks[0], axis=0), axis=0) / INTERVAL**2
    size = np.abs(jumps) > 0.5
    assert np.abs(np.abs(jumps[size]) - 1.0).max() < 1e-6
    count, expected = size.sum(), jumps.size * INTERVAL
    assert abs(count - expected) < 5 * math.sqrt(expected)
    assert abs(np.sign(jumps[size]).sum()) < 5 * math.sqrt(count)


def test_quantisation_rounds_to_the_nearest_step():
    noise = {**STRAIGHT, "sensors.gyroscope.noise_density": "0.03 °/s/√Hz"}
    plain = problem(noise).simulate(5, 0, N).errors[HEADING].std()
    fine = {"sensors.gyroscope.resolution": "0.2 °/s"}
    coarse = problem({**noise, **fine}).simulate(5, 0, N).errors[HEADING].std()
    n = round(DURATION / INTERVAL)
    rounding = math.radians(0.2) * INTERVAL * math.sqrt(n / 12.0)
    assert coarse == pytest.approx(math.hypot(plain, rounding), rel=CLOSE)
    assert abs(coarse / plain - 1.0) > CLOSE  # without rounding the test must fail
    # Without noise a constant yaw rate becomes a multiple of the step.
    constant = {
        "sensors.gyroscope.resolution": "0.5 °/s",
        "sensors.gyroscope.turn_on_bias": "1 °/s",
    }
    rates = np.degrees(problem({**QUIET, **constant}).simulate(1, 0, 200).errors[HEADING])
    steps = rates / DURATION / 0.5
    assert np.abs(steps - np.round(steps)).max() < 1e-9
    assert len(set(np.round(steps))) > 5


def test_saturation_cuts_what_the_range_does_not_hold():
    """Braking at 4 m/s² seen by a sensor that ends at 3 m/s²: 1 m/s² is missing throughout."""
    brake = {**QUIET, "trajectory.deceleration": "1.5 m/s^2", "trajectory.lead": "0 s"}
    cut = {**brake, "sensors.accelerometer.range": "1 m/s²"}
    p, q = problem(brake), problem(cut)
    missing = q.simulate(1, 0, 1).errors[ALONG] - p.simulate(1, 0, 1).errors[ALONG]
    duration = p.n_samples * p.interval
    assert missing[0] == pytest.approx(0.5 * 0.5 * duration**2, rel=0.02)


def test_a_range_out_of_reach_costs_nothing():
    wide = problem(
        {"sensors.accelerometer.range": "160 m/s²", "sensors.gyroscope.range": "2000 °/s"}
    )
    assert wide.measurement.terms.innovation.shape == (0, 3)  # the fast path
    same = problem().simulate(1, 0, 300).errors
    np.testing.assert_array_equal(wide.simulate(1, 0, 300).errors, same)
    near = problem({"sensors.accelerometer.range": "3 m/s²"})
    assert near.measurement.terms.innovation.shape[0] > 0


@pytest.mark.parametrize("integration", ["rectangular", "trapezoidal"])
def test_jitter_alone_has_the_linear_models_deviation(integration):
    """Terms of the elements: tests/test_sensor_terms.py."""
    source = "sample-time jitter"
    values = {**NO_NOISE, **TERMS[source], "reconstruction.integration": integration}
    p = problem(values)
    deviation = (p.simulate(7, 0, N).errors - p.method_errors()[:, None]).std(axis=1)
    expected = np.sqrt(p.linear.variances[source])
    assert max(p.linear.variances, key=lambda s: p.linear.variances[s].max()) == source
    rows = [0, 1, 3, 4]
    # Beside the sampling error, terms of second order show where the first order vanishes.
    np.testing.assert_allclose(
        deviation[rows], expected[rows], rtol=CLOSE + 0.01, atol=0.02 * expected[rows].max()
    )


def test_wrong_sizes_would_be_seen():
    """The control: a term that is 5 % too large is outside of the tolerance."""
    p = problem({**NO_NOISE, **TERMS["gyroscope random walk"]})
    deviation = p.simulate(7, 0, N).errors[HEADING].std()
    assert abs(1.05 * deviation / np.sqrt(p.linear.second_moment[3]) - 1.0) > CLOSE + 0.01


@pytest.mark.parametrize("integration", ["rectangular", "trapezoidal"])
def test_controls_hold_for_coloured_noise_and_mixing(integration):
    controlled = {path: v for path, v in EVERY.items() if "spikes" not in path}
    del controlled["sensors.time_jitter"]
    p = problem({**ALL_ERRORS, **controlled, "reconstruction.integration": integration})
    sample = p.simulate(11, 0, N, controls=True)
    u = sample.errors - p.method_errors()[:, None]
    residual = (u - sample.controls).std(axis=1) / u.std(axis=1)
    assert (residual < 0.05).all()
    assert residual[3] < 1e-6  # the heading is linear; its controls weigh every normal
    spread = np.sqrt(p.linear.control_second_moment - p.linear.control_mean**2)
    mean = sample.controls.mean(axis=1) - p.linear.control_mean
    assert np.abs(mean / spread).max() < 5 / math.sqrt(N)


def test_budget_adds_up_and_monte_carlo_agrees_with_the_linear_model():
    values = {**ALL_ERRORS, **EVERY, "monte_carlo.realizations": N}
    run = mcsim.run(scenario(values))
    rms = run.table[run.table["statistic"] == "rms"]["value"].to_numpy()
    linear = mcsim.run(scenario({**values, "monte_carlo.estimator": "linear"})).table
    expected = linear[linear["statistic"] == "rms"]["value"].to_numpy()
    np.testing.assert_allclose(rms, expected, rtol=CLOSE + 0.01)
    shares = run.budget.groupby("error")["share"].sum()
    np.testing.assert_allclose(shares, 1.0, rtol=1e-9)
    assert set(TERMS) <= set(run.budget["source"])


def test_realizations_with_all_terms_do_not_depend_on_how_they_are_run():
    p = problem({**ALL_ERRORS, **EVERY})
    whole = p.simulate(1, 0, 300, controls=True)
    parts = [p.simulate(1, first, 100, controls=True) for first in (0, 100, 200)]
    np.testing.assert_array_equal(whole.errors, np.concatenate([q.errors for q in parts], 1))
    np.testing.assert_array_equal(whole.controls, np.concatenate([q.controls for q in parts], 1))


@pytest.mark.slow
def test_terms_can_be_swept(tmp_path):
    s = scenario(
        {
            "sweep": {
                "sensors.gyroscope.bias_instability": ["1 °/h", "1000 °/h"],
                "sensors.gyroscope.gauss_markov.correlation_time": ["0.1 s", "10 s"],
            },
            "sensors.gyroscope.gauss_markov": {"deviation": "0.1 °/s", "correlation_time": "1 s"},
        }
    )
    table = mcsim.run(s, output=tmp_path).table
    heading = table[(table["error"] == "heading") & (table["statistic"] == "rms")]
    value = heading["value"].to_numpy().reshape(2, 2)
    assert (np.diff(value, axis=0) > 0).all()
    assert (np.diff(value, axis=1) > 0).all()


# Bandwidth


def test_low_pass_has_the_gain_and_the_delay_of_first_order():
    frequency, cut_off = 7.0, 12.0

    def signals(t, _width):
        return np.stack([np.cos(2 * np.pi * frequency * t), t, np.ones_like(t)])

    t = np.linspace(0.0, 2.0, 500)
    slow = (LowPass(cut_off),)
    after = behind_filters(signals, (slow, slow, ()), 0.0, 100.0, 300)(t, 0.0)
    response = 1.0 / (1.0 + 1j * frequency / cut_off)
    expected = np.real(response * np.exp(2j * np.pi * frequency * t))
    np.testing.assert_allclose(after[0], expected, atol=2e-3)
    np.testing.assert_allclose(after[1], t - 1.0 / (2 * np.pi * cut_off), atol=1e-6)
    np.testing.assert_array_equal(after[2], 1.0)


def test_limited_bandwidth_shows_in_the_method_error():
    wide = problem({"sensors.gyroscope.bandwidth": "10 kHz"}).method_errors()
    np.testing.assert_allclose(wide, problem().method_errors(), atol=2e-4)
    narrow = problem({"sensors.gyroscope.bandwidth": "5 Hz"}).method_errors()
    # A late yaw rate turns the acceleration wrongly.
    assert abs(narrow[1] - wide[1]) > 1e-3


# Calibration before the run


def brute_force(p, white, samples, estimator):
    """Variance of the bias that is left at the sample after the calibration.

    From the whole covariance of bias, noise while calibrating, and noise at that sample;
    ``estimator`` are the weights of the samples.
    """
    covariance = covariance_of(p, white, samples + 1)
    joint = covariance[:samples, :samples]
    later = covariance[samples, :samples]
    own = covariance[samples, samples] - white**2
    return own - 2.0 * estimator @ later + estimator @ joint @ estimator


@pytest.mark.slow
@pytest.mark.parametrize("terms", [{}, {"drift": 0.3, "correlation_time": 0.4},
                                   {"random_walk": 0.2, "bias_instability": 0.1}])  # fmt: skip
def test_what_calibration_leaves_is_exact(terms):
    p, white, samples = processes(**terms), 0.5, 60
    mean = np.full(samples, 1.0 / samples)
    left = after_calibration(p, white, samples, "mean").start.sum()
    assert left == pytest.approx(brute_force(p, white, samples, mean), rel=1e-9)
    # The best unbiased weights, by generalized least squares, are what a Kalman filter does.
    covariance = covariance_of(p, white, samples + 1)
    joint, later = covariance[:samples, :samples], covariance[samples, :samples]
    solved = np.linalg.solve(joint, np.column_stack([np.ones(samples), later]))
    shortage = (1.0 - solved[:, 1].sum()) / solved[:, 0].sum()
    best = solved[:, 1] + shortage * solved[:, 0]
    kalman = after_calibration(p, white, samples, "kalman").start.sum()
    assert kalman == pytest.approx(brute_force(p, white, samples, best), rel=1e-5)
    assert kalman <= left * (1.0 + 1e-9)


def test_calibrating_white_noise_leaves_its_mean():
    values = {
        **STRAIGHT,
        "sensors.gyroscope.noise_density": "0.1 °/s/√Hz",
        "sensors.gyroscope.turn_on_bias": "5 °/s",
        "sensors.calibration": {"duration": "2 s"},
    }
    heading = problem(values).simulate(3, 0, N).errors[HEADING].std()
    one = math.radians(0.1) * math.sqrt(50.0)
    n = round(DURATION / INTERVAL)
    expected = INTERVAL * one * math.sqrt(n + n**2 / 200.0)
    assert heading == pytest.approx(expected, rel=CLOSE)


@pytest.mark.slow
def test_longer_calibration_helps_until_the_bias_wanders():
    """With random walk a calibration can be too long for the mean, not for the filter."""

    def heading(duration, method):
        p = problem(
            {
                **STRAIGHT,
                "sensors.gyroscope.noise_density": "0.03 °/s/√Hz",
                "sensors.gyroscope.rate_random_walk": "0.02 °/s/√s",
                "sensors.calibration": {"duration": duration, "method": method},
            }
        )
        return p.linear.second_moment[3]

    assert heading("3 s", "mean") < heading("0.1 s", "mean")
    assert heading("1000 s", "mean") > heading("3 s", "mean")
    assert heading("1000 s", "kalman") < heading("3 s", "kalman") * (1 + 1e-9)


def test_calibration_replaces_the_assumed_miscalibration():
    with pytest.raises(InputError, match=r"remove `gyroscope\.miscalibration`"):
        scenario({**ALL_ERRORS, "sensors.calibration": {"duration": "10 s"},
                  "sensors.accelerometer.miscalibration": "0 m/s^2"})  # fmt: skip


def test_runs_too_long_for_their_in_run_noise_are_refused(monkeypatch):
    monkeypatch.setattr("mcsim.sensors.measurement._MOST_STATES", 1500)
    (failure,) = mcsim.run(scenario(TERMS["gyroscope bias instability"])).failures
    assert "the in-run noise of 272 samples" in failure
    assert not mcsim.run(scenario({**ALL_ERRORS, "monte_carlo.realizations": 100})).failures


# Sensor files


def test_sensor_files_are_sensors(tmp_path):
    """A file as `mcsim characterise` writes it; forward is its x axis, left its y axis."""
    (tmp_path / "mine.yaml").write_text(
        "description: measured\n"
        "accelerometer:\n"
        "  velocity_random_walk: 0.1 m/s/√h\n"
        "  bias_instability: 2 m/s/h\n"
        "  axes:\n"
        "    x: {velocity_random_walk: 0.06 m/s/√h}\n"
        "    y: {velocity_random_walk: 0.12 m/s/√h}\n"
        "    z: {velocity_random_walk: 0.18 m/s/√h}\n"
        "gyroscope: {angle_random_walk: 0.3 °/√h, rate: 100 Hz}\n",
        encoding="utf-8",
    )
    base = {**scenario().document.tree, "sensors": {"rate": "100 Hz", "accelerometer": "mine.yaml",
            "gyroscope": {"model": "mine.yaml", "miscalibration": "1 °/s"}}}  # fmt: skip
    s = mcsim.Scenario.from_dict(base, folder=tmp_path)
    accelerometer = s.base.sensors.accelerometer
    assert accelerometer.velocity_random_walk == pytest.approx((1e-3, 2e-3, 3e-3))
    assert accelerometer.bias_instability == (pytest.approx(2 / 3600),)
    assert s.base.files == ("mine.yaml",)
    budget = mcsim.run(s).budget
    assert "accelerometer bias instability" in set(budget["source"])
    gyroscope_only = {**base, "sensors": {**base["sensors"], "accelerometer": "other.yaml"}}
    with pytest.raises(InputError, match=r"other\.yaml: no such file"):
        mcsim.Scenario.from_dict(gyroscope_only, folder=tmp_path)
    (tmp_path / "other.yaml").write_text("gyroscope: {angle_random_walk: 0.3 °/√h}\n")
    with pytest.raises(InputError, match=r"other\.yaml: has no accelerometer"):
        mcsim.Scenario.from_dict(gyroscope_only, folder=tmp_path)


def test_saturated_channels_keep_right_deviations_and_intervals():
    """Far from the linear model controls may widen a deviation; the plain sums serve then."""
    values = {
        "trajectory": {"shape": "half_cosine", "length": "30 m", "width": "5 m",
                       "speed": "20 m/s", "deceleration": "3 m/s^2"},
        "sensors.sampling": "none",
        "sensors.gyroscope.range": "20 °/s",
        "sensors.accelerometer.range": "8 m/s²",
        "monte_carlo.realizations": 4000,
    }  # fmt: skip
    tables = []
    for estimator in ("plain", "control_variate"):
        run = mcsim.run(scenario({**values, "monte_carlo.estimator": estimator}))
        table = run.table[run.table["statistic"] == "std"]
        tables.append(table.set_index("error")[["value", "ci_low", "ci_high"]])
    plain, controlled = tables
    width = (plain["ci_high"] - plain["ci_low"]).to_numpy()
    assert (np.abs(controlled["value"] - plain["value"]).to_numpy() < width).all()
    assert ((controlled["ci_high"] - controlled["ci_low"]).to_numpy() < 1.05 * width).all()
    assert (controlled["value"] > 0.0).all()


def test_jitter_beyond_half_an_interval_is_refused():
    with pytest.raises(InputError, match=r"at most half a sampling interval, 0\.005 s"):
        scenario({"sensors.time_jitter": "6 ms"})
