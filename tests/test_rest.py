"""Rest before the run: calibration and levelling see all that stands in the sensor's output."""

import math

import numpy as np
import pytest

from mcsim.kernels.measurement import mean_output
from mcsim.sensor_terms.mechanisms.digitise import rounding_variances
from mcsim.sensors.coloured import after_calibration, with_mean
from mcsim.sensors.rest import spread_at_rest
from mcsim.units import STANDARD_GRAVITY
from tests import conftest, strapdown
from tests.conftest import NO_NOISE, processes_of
from tests.reference.rest_numpy import along_errors
from tests.test_error_terms import CLOSE, STRAIGHT, covariance_of

N = 20_000
STEP = 0.1
#: Half a minute of rest and two seconds of driving straight on at 10 Hz.
SHORT = {
    **NO_NOISE,
    "trajectory": {"shape": "straight", "length": "20 m", "speed": "10 m/s", "lead": "0 s"},
    "sensors.sampling": "none",
    "sensors.rate": "10 Hz",
}
ALONG, HEADING = 0, 6
ACCELEROMETER = "sensors.accelerometer"
WHITE = {f"{ACCELEROMETER}.noise_density": "0.01 m/s²/√Hz"}
DRIFT = {f"{ACCELEROMETER}.gauss_markov": {"deviation": "0.1 m/s²", "correlation_time": "3 s"}}
WALK = {f"{ACCELEROMETER}.acceleration_random_walk": "0.02 m/s²/√s"}
LEVELLED = {"initial.levelling": {"duration": "3 s"}}
CALIBRATED = {"sensors.calibration": {"duration": "2 s"}}
ONE = 0.01 * math.sqrt(5.0)
#: Scenario values, and the same for the plain simulation.
CASES = {
    "white": ({**WHITE, **LEVELLED}, {"white": ONE}),
    "drift": ({**DRIFT, **LEVELLED}, {"drift": 0.1, "time": 3.0}),
    "walk": ({**WALK, **WHITE, **LEVELLED}, {"walk": 0.02, "white": ONE}),
    "spikes": (
        {f"{ACCELEROMETER}.spikes": {"rate": "2 Hz", "amplitude": "0.3 m/s²"}, **LEVELLED},
        {"spikes": (2.0, 0.3)},
    ),
    "residue": (
        {**DRIFT, **WHITE, **CALIBRATED, **LEVELLED},
        {"drift": 0.1, "time": 3.0, "white": ONE, "calibration": 20},
    ),
    "residue of a walk": (
        {**WALK, **WHITE, **CALIBRATED, **LEVELLED},
        {"walk": 0.02, "white": ONE, "calibration": 20},
    ),
    "coarse steps": (
        {**WHITE, f"{ACCELEROMETER}.resolution": "0.2 m/s²", **LEVELLED,
         f"{ACCELEROMETER}.turn_on_bias": "1 m/s²"},
        {"white": ONE, "resolution": 0.2, "bias": 1.0},
    ),
    "steps of the noise": (
        {**WHITE, f"{ACCELEROMETER}.resolution": "0.04 m/s²", **LEVELLED,
         f"{ACCELEROMETER}.turn_on_bias": "1 m/s²"},
        {"white": ONE, "resolution": 0.04, "bias": 1.0},
    ),
    "steps and drift": (
        {**DRIFT, f"{ACCELEROMETER}.resolution": "0.3 m/s²", **LEVELLED,
         f"{ACCELEROMETER}.turn_on_bias": "1 m/s²"},
        {"drift": 0.1, "time": 3.0, "resolution": 0.3, "bias": 1.0},
    ),
    "calibrated steps": (
        {**WHITE, f"{ACCELEROMETER}.resolution": "0.2 m/s²", **CALIBRATED, **LEVELLED,
         f"{ACCELEROMETER}.turn_on_bias": "1 m/s²"},
        {"white": ONE, "resolution": 0.2, "bias": 1.0, "calibration": 20},
    ),
    "a range that the bias leaves": (
        {**WHITE, f"{ACCELEROMETER}.range": "[1 m/s², 100 m/s², 100 m/s²]", **LEVELLED,
         f"{ACCELEROMETER}.turn_on_bias": "1 m/s²"},
        {"white": ONE, "largest": 1.0, "bias": 1.0},
    ),
}  # fmt: skip


def simulated(values, rows=ALONG, n=N):
    values = dict(values)
    ranges = values.pop(f"{ACCELEROMETER}.range", None)
    if ranges is not None:
        values[f"{ACCELEROMETER}.range"] = ranges.strip("[]").split(", ")
    p = strapdown.problem({**SHORT, **values})
    return p, p.simulate(5, 0, n).errors[rows]


@pytest.mark.parametrize("rule", ["rectangular", "forward_euler"])
@pytest.mark.parametrize("name", CASES)
def test_all_that_stands_in_the_output_at_rest_is_levelled_with_it(name, rule):
    values, twin = CASES[name]
    p, found = simulated({**values, "reconstruction.integration": rule})
    expected = along_errors(
        np.random.default_rng(3), N, STEP, twin.get("calibration", 0), 30, p.n_samples,
        rule == "forward_euler", **{k: v for k, v in twin.items() if k != "calibration"},
    )  # fmt: skip
    # Rounding is not normal, and the mean of correlated samples in wide steps is approximate.
    room = 0.06 if "resolution" in twin else 0.01
    assert found.std() == pytest.approx(expected.std(), rel=2 * CLOSE + room)
    if not ({"resolution", "largest"} & set(twin)):
        linear = math.sqrt(p.linear.second_moment[ALONG])
        assert found.std() == pytest.approx(linear, rel=CLOSE + 0.005)
        assert sum(p.linear.variances.values())[ALONG] == pytest.approx(linear**2, rel=1e-9)


def test_without_the_rest_the_errors_would_be_others():
    """The control: the former model, where in-run noise began with the run."""
    _, found = simulated({**DRIFT, **LEVELLED})
    fresh = along_errors(np.random.default_rng(3), N, STEP, 0, 0, 20, False, drift=0.1, time=3.0)
    assert abs(found.std() / fresh.std() - 1.0) > 0.1


@pytest.mark.parametrize("rule", strapdown.RULES)
@pytest.mark.parametrize("calibrated", [False, True])
def test_a_drift_without_end_is_an_offset(rule, calibrated):
    """Same covariance of all errors, by the linear model, and the same simulated deviations."""
    both = {**WHITE, "sensors.gyroscope.noise_density": "0.03 °/s/√Hz", **LEVELLED,
            "reconstruction.integration": rule, "body.bank": "2 °"}  # fmt: skip
    if calibrated:
        both |= CALIBRATED
    drift = {f"{ACCELEROMETER}.gauss_markov":
             {"deviation": "0.2 m/s²", "correlation_time": "1e8 s"}}  # fmt: skip
    offset = {f"{ACCELEROMETER}.turn_on_bias": "0.2 m/s²"}
    one, other = (strapdown.problem({**SHORT, **both, **own}) for own in (drift, offset))
    np.testing.assert_allclose(one.linear.second_moment, other.linear.second_moment, rtol=1e-4)
    a, b = (p.simulate(5, 0, N).errors.std(axis=1) for p in (one, other))
    np.testing.assert_allclose(a, b, rtol=2 * CLOSE, atol=1e-12)


def test_the_mean_and_what_follows_have_the_covariance_of_their_samples():
    p = processes_of(0.1, 0.2, 0.3, 0.4, 0.01, 5.0)
    n = 60
    covariance = covariance_of(p, 0.5, n + 1)
    found = with_mean(p, 0.5, n)
    mean = np.full(n, 1.0 / n)
    assert found[-1, -1] == pytest.approx(mean @ covariance[:n, :n] @ mean, rel=1e-9)
    assert found[-1, :-1].sum() == pytest.approx(covariance[n, :n] @ mean, rel=1e-9)
    assert found[:-1, :-1].sum() == pytest.approx(covariance[n, n] - 0.25, rel=1e-9)
    own = np.trace(covariance[:n, :n]) / n - found[-1, -1]
    assert spread_at_rest(p, 0.5, n) == pytest.approx(math.sqrt(own), rel=1e-9)


@pytest.mark.parametrize("spread", [0.0, 0.05, 0.2, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("largest", [math.inf, 1.3])
@pytest.mark.parametrize("resolution", [0.0, 0.5])
def test_mean_output_is_the_mean_of_the_digitised_output(spread, largest, resolution):
    z = np.random.default_rng(1).standard_normal(200_000)
    for value in (-2.0, -0.26, 0.0, 0.1, 0.24, 1.2):
        cut = np.clip(value + spread * z, -largest, largest)
        out = resolution * np.floor(cut / resolution + 0.5) if resolution else cut
        found, _ = mean_output(value, spread, largest, resolution)
        # Wide noise is taken to leave no trace of the steps; at the range half a step may stay.
        room = 5 * out.std() / math.sqrt(len(z)) + 1e-9
        if resolution and math.isfinite(largest) and spread > 1.5 * resolution:
            room += 0.5 * resolution
        assert abs(found - out.mean()) < room


@pytest.mark.parametrize("spread", [0.0, 0.1, 0.3, 0.5, 1.0])
def test_rounding_of_means_splits_into_what_lasts_and_what_averages(spread):
    rng = np.random.default_rng(2)
    value = rng.random(4000)[:, None]
    noise = spread * rng.standard_normal((4000, 50))
    rounded = np.floor(value + noise + 0.5)

    def mean(place):
        return np.array([mean_output(v, spread, math.inf, 1.0)[0] for v in place])

    # The mean output moves with the noise's mean, where it lies between two steps.
    slope = (mean(value[:, 0] + 1e-4) - mean(value[:, 0] - 1e-4)) / 2e-4 if spread else 0.0
    slope = np.broadcast_to(slope, 4000)
    means = mean(value[:, 0])
    single = np.mean((rounded - means[:, None] - slope[:, None] * noise) ** 2)
    lasting, averaging = rounding_variances(1.0, spread)
    own = np.mean([mean_output(v, spread, math.inf, 1.0)[1] for v in value[:, 0]])
    assert averaging == pytest.approx(own, abs=0.002)
    assert lasting == pytest.approx(np.mean((means - value[:, 0]) ** 2), abs=0.005)
    assert averaging == pytest.approx(single, abs=0.004)


# Calibration


@pytest.mark.parametrize("algorithm", ["strapdown", "planar"])
@pytest.mark.parametrize("bank", ["0 °", "5 °"])
def test_calibration_takes_away_what_gravity_makes_of_a_gyroscope(algorithm, bank):
    """On a straight run nothing but gravity acts: calibrated, no bias is left of it."""
    values = {**SHORT, "reconstruction.algorithm": algorithm, "body.bank": bank,
              "sensors.gyroscope.g_sensitivity": "1 °/s/g"}  # fmt: skip
    p = strapdown.problem(values)
    uncalibrated = p.simulate(3, 0, N).errors[HEADING].std()
    # Only the force upwards has been there all the time; on a bank the left axis shares it.
    assert uncalibrated == pytest.approx(math.radians(1.0) * 2.0, rel=CLOSE)
    p = strapdown.problem({**values, **CALIBRATED})
    assert p.simulate(3, 0, N).errors[HEADING].std() < 1e-12


def test_planar_and_strapdown_mean_the_same_calibration():
    values = {
        "sensors.gyroscope.g_sensitivity": "1 °/s/g",
        "sensors.accelerometer.misalignment": "0.5 °",
        "sensors.accelerometer.scale_factor_error": "1 %",
        "sensors.calibration": {"duration": "5 s"},
        "monte_carlo.realizations": 100,
    }
    plane, space = conftest.problem(values), strapdown.problem(values)
    a, b = (np.sqrt(p.linear.second_moment) for p in (plane, space))
    assert a[3] == pytest.approx(b[HEADING], rel=2e-3)
    # Gravity makes no offset of the accelerometers, either, once that is calibrated away.
    del values["sensors.gyroscope.g_sensitivity"]
    plane, space = conftest.problem(values), strapdown.problem(values)
    source = "accelerometer misalignment"
    a, b = (np.sqrt(p.linear.variances[source][:2]) for p in (plane, space))
    np.testing.assert_allclose(a, b, rtol=0.02)
    del values["sensors.calibration"]
    uncalibrated = np.sqrt(conftest.problem(values).linear.variances[source][:2])
    assert (uncalibrated > 3.0 * a).all()


def test_gravity_shows_in_misaligned_level_axes():
    p = conftest.problem({**STRAIGHT, **NO_NOISE, "sensors.accelerometer.misalignment": "0.2 °"})
    across = p.simulate(5, 0, N).errors[1].std()
    duration = p.n_samples * p.interval
    expected = STANDARD_GRAVITY * math.radians(0.2) * duration**2 / 2
    assert across == pytest.approx(expected, rel=CLOSE + 0.003)
    linear = math.sqrt(p.linear.variances["accelerometer misalignment"][1])
    assert across == pytest.approx(linear, rel=CLOSE)


@pytest.mark.parametrize("case", [conftest, strapdown])
def test_a_bias_calibrated_away_still_uses_up_the_range(case):
    """Speeding up at 1 m/s² with a bias of 0.5 m/s² RMS, seen by a sensor that ends at 1.2."""
    values = {**SHORT, "trajectory.deceleration": "-1 m/s²", **CALIBRATED, **WHITE,
              f"{ACCELEROMETER}.turn_on_bias": ["0.5 m/s²", "0 m/s²", "0 m/s²"],
              f"{ACCELEROMETER}.range": ["1.2 m/s²", "100 m/s²", "100 m/s²"]}  # fmt: skip
    p = case.problem(values)
    found = p.simulate(5, 0, N).errors[ALONG] - p.method_errors()[ALONG]
    expected = along_errors(
        np.random.default_rng(4), N, STEP, 20, 0, p.n_samples, False,
        bias=0.5, signal=1.0, largest=1.2, white=ONE,
    )  # fmt: skip
    # The acceleration begins at the first sample, a jump, which the momentary sample halves.
    assert found.mean() == pytest.approx(expected.mean(), rel=0.06)
    assert found.std() == pytest.approx(expected.std(), rel=0.06)
    free = case.problem({**values, f"{ACCELEROMETER}.range": "100 m/s²"})
    assert abs(free.simulate(5, 0, N).errors[ALONG].mean() - free.method_errors()[ALONG]) < 0.02
    assert found.mean() < -0.1


@pytest.mark.parametrize("rule", strapdown.RULES)
@pytest.mark.parametrize("method", ["mean", "kalman"])
def test_in_run_noise_goes_on_where_calibration_ends(rule, method):
    """Heading of a straight run: a sum of samples, whose covariance is known exactly."""
    values = {**SHORT, "sensors.calibration": {"duration": "2 s", "method": method},
              "sensors.gyroscope.noise_density": "0.001 °/s/√Hz",
              "sensors.gyroscope.gauss_markov": {"deviation": "1 °/s", "correlation_time": "0.5 s"},
              "reconstruction.integration": rule}  # fmt: skip
    p = strapdown.problem(values)
    n, white = p.n_samples, math.radians(0.001) * math.sqrt(5.0)
    processes = processes_of(0.0, 0.0, math.radians(1.0), 0.5, STEP, 4.0)
    left = after_calibration(processes, white, 20, method)
    covariance = covariance_of(left, white, n + 1)
    # Samples 0 ... n: the forward Euler rule reads the first ones, the rectangular the last.
    weights = np.full(n + 1, STEP)
    if rule == "forward_euler":
        weights[-1] = 0.0
    elif rule == "rectangular":
        weights[0] = 0.0
    else:
        weights[[0, -1]] *= 0.5
    expected = math.sqrt(weights @ covariance @ weights)
    assert math.sqrt(p.linear.second_moment[HEADING]) == pytest.approx(expected, rel=1e-6)
    assert p.simulate(3, 0, N).errors[HEADING].std() == pytest.approx(expected, rel=CLOSE)


def test_the_start_of_the_noise_matters_there():
    """The control for one sample: without it the rules would agree."""
    deviations = []
    for rule in ("rectangular", "forward_euler"):
        p = strapdown.problem({
            **SHORT, "sensors.calibration": {"duration": "2 s", "method": "kalman"},
            "sensors.gyroscope.noise_density": "0.001 °/s/√Hz", "reconstruction.integration": rule,
            "sensors.gyroscope.gauss_markov": {"deviation": "1 °/s", "correlation_time": "0.5 s"},
        })  # fmt: skip
        deviations.append(math.sqrt(p.linear.second_moment[HEADING]))
    assert abs(deviations[0] / deviations[1] - 1.0) > 0.01


# An unknown tilt


def test_the_planar_algorithm_suffers_the_tilt_that_nobody_knows():
    values = {**SHORT, "reconstruction.algorithm": "planar", "initial.tilt_error": "0.5 °",
              "initial.roll_error": "1 °"}  # fmt: skip
    p = strapdown.problem(values)
    errors = p.simulate(3, 0, N).errors
    fall = STANDARD_GRAVITY * STEP**2 * sum(range(1, p.n_samples + 1))
    roll, pitch = math.radians(math.hypot(0.5, 1.0)), math.radians(0.5)
    expected = [fall * pitch, fall * roll, 0.0, roll, pitch]
    np.testing.assert_allclose(
        errors[[0, 1, 2, 4, 5]].std(axis=1), expected, rtol=CLOSE, atol=1e-12
    )
    linear = np.sqrt(p.linear.second_moment)[[0, 1, 2, 4, 5]]
    np.testing.assert_allclose(linear, expected, rtol=1e-9, atol=1e-12)
    # The nose down is felt backwards, the left side up to the left; both are taken for zero.
    assert np.corrcoef(errors[0], errors[5])[0, 1] > 0.999
    assert np.corrcoef(errors[1], errors[4])[0, 1] < -0.999
    # The same drive on a road that slopes that much.
    bank = strapdown.problem({**SHORT, "reconstruction.algorithm": "planar", "body.bank": "1 °"})
    across = bank.method_errors()[1]
    assert across == pytest.approx(fall * math.sin(math.radians(1.0)), rel=1e-3)
    history = p.history(3, 0, 50)
    np.testing.assert_allclose(history.errors[:, -1], errors[:, :50], atol=1e-9)
    whole = p.simulate(3, 0, 300, controls=True)
    parts = [p.simulate(3, k, 100, controls=True) for k in (0, 100, 200)]
    np.testing.assert_array_equal(whole.errors, np.concatenate([q.errors for q in parts], 1))
    np.testing.assert_array_equal(whole.controls, np.concatenate([q.controls for q in parts], 1))
