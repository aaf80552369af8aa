"""The whole sensor in the velocity case: a naive twin, the covariance, traps, and bad input."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2, ks_2samp

import mcsim
from mcsim import InputError, Scenario
from mcsim.cli.summary import summary
from mcsim.engine import run_point
from mcsim.gum import course_of_uncertainty
from mcsim.gum.tables import comparison_table
from mcsim.gum.words import comparison_words
from mcsim.kernels.velocity import drawn_rows
from mcsim.kernels.velocity_system import REST_NOISE
from mcsim.simulation.nets import net_normals
from mcsim.systems import check_point, problem_of
from mcsim.systems.velocity.measured import GroupSamples, ProcessSums
from mcsim.systems.velocity.scatter import mean_scatter, mean_square_scatter, scatter_quantile
from mcsim.units import STANDARD_GRAVITY
from tests.conftest import processes_of
from tests.reference import velocity_numpy, velocity_sensor_numpy
from tests.reference.random_numpy import white_noise
from tests.reference.velocity_sensor_numpy import Terms
from tests.test_velocity import FOLDER

#: The scenario's gravity, of which its raw output holds fractions.
G = 9.81213
#: Thousandths of standard gravity, the unit of a sensor's error terms, in thousandths of that.
MG = 1e-3 * STANDARD_GRAVITY / G
#: A short run after a short rest, so that naive simulations are quick too.
SHORT = {
    "trajectory.duration": "0.5 s",
    "trajectory.top_speed": "0.2 m/s",
    "trajectory.rest": "0.3 s",
    "instants": ["0.2 s", "0.5 s"],
    "runs": 4,
    "tilt.change": "0 rad",
    "sensor.time_error": "0.2 ms",
    "sensor.noise": {"x": "0.2 mg", "y": "0.2 mg", "z": "0.2 mg"},
}
#: Calibration and time base err little, so that a term's effect stands out.
KNOWN = {
    **{f"calibration.l{a}{b}.uncertainty": 0.0 for a in "xz" for b in "xyz"},
    **{f"calibration.{name}.uncertainty": "0 g" for name in ("bx", "by", "bz")},
    "gravity.uncertainty": "0 m/s²",
    "sensor.time_error": "0 s",
}  # fmt: skip
TERMS = {
    "bias instability": {"bias_instability": "2 mg"},
    "random walk": {"acceleration_random_walk": "0.02 m/s²/√s"},
    "Gauss-Markov drift": {"gauss_markov": {"deviation": "3 mg", "correlation_time": "0.4 s"}},
    "scale factor": {"scale_factor_error": "1 %"},
    "spikes": {"spikes": {"rate": "5 Hz", "amplitude": "50 mg"}},
    "quantisation": {"resolution": "0.4 mg"},
}
OFFSETS = {"turn_on_bias": "5 mg", "miscalibration": ["3 mg", "1 mg", "2 mg"]}
EVERY = {k: v for term in TERMS.values() for k, v in term.items()} | OFFSETS | {
    "misalignment": "0.2 °"
}  # fmt: skip
N = 20_000
#: Five sampling errors of a standard deviation from N groups.
CLOSE = 5 / math.sqrt(2 * N)


def scenario(block=None, **overrides):
    values = {path.replace("__", "."): value for path, value in overrides.items()}
    terms = {} if block is None else {"sensor.accelerometer": block}
    return Scenario.from_yaml(FOLDER / "a1.yaml", {**SHORT, **terms, **values})


def problem(block=None, **overrides):
    s = scenario(block, **overrides)
    return problem_of(s.base, s.folder)


def known(block, **overrides):
    return problem(block, **{k.replace(".", "__"): v for k, v in KNOWN.items()}, **overrides)


# Sums over processes, and the scatter of correlated runs


@pytest.mark.parametrize("drift", [0.0, 0.3])
def test_sums_over_a_process_are_those_of_its_covariance(drift):
    """Against the whole covariance matrix in closed form."""
    group = GroupSamples(7, 9, 3, np.array([4, 9]))
    index, dt = np.arange(group.total), 0.01
    lag = np.abs(np.subtract.outer(index, index)) * dt
    if drift:
        p = processes_of(0.0, 0.0, drift, 0.05, dt, 1.0)
        covariance = drift**2 * np.exp(-lag / 0.05)
    else:
        p = processes_of(0.0, 0.2, 0.0, 1.0, dt, 1.0)
        covariance = 0.2**2 * dt * np.minimum.outer(index, index)
    sums = ProcessSums.of(float(p.decay[0]), float(p.step_variance[0]), float(p.start[0, 0]), group)
    for instant, count in enumerate(group.counts):
        weights = np.zeros((group.runs, group.total))
        weights[:, : group.at_rest] = 1.7 / group.at_rest
        for run in range(group.runs):
            begin = group.at_rest + run * group.steps
            weights[run, begin : begin + count] = -0.3
        expected = weights @ covariance @ weights.T
        np.testing.assert_allclose(sums.covariance(instant, -0.3, 1.7), expected, rtol=1e-9)


@pytest.mark.parametrize("runs", [2, 12, 100])
def test_scatter_of_independent_runs_is_chi(runs):
    covariance = 4.0 * np.eye(runs) + 7.0  # what runs share does not scatter
    c4 = math.sqrt(2 / (runs - 1)) * math.exp(math.lgamma(runs / 2) - math.lgamma((runs - 1) / 2))
    assert mean_scatter(covariance) == pytest.approx(2.0 * c4, rel=1e-9)
    assert mean_square_scatter(covariance) == pytest.approx(4.0, rel=1e-12)
    for p in (0.001, 0.025, 0.5, 0.975):
        expected = 2.0 * math.sqrt(chi2.ppf(p, runs - 1) / (runs - 1))
        assert scatter_quantile(covariance, p) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("runs", [3, 40])
def test_scatter_of_correlated_runs_agrees_with_samples(runs):
    rng = np.random.default_rng(3)
    steps = rng.standard_normal((runs, runs)) * np.exp(-np.arange(runs) / 2.0)
    covariance = steps @ steps.T + 0.01 * np.eye(runs)
    root, count = np.linalg.cholesky(covariance), 200_000
    scatter = (root @ rng.standard_normal((runs, count))).std(axis=0, ddof=1)
    error = scatter.std() / math.sqrt(count)
    assert abs(scatter.mean() - mean_scatter(covariance)) < 5 * error
    for p in (0.05, 0.5, 0.95):
        below = np.mean(scatter < scatter_quantile(covariance, p))
        assert abs(below - p) < 5 * math.sqrt(p * (1 - p) / count)
    # The control: as many independent runs of the same mean square have other quantiles.
    same = math.sqrt(mean_square_scatter(covariance))
    wrong = same * math.sqrt(chi2.ppf(0.05, runs - 1) / (runs - 1))
    assert abs(np.mean(scatter < wrong) - 0.05) > 0.02


# Monte Carlo against the linear model


def deviations(p, seed=7):
    u = p.simulate(seed, 0, N).errors - p.method_errors()[:, None]
    return np.sqrt(np.mean(u**2, axis=1)), u


@pytest.mark.parametrize("source", TERMS)
def test_each_term_alone_has_the_linear_models_moments(source):
    quiet = "0.3 mg" if source == "quantisation" else "1 µg"
    p = known(TERMS[source], sensor__noise=dict.fromkeys("xyz", quiet))
    assert p.is_measured
    linear = p.linear
    share = linear.variances[f"accelerometer {source}"] / linear.second_moment
    rms, u = deviations(p)
    rows = slice(None)
    if source == "scale factor":
        assert share[0] > 0.9
        rows = [0, 1, 3, 4]  # all runs of a group have the same
    elif source != "quantisation":
        assert share.min() > 0.99
    # Spikes have long tails: their squares scatter more than those of normals.
    tolerance = (4 if source == "spikes" else 1) * CLOSE + 0.01
    np.testing.assert_allclose(rms[rows], np.sqrt(linear.second_moment[rows]), rtol=tolerance)
    if source not in ("scale factor", "spikes"):
        np.testing.assert_allclose(u.mean(axis=1)[2::3], linear.mean[2::3], rtol=CLOSE + 0.01)
        for row, quantile in linear.quantiles.items():
            for q in (0.05, 0.5, 0.95):
                below = np.mean(u[row] < quantile(q))
                assert abs(below - q) < 5 * math.sqrt(q * (1 - q) / N) + 0.01


@pytest.mark.parametrize("stamps", ["independent", "stamps"])
def test_all_terms_together_have_the_linear_models_moments(stamps):
    p = problem(EVERY, sensor__time_errors=stamps, sensor__time_error="1 ms")
    linear = p.linear
    rms, u = deviations(p)
    np.testing.assert_allclose(rms, np.sqrt(linear.second_moment), rtol=CLOSE + 0.01)
    np.testing.assert_allclose(u.mean(axis=1)[2::3], linear.mean[2::3], rtol=CLOSE + 0.01)
    np.testing.assert_allclose(sum(linear.variances.values()), linear.second_moment, rtol=1e-12)
    assert {f"accelerometer {source}" for source in TERMS} <= set(linear.variances)
    # The control: one term less would be seen.
    fewer = {key: value for key, value in EVERY.items() if key != "acceleration_random_walk"}
    wrong = np.sqrt(problem(fewer, sensor__time_errors=stamps).linear.second_moment)
    assert (np.abs(wrong / rms - 1.0) > CLOSE + 0.01).any()


def test_controls_are_the_linear_errors():
    """Where the errors are small, a group's controls are its errors, run by run and at rest."""
    small = {
        "bias_instability": "2 µg",
        "acceleration_random_walk": "2e-5 m/s²/√s",
        "gauss_markov": {"deviation": "3 µg", "correlation_time": "0.4 s"},
        "scale_factor_error": "10 ppm",
        "misalignment": "1e-3 °",
        "turn_on_bias": "5 µg",
    }
    noise = dict.fromkeys("xyz", "1 µg")
    for stamps in ("independent", "stamps"):
        p = known(small, sensor__noise=noise, sensor__time_errors=stamps)
        p = replace(p, time_error=1e-6)
        sample = p.simulate(11, 0, 1000, controls=True)
        u = sample.errors - p.method_errors()[:, None]
        rows = [0, 1, 3, 4]
        residual = (u - sample.controls).std(axis=1)[rows] / u.std(axis=1)[rows]
        assert residual.max() < 2e-4
        assert (sample.controls[2::3] == 0.0).all()


@pytest.mark.slow
def test_controls_have_the_moments_that_the_estimator_assumes():
    p = problem(EVERY)
    controls = p.simulate(4, 0, 100_000, controls=True).controls
    rows = [0, 1, 3, 4]
    np.testing.assert_allclose(
        np.mean(controls**2, axis=1)[rows],
        p.linear.control_second_moment[rows],
        rtol=5 * math.sqrt(2e-5),
    )
    mean = controls.mean(axis=1)[rows] / np.sqrt(p.linear.control_second_moment[rows])
    assert np.abs(mean).max() < 5 / math.sqrt(100_000)
    # Rounding and spikes are the Monte Carlo's own.
    assert (p.linear.control_second_moment[rows] < p.linear.second_moment[rows]).all()


def test_saturation_leaves_right_intervals():
    """Far from the linear model the controls must not do harm."""
    block = {"range": "866 mg", "bias_instability": "2 mg"}
    values = []
    for estimator in ("plain", "control_variate"):
        settings = {"monte_carlo__realizations": 4000, "monte_carlo__estimator": estimator}
        table = mcsim.run(scenario(block, **settings)).table
        rows = table[table["statistic"] == "std"]
        values.append(rows[["value", "ci_low", "ci_high"]].to_numpy())
    plain, controlled = values
    width = plain[:, 2] - plain[:, 1]
    assert (np.abs(controlled[:, 0] - plain[:, 0]) < width).all()
    assert (controlled[:, 2] - controlled[:, 1] < 1.05 * width).all()


# The naive twin

TWIN = {
    "noise": Terms(noise=2e-4 * G),
    "drift": Terms(noise=2e-4 * G, drift=3.0 * MG * G, correlation_time=0.4),
    "walk": Terms(noise=2e-4 * G, walk=0.02),
    "all": Terms(
        noise=2e-4 * G,
        offset=5.0 * MG * G,
        scale=0.01,
        angle=math.radians(0.2),
        walk=0.02,
        drift=3.0 * MG * G,
        correlation_time=0.4,
        resolution=2.0 * MG * G,
        range=866.0 * MG * G,
        spike_rate=2.0,
        spike_height=20.0 * MG * G,
    ),
}
BLOCKS = {
    "noise": {"range": "1.2 g", "resolution": "1e-9 g"},
    "drift": TERMS["Gauss-Markov drift"],
    "walk": TERMS["random walk"],
    "all": {
        **TERMS["Gauss-Markov drift"],
        **TERMS["random walk"],
        **TERMS["scale factor"],
        "misalignment": "0.2 °",
        "turn_on_bias": "5 mg",
        "resolution": "2 mg",
        "range": "866 mg",
        "spikes": {"rate": "2 Hz", "amplitude": "20 mg"},
    },
}
GROUPS = 5000


@pytest.mark.slow
@pytest.mark.parametrize("name", TWIN)
def test_a_naive_simulation_has_the_same_distribution(name):
    p = problem(BLOCKS[name])
    assert p.is_measured
    naive = velocity_sensor_numpy.errors(p, TWIN[name], G, GROUPS, seed=1)
    ours = p.simulate(2, 0, GROUPS).errors
    for one, other in zip(naive, ours, strict=True):
        assert ks_2samp(one, other).pvalue > 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "mistake"),
    [
        ("drift", "drift_starts_at_zero"),
        ("drift", "noise_starts_anew"),
        ("walk", "walk_steps_with_dt"),
        ("walk", "noise_starts_anew"),
    ],
)
def test_common_mistakes_would_be_seen(name, mistake):
    """The controls: a drift that starts at zero, steps with dt, noise that starts anew."""
    p = problem(BLOCKS[name])
    wrong = replace(TWIN[name], **{mistake: True})
    naive = velocity_sensor_numpy.errors(p, wrong, G, GROUPS, seed=1)
    ours = p.simulate(2, 0, GROUPS).errors
    assert min(ks_2samp(a, b).pvalue for a, b in zip(naive, ours, strict=True)) < 1e-6


@pytest.mark.slow
def test_flicker_is_that_of_kasdin():
    """The sum of processes against exact 1/f noise: deviations within 3 % and sampling error."""
    groups = 2000
    p = problem({"bias_instability": "5 mg"})
    terms = Terms(noise=2e-4 * G, bias_instability=5.0 * MG * G)
    naive = velocity_sensor_numpy.errors(p, terms, G, groups, seed=1)
    ours = p.simulate(2, 0, N).errors
    centre = p.method_errors()[:, None]
    rms = [np.sqrt(np.mean((e - centre) ** 2, axis=1)) for e in (naive, ours)]
    np.testing.assert_allclose(rms[0], rms[1], rtol=0.03 + 4 / math.sqrt(2 * groups))


def test_flicker_spans_the_rest_and_all_runs():
    p = problem({"bias_instability": "5 mg"})
    longest = -p.interval / math.log(p.sensor_errors.processes[0].decay.max())
    # The longest process stands for a piece of up to a factor of four below ten groups.
    group = 0.3 + 4 * 0.5
    assert 5.0 * group <= longest < 10.0 * group


def test_what_is_drawn_once_is_measured_exactly():
    """Scale factor, angles, offsets, saturation and rounding, without any noise."""
    block = {
        "scale_factor_error": "1 %",
        "misalignment": "0.5 °",
        "turn_on_bias": "5 mg",
        "resolution": "3 mg",
        "range": "866 mg",
    }
    p = known(block, sensor__noise=dict.fromkeys("xyz", "0 g"))
    groups = 64
    z = net_normals(5, 0, groups, groups, drawn_rows(True, 9)).astype(float)
    mixing = np.zeros((groups, 3, 3))
    for row, entry in enumerate(p.measurement.errors.mixing):
        mixing[:, entry.target, entry.source - 3] = z[17 + row]
    angle = math.radians(0.5) * (1.0 - np.eye(3)) + 0.01 * np.eye(3)
    rest, bias = p.inputs[9:12], p.inputs[6:9]
    raw = np.concatenate([np.tile(rest, (p.at_rest, 1)), *[p.raw] * p.runs])
    output = raw + np.einsum("gij,nj->gni", angle * mixing, raw - bias)
    output += 5.0 * MG * z[14:17].T[:, None]
    exact = velocity_sensor_numpy.digitised(output, 866.0 * MG, 3.0 * MG)
    q = np.repeat(p.inputs[:, None], groups, axis=1)
    intervals = np.full((p.runs, len(p.raw), groups), p.interval)
    expected = velocity_sensor_numpy.integrated(p, exact, q, intervals)[:, p.steps - 1]
    errors = p.simulate(5, 0, groups, net=groups).errors
    truth = p.truth[p.steps][:, None]
    np.testing.assert_allclose(errors[0::3], expected[0] - truth, atol=1e-12)
    np.testing.assert_allclose(errors[1::3], expected.mean(axis=0) - truth, atol=1e-12)
    # The controls: without saturation or rounding it is another velocity.
    for largest, step in ((np.inf, 3.0 * MG), (866.0 * MG, 0.0)):
        other = velocity_sensor_numpy.digitised(output, largest, step)
        wrong = velocity_sensor_numpy.integrated(p, other, q, intervals)[0, p.steps - 1]
        assert np.abs(errors[0::3] - wrong + truth).max() > 1e-3


@pytest.mark.parametrize("stamps", ["independent", "stamps"])
def test_noise_at_rest_and_moving_is_that_of_the_plain_twin(stamps):
    """Measured without effect: the plain twin, with the mean of the samples at rest."""
    p = problem({"resolution": "1e-12 g"}, sensor__time_errors=stamps)
    groups = np.arange(130)
    at_rest = white_noise(77, groups, p.at_rest, REST_NOISE).mean(axis=0)
    # The twin draws the mean at rest as one of the group's inputs: put it in its place.
    moved = replace(p, uncertainties=np.where(np.arange(14) // 3 == 3, 0.0, p.uncertainties))
    curves = p.velocities(77, 0, len(groups))
    for group in (0, 1, 127, 128, 129):
        inputs = p.inputs.copy()
        inputs[9:12] += p.white * at_rest[:, group]
        expected = velocity_numpy.velocities(
            replace(moved, inputs=inputs), 77, groups[group : group + 1]
        )
        np.testing.assert_allclose(curves[:, :, group], expected[:, :, 0].T, atol=2e-6)


# Rates, bandwidth, offsets


def test_drifts_do_not_depend_on_the_rate():
    for source in ("random walk", "Gauss-Markov drift"):
        slow, fast = (
            known(TERMS[source], sensor__rate=rate, sensor__noise=dict.fromkeys("xyz", "1 µg"))
            for rate in ("100 Hz", "400 Hz")
        )
        a, b = (np.sqrt(q.linear.second_moment) for q in (slow, fast))
        np.testing.assert_allclose(a, b, rtol=0.03)


def test_limited_bandwidth_delays_the_velocity():
    """A constant acceleration a from rest: the velocity lags by a tau (1 - exp(-t / tau))."""
    values = {
        "trajectory__mounting_angle": "0 rad",
        "instants": ["0.05 s", "0.1 s"],
        "tilt__order": "exact",
    }
    tau = 1.0 / (2.0 * math.pi * 5.0)
    expected = [-2.0 * tau * (1.0 - math.exp(-t / tau)) for t in (0.05, 0.1)]
    for sampling in ("average", "none"):
        p = problem({"bandwidth": "5 Hz"}, sensor__sampling=sampling, **values)
        assert not p.is_measured
        # Momentary samples are summed by a rectangular rule that misses half the last one.
        last = [1.0 - math.exp(-t / tau) for t in (0.05, 0.1)]
        missed = 0.5 * p.interval * 2.0 * np.array(last) if sampling == "none" else 0.0
        lag = p.method_errors()[0::3] + missed
        np.testing.assert_allclose(lag, expected, atol=1e-7 if sampling == "average" else 2e-3)
    wide = problem({"bandwidth": "10 kHz"}, **values).method_errors()
    assert np.abs(wide).max() < 2.0 / (2.0 * math.pi * 10e3) + 1e-6


def test_offsets_cancel_between_rest_and_run_and_cost_nothing():
    """An offset acts as an error of the zero bias: both add, and cancel alike."""
    p = problem(OFFSETS)
    assert not p.is_measured
    bias = MG * np.hypot([3.0, 1.0, 2.0], 5.0)
    errors = p.uncertainties[6:9]
    same = problem(
        **{
            f"calibration__b{axis}__uncertainty": f"{np.hypot(u, b)} g"
            for axis, u, b in zip("xyz", errors, bias, strict=True)
        }
    )
    one, other = (q.simulate(3, 0, 1000, controls=True) for q in (p, same))
    np.testing.assert_allclose(one.errors, other.errors, atol=1e-12)
    np.testing.assert_allclose(one.controls, other.controls, atol=1e-12)
    np.testing.assert_allclose(p.linear.second_moment, same.linear.second_moment, rtol=1e-9)
    variances = p.linear.variances
    assert "accelerometer turn-on bias" in variances
    uncancelled = 5.0 * MG * G * 0.2  # after 0.2 s
    assert math.sqrt(variances["accelerometer turn-on bias"][0]) < 0.01 * uncancelled


# What is left out costs nothing


def test_white_noise_alone_takes_the_fast_path():
    bare = problem()
    for block in ({}, {"range": "15 g"}, {"noise_density": "0 µg/√Hz", "range": "15 g"}):
        if "noise_density" in block:
            noise = [f"{1e3 * math.sqrt(2.0 / 100.0) * 0.2:.15g} µg/√Hz"]
            p = problem({**block, "noise_density": noise}, sensor__noise=None)
            np.testing.assert_allclose(p.white, 0.2 * MG, rtol=1e-12)
        else:
            p = problem(block)
            one, other = (q.simulate(3, 0, 300, controls=True) for q in (p, bare))
            np.testing.assert_array_equal(one.errors, other.errors)
            np.testing.assert_array_equal(one.controls, other.controls)
        assert p.measurement.terms.innovation.shape == (0, 3)
        assert not p.is_measured
        assert list(p.linear.variances) == list(bare.linear.variances)
        assert p.n_samples == bare.n_samples
    assert problem({"range": "866 mg"}).is_measured


# Groups do not depend on how they are simulated


def test_groups_do_not_depend_on_how_they_are_simulated():
    p = problem(EVERY)
    whole = p.simulate(3, 0, 300, controls=True)
    parts = [p.simulate(3, first, 100, controls=True) for first in (0, 100, 200)]
    np.testing.assert_array_equal(whole.errors, np.concatenate([q.errors for q in parts], 1))
    np.testing.assert_array_equal(whole.controls, np.concatenate([q.controls for q in parts], 1))
    np.testing.assert_array_equal(p.simulate(3, 0, 300).errors, whole.errors)
    settings = scenario(EVERY).base.monte_carlo.model_copy(update={"realizations": 9000})
    one, two = (run_point(p, settings, 5, threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one.estimates.low, two.estimates.low)
    # The first run is the same however many follow.
    digital = {"resolution": "1 mg", "scale_factor_error": "1 %"}
    fewer, more = (problem(digital, runs=n).simulate(3, 0, 300).errors for n in (2, 4))
    np.testing.assert_array_equal(fewer[0::3], more[0::3])
    # Other instants leave the same runs, whose sensor goes on beyond the last of them.
    early = problem(EVERY, instants=["0.2 s"]).simulate(3, 0, 300, controls=True)
    np.testing.assert_array_equal(early.errors, whole.errors[:3])
    np.testing.assert_allclose(early.controls, whole.controls[:3], atol=1e-15)


def test_sobol_points_serve_offsets_and_mixing():
    settings = {"monte_carlo__offsets": "sobol", "monte_carlo__realizations": 4096}
    block = {"scale_factor_error": "1 %", "resolution": "1 mg"}
    table = mcsim.run(scenario(block, **settings)).table
    linear = problem(block).linear.second_moment
    rms = table[table["statistic"] == "rms"]["value"].to_numpy()
    np.testing.assert_allclose(rms[:2], np.sqrt(linear[:2]), rtol=5 / math.sqrt(2 * 4096) + 0.01)


# Scenario


def test_a_catalogue_sensor_gives_noise_density_and_terms():
    s = scenario("MPU-9250", sensor__noise=None)
    p = problem_of(s.base, s.folder)
    # 300 µg/√Hz at 100 Hz; the scenario's g is not the standard one of the catalogue.
    np.testing.assert_allclose(p.white, 300e-6 * math.sqrt(50.0) * 9.80665 / G, rtol=1e-9)
    assert {"accelerometer bias instability", "accelerometer random walk"} <= set(
        p.linear.variances
    )
    noisier = problem({"model": "MPU-9250", "bias_instability": "1 mg"})
    np.testing.assert_allclose(noisier.white, 2e-4)  # the scenario's own noise holds
    assert (
        noisier.linear.variances["accelerometer bias instability"][0]
        > (p.linear.variances["accelerometer bias instability"][0])
    )


@pytest.mark.slow
def test_terms_and_sensors_can_be_swept(tmp_path):
    s = Scenario.from_yaml(
        FOLDER / "a1.yaml",
        {
            **SHORT,
            "sensor.noise": None,
            "sensor.accelerometer": "MPU-9250",
            "sweep.sensor.accelerometer.bias_instability": ["0.1 mg", "5 mg"],
            "monte_carlo.realizations": 300,
        },
    )
    table = mcsim.run(s, output=tmp_path).table
    rms = table[(table["statistic"] == "rms") & (table["error"] == "velocity")]["value"]
    assert rms.iloc[-1] > 1.5 * rms.iloc[0]
    by_name = {**SHORT, "sensor.noise": None, "monte_carlo.realizations": 300,
               "sweep.sensor.accelerometer": ["MPU-9250", "BNO055"]}  # fmt: skip
    table = mcsim.run(Scenario.from_yaml(FOLDER / "a1.yaml", by_name)).table
    assert set(table["sensor.accelerometer"]) == {"MPU-9250", "BNO055"}


def test_a_sensor_file_is_read_beside_the_scenario(tmp_path):
    (tmp_path / "mine.yaml").write_text(
        "accelerometer:\n  velocity_random_walk: 0.1 m/s/√h\n  bias_instability: 2 m/s/h\n",
        encoding="utf-8",
    )
    tree = dict(scenario().document.tree)
    tree["sensor"] = {"rate": "100 Hz", "accelerometer": "mine.yaml"}
    s = Scenario.from_dict(tree, folder=tmp_path)
    assert s.base.files == ("mine.yaml",)
    p = problem_of(s.base, s.folder)
    np.testing.assert_allclose(p.white, 0.1 / 60.0 * 10.0 / G, rtol=1e-9)
    assert "accelerometer bias instability" in p.linear.variances
    tree["sensor"] = {"rate": "100 Hz", "accelerometer": "other.yaml"}
    with pytest.raises(InputError, match=r"sensor\.accelerometer: .*other\.yaml: no such file"):
        Scenario.from_dict(tree, folder=tmp_path)


def test_the_schema_knows_the_block():
    import jsonschema

    from mcsim.scenario_file.schema import scenario_schema

    check = jsonschema.Draft7Validator(scenario_schema())
    tree = dict(scenario().document.tree)
    for sensor in ("MPU-9250", {"model": "MPU-9250", "resolution": "1 mg"}, EVERY):
        tree["sensor"] = {"rate": "100 Hz", "accelerometer": sensor}
        assert check.is_valid(tree)
    tree["sensor"] = {"rate": "100 Hz", "accelerometer": {"resolutions": "1 mg"}}
    assert not check.is_valid(tree)


@pytest.mark.parametrize(
    ("block", "overrides", "message"),
    [
        (None, {"sensor__noise": None}, r"sensor: no noise is given; write `noise: \{x: 3\.8e-3 g"),
        ("LIS33DE", {"sensor__noise": None}, "LIS33DE: no noise is given"),
        ({"noise_density": "300 µg/√Hz"}, {}, "`noise` and `accelerometer.noise_density` say the"),
        ({"velocity_random_walk": "0.1 m/s/√h"}, {}, "`accelerometer.velocity_random_walk` say"),
        ("MPU-9255", {}, 'no sensor "MPU-9255" in the catalogue.*MPU-9250'),
        ({"bias_instability": "-1 mg"}, {}, "must be at least 0"),
        ({"g_sensitivity": "1 °/s/g"}, {}, 'unknown key "g_sensitivity"'),
        ({"resolution": "1 mg"}, {"trajectory__rest": "1 h", "sensor__rate": "1 kHz"},
         "3,602,000 samples, more than the 1,000,000"),
        ({"resolution": "1 mg"}, {"runs": 1000, "instants": [f"{i / 100} s" for i in range(1, 11)]},
         "1000 runs at 10 instants"),
    ],
)  # fmt: skip
def test_bad_blocks_are_explained(block, overrides, message):
    def check():
        s = scenario(block, **overrides)
        check_point(s.base, s.folder)

    with pytest.raises(InputError, match=message):
        check()


def test_what_is_wrong_within_the_blocks_comes_before_noise_written_twice():
    noise = {"x": "1 m", "y": "1e-3 g", "z": "-1e-3 g"}
    with pytest.raises(InputError) as error:
        scenario({"noise_density": "300 µg/√Hz"}, sensor__noise=noise)
    first, second = str(error.value).splitlines()
    assert 'sensor.noise.x: "1 m" is a length' in first
    assert 'sensor.noise.z: "-1e-3 g" must be at least 0 g' in second


def alone(duration, estimator="control_variate", **deviations):
    """A summary of an ideal level sensor with an unknown turn-on bias, and its results."""
    exact = {"estimate": 1.0}
    none = {"estimate": "0 g"}
    tree = {
        "case": "velocity",
        "trajectory": {"top_speed": "0.4 m/s", "duration": duration, "rest": "1 s"},
        "sensor": {
            "rate": "100 Hz",
            "noise": dict.fromkeys("xyz", "0 g"),
            "accelerometer": deviations,
        },
        "calibration": {"lxx": exact, "lzz": exact, "bx": none, "bz": none},
        "monte_carlo": {"realizations": 1000, "estimator": estimator},
    }
    results = mcsim.run(Scenario.from_dict(tree))
    return summary(results), results


def test_the_summary_tells_what_the_first_order_cannot():
    """An offset of x tilts the rest by itself over g and cancels."""
    text, results = alone("1.5 s", turn_on_bias="1 m/s²")
    assert len(results.budget) == 0
    std = results.table.set_index(["error", "statistic"])["value"]["velocity", "std"]
    assert std > 1e-3
    assert text.endswith(
        "to first order nothing disturbs this run: what scatters is of higher order"
    )
    text, _ = alone("1.5 s", "linear", turn_on_bias="1 m/s²")
    assert text.endswith("to first order nothing disturbs this run")
    # Control: a run without any error.
    text, _ = alone("1.5 s", turn_on_bias="0 m/s²")
    assert text.endswith("\nnothing disturbs this run")


def test_the_summary_says_how_much_the_budget_explains():
    terms = {"turn_on_bias": "1 m/s²", "bias_instability": "1 µg"}
    text, results = alone("1.5 s", **terms)
    row = results.table.set_index(["error", "statistic"]).loc[("velocity", "std")]
    linear = math.sqrt((results.budget.query("error == 'velocity'")["std"] ** 2).sum())
    assert row["value"] > 2 * linear
    said = f"explains {linear:.3g} m/s of a standard deviation of {row['value']:.3g} m/s"
    assert said in text
    # Control: small errors are linear.
    text, _ = alone("1.5 s", bias_instability="1 mg")
    assert "explains" not in text


# Budget


def test_the_budget_says_what_its_equations_leave_out():
    course = course_of_uncertainty(scenario(TERMS["Gauss-Markov drift"]).base, 2000)
    assert course.sensor_terms == ("Gauss-Markov drift",)
    alone = course.simulated["accelerometer terms"][-1]
    p = problem(TERMS["Gauss-Markov drift"])
    variance = p.linear.variances["accelerometer Gauss-Markov drift"][3]
    assert alone == pytest.approx(math.sqrt(variance), rel=5 / math.sqrt(4000))
    words = " ".join(comparison_words(course).split())
    assert "leave out the accelerometer's own terms (Gauss-Markov drift)" in words
    assert f"{alone:.2g} m/s" in words
    table = comparison_table(course)
    rows = table[table["source"] == "accelerometer terms"]
    assert set(rows["method"]) == {"Monte Carlo"}
    plain = course_of_uncertainty(scenario().base, 200)
    assert "accelerometer terms" not in plain.simulated
    assert "leave out" not in comparison_words(plain)
