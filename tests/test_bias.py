"""Tracking of the slowly varying bias, and Table 5.8."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from mcsim.characterisation.autocorrelation import autocovariance
from mcsim.characterisation.bias import (
    analyse_bias,
    best_mean_length,
    correlation_model,
    kalman_rmse,
    mean_rmse,
    smooth,
    track_bias,
)
from mcsim.characterisation.process import GaussMarkov
from mcsim.cli.main import exit_code
from mcsim.errors import InputError
from mcsim.papers.bias_tracking import tracked_biases, useless_words
from mcsim.units import STANDARD_GRAVITY
from tests.reference.noise import gauss_markov

RATE = 20.0
HOURS_14 = round(14 * 3600 * RATE)
#: Tables 5.7 (Tc in s, σ in m/s²), 5.2 (ND in µg/√Hz) and 5.8 (RMSE, 1e-4 m/s²), x axis;
#: then what this filter leaves of a simulated bias, and its distance from a 30 s average.
TABLE_5_8 = {
    "MTI-300": (69.0, 0.0015, 60.9716, 7.1, 3.8, 4.3),
    "MPU-9250": (88.0, 0.0027, 89.8376, 11.0, 5.9, 6.7),
    "LSM9DS1": (69.0, 0.0015, 210.0844, 5.7, 6.8, 5.1),
    "BNO055": (71.0, 0.0013, 125.2382, 20.0, 5.0, 3.9),
    "LSM303DLHC": (58.0, 0.0104, 841.20, 28.0, 38.0, 31.0),
}


def rms(values):
    return math.sqrt(np.mean(np.square(values)))


def biased_log(model, white, rng, n=HOURS_14):
    bias = gauss_markov(model.correlation_time, model.deviation, RATE, n, rng)
    return bias, bias + white * math.sqrt(RATE) * rng.standard_normal(n)


def centres(smoothed):
    at = np.arange(len(smoothed.values)) * smoothed.interval + smoothed.length / 2.0
    return np.round(at * RATE).astype(int) - 1


@pytest.mark.parametrize("sensor", TABLE_5_8)
def test_table_5_8(sensor):
    """The measurement noise is ND √Fs, as the thesis has it: ND stands where N belongs."""
    time, deviation, density, printed, ours, from_average = TABLE_5_8[sensor]
    model, white = GaussMarkov(time, deviation), density * 1e-6 * STANDARD_GRAVITY
    bias, log = biased_log(model, white, np.random.default_rng(1))
    estimate = track_bias(log, RATE, model, white * math.sqrt(RATE))
    error = rms(estimate - bias)
    # 14 h hold hundreds of correlation times: RMSE known to some per cent.
    assert error == pytest.approx(kalman_rmse(model, white * math.sqrt(RATE), RATE), rel=0.06)
    assert error * 1e4 == pytest.approx(ours, rel=0.06)
    average = smooth(log, RATE, 30.0)
    distance = rms(estimate[centres(average)] - average.values)
    assert distance * 1e4 == pytest.approx(from_average, rel=0.1)
    # The printed values are neither; LSM9DS1 and LSM303DLHC lie within 15 % of the distance.
    close = abs(printed / (distance * 1e4) - 1.0) < 0.15
    assert close == (sensor in ("LSM9DS1", "LSM303DLHC"))


def test_steady_state_is_the_riccati_equations():
    model, noise = GaussMarkov(69.0, 0.0015), 0.012
    a = math.exp(-1.0 / (RATE * 69.0))
    q = 0.0015**2 * (1.0 - a * a)
    before = solve_discrete_are(np.array([[a]]), np.eye(1), np.array([[q]]), np.array([[noise**2]]))
    after = before[0, 0] * noise**2 / (before[0, 0] + noise**2)
    assert kalman_rmse(model, noise, RATE) == pytest.approx(math.sqrt(after), rel=1e-9)
    assert kalman_rmse(model, 0.0, RATE) == 0.0


def test_a_wrong_model_tracks_worse():
    model, white = GaussMarkov(69.0, 0.0015), 6e-4
    bias, log = biased_log(model, white, np.random.default_rng(2))
    best = rms(track_bias(log, RATE, model, white * math.sqrt(RATE)) - bias)
    for wrong in (GaussMarkov(5.0, 0.0015), GaussMarkov(69.0, 0.0150), GaussMarkov(900.0, 0.0015)):
        assert rms(track_bias(log, RATE, wrong, white * math.sqrt(RATE)) - bias) > 1.03 * best


def test_errors_of_means_are_what_simulation_gives():
    model, white = GaussMarkov(69.0, 0.0015), 6e-4
    bias, log = biased_log(model, white, np.random.default_rng(3))
    total = np.concatenate([[0.0], np.cumsum(log)])
    for length in (2.0, 20.0, 200.0):
        n = round(length * RATE)
        means = (total[n:] - total[:-n]) / n
        expected = mean_rmse(model, white, length)
        assert rms(means - bias[n - 1 :]) == pytest.approx(expected, rel=0.06)
    best = best_mean_length(model, white, 1000.0)
    assert mean_rmse(model, white, best) < mean_rmse(model, white, 1.3 * best)
    assert mean_rmse(model, white, best) < mean_rmse(model, white, best / 1.3)
    # No mean is as good as the filter.
    assert mean_rmse(model, white, best) > kalman_rmse(model, white * math.sqrt(RATE), RATE)


def test_autocorrelation_is_numpys():
    values = np.random.default_rng(4).standard_normal(300)
    centred = values - values.mean()
    expected = np.correlate(centred, centred, "full")[299:] / 300
    np.testing.assert_allclose(autocovariance(values), expected, atol=1e-12)


@pytest.mark.parametrize("sensor", ["MTI-300", "LSM9DS1"])
def test_parameters_come_back_from_the_autocorrelation(sensor):
    """Estimates from 14 h, 730 correlation times: Tc to about 10 %, σ to 4 %."""
    time, deviation, density = TABLE_5_8[sensor][:3]
    white = density * 1e-6 * STANDARD_GRAVITY
    _, log = biased_log(GaussMarkov(time, deviation), white, np.random.default_rng(5))
    found = correlation_model(smooth(log, RATE), white)
    assert found.correlation_time == pytest.approx(time, rel=0.25)
    assert found.deviation == pytest.approx(deviation, rel=0.1)
    if sensor == "LSM9DS1":
        # Control: white noise that is not taken off stands on top of the bias.
        assert correlation_model(smooth(log, RATE)).deviation > 1.05 * found.deviation


def test_analysis_reports_both_estimates():
    model, white = GaussMarkov(69.0, 0.0015), 6e-4
    _, log = biased_log(model, white, np.random.default_rng(6))
    found = analyse_bias(log + 9.81, RATE, white)
    expected = kalman_rmse(model, white * math.sqrt(RATE), RATE)
    assert found.kalman_expected == pytest.approx(expected, rel=0.1)
    assert found.kalman_expected < found.mean_expected
    assert found.kalman_measured < found.mean_measured


def test_logs_without_a_bias_are_refused():
    rng = np.random.default_rng(7)
    with pytest.raises(InputError, match="20 averages"):
        correlation_model(smooth(rng.standard_normal(1000), RATE))
    with pytest.raises(InputError, match="no bias"):
        correlation_model(smooth(rng.standard_normal(100_000), RATE), 10.0)


def test_the_table_of_tracked_biases_has_the_sources_numbers():
    """Parameters come from the catalogue; the simulated error agrees with the closed form."""
    entries = {entry.sensor: entry for entry in tracked_biases(seed=3)}
    assert set(entries) == set(TABLE_5_8)
    for sensor, (time, deviation, density, printed, _, _) in TABLE_5_8.items():
        entry = entries[sensor]
        assert (entry.model.correlation_time, entry.model.deviation) == (time, deviation)
        assert entry.density == pytest.approx(density * 1e-6 * STANDARD_GRAVITY)
        assert entry.printed == pytest.approx(printed * 1e-4)
        assert entry.simulated == pytest.approx(entry.exact, rel=0.06)


def test_the_tables_words_follow_from_its_numbers(monkeypatch, capsys):
    """The rate is told; whose printed value an estimate of zero beats depends on the values."""
    entries = list(tracked_biases(seed=3))
    assert [e.own_rate for e in entries] == [399.8, 740.0, 1012.0, 171.0, 1260.0]
    for entry in entries:
        white = entry.density * math.sqrt(entry.own_rate)
        assert entry.exact_own == pytest.approx(kalman_rmse(entry.model, white, entry.own_rate))
    assert useless_words(entries).startswith(
        "Printed values above the deviation of the bias itself: BNO055;"
    )
    better = [replace(e, printed=0.5 * e.model.deviation) for e in entries]
    assert useless_words(better).startswith("No printed value exceeds")
    worse = [replace(e, printed=2.0 * e.model.deviation) for e in entries]
    assert "MTI-300, MPU-9250" in useless_words(worse)
    monkeypatch.setattr("mcsim.papers.bias_tracking.tracked_biases", lambda *_: entries)
    assert exit_code(["table", "bias-tracking"]) == 0
    out = capsys.readouterr().out
    assert "exact (20 Hz)" in out
    assert "logs at 20 Hz" in out
    change = max(abs(e.exact_own / e.exact - 1.0) for e in entries)
    assert f"changes by up to {change:.1%}" in out
