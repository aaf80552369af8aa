"""Events that a run may not see: spikes, wraps, extremes; intervals allow for them or say so."""

import numpy as np
import pytest
from scipy import stats

from mcsim.engine import run_point
from mcsim.sensor_terms.channel import ACCELEROMETER
from tests.conftest import ALL_ERRORS, problem, scenario

#: One realization in 20 has a spike.
SPIKES = {"sensors.accelerometer.spikes": {"rate": "0.01 Hz", "amplitude": "100 m/s^2"}}
RARE = {"sensors.accelerometer.spikes": {"rate": "1e-4 Hz", "amplitude": "100 m/s^2"}}
TRIALS = 200


def settings(**values):
    values = {"estimator": "plain", **values}
    return scenario({f"monte_carlo.{k}": v for k, v in values.items()}).base.monte_carlo


def shares(p, truth, mc, rows=slice(None), margin=1e-9):
    """How often intervals of mean, std and RMS hold the truth."""
    hits = 0.0
    for key in range(TRIALS):
        e = run_point(p, mc, 1000 + key).estimates
        low, high, slack = (x[rows, :3] for x in (e.low, e.high, margin * np.abs(e.value)))
        hits = hits + ((low - slack <= truth) & (truth <= high + slack))
    return hits / TRIALS


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["plain", "control_variate"])
def test_intervals_hold_where_spikes_are_rare(estimator):
    """500 realizations have 25 spikes or so, of unequal weight; binomial bound at 1e-4."""
    p = problem(SPIKES)
    mc = settings(realizations=500, confidence="95 %", estimator=estimator)
    known = settings(realizations=1_000_000, estimator=estimator)
    found = shares(p, run_point(p, known, 1, 2).estimates.value[:, :3], mc)
    assert np.all(found >= stats.binom.ppf(1e-4, TRIALS, 0.94) / TRIALS), found


@pytest.mark.slow
def test_control_must_fail_without_knowledge_of_spikes(monkeypatch):
    """The bootstrap alone knows only the spikes that it has seen."""
    p = problem(SPIKES)
    truth = run_point(p, settings(realizations=1_000_000), 1, 2).estimates.value[:, :3]
    monkeypatch.setattr("mcsim.estimation.rare_events", lambda _: None)
    monkeypatch.setattr("mcsim.statistics.moments.FEW_DEGREES", 0.0)
    found = shares(p, truth, settings(realizations=100, confidence="95 %"))
    assert found[:2, 1:].max() < 0.87


def test_an_interval_holds_spikes_that_were_not_seen():
    p = problem(RARE)
    result = run_point(p, settings(realizations=1000), 2)
    e = result.estimates
    known = np.sqrt(p.linear.second_moment + p.method_errors() ** 2)
    assert e.value[0, 2] < 0.5 * known[0] < e.high[0, 2]
    assert "spikes make 97%" in result.notes["along"]
    assert "heading" not in result.notes


@pytest.mark.slow
def test_a_wanted_precision_waits_for_spikes():
    """One spike in 200 realizations: 1000 would do for the noise alone, not for the spikes."""
    p = problem({"sensors.accelerometer.spikes": {"rate": "0.001 Hz", "amplitude": "100 m/s^2"}})
    mc = settings(realizations=None, precision="20 %", confidence="95 %", max_realizations=200_000)
    result = run_point(p, mc, 2)
    assert result.realizations > 20_000
    known = np.sqrt(p.linear.second_moment)
    assert abs(result.estimates.value[1, 2] / known[1] - 1.0) < 0.2
    calm = problem({"sensors.accelerometer.spikes": {"rate": "0.001 Hz", "amplitude": "0 m/s^2"}})
    assert run_point(calm, mc, 2).realizations == 1000


def test_spikes_of_equal_weight_are_counted_as_what_they_are():
    """On a straight road the speed, and so the course, takes all spikes alike."""
    p = problem(SPIKES)
    weights = np.ones((1, p.n_samples + 1, 3))
    channels = sum(element == ACCELEROMETER for element in p.sensor_errors.elements)
    expected = (p.n_samples + 1) * channels * 1e-4
    assert p.measurement.spike_events(weights)[0] == pytest.approx(expected, rel=1e-4)
    # Unequal weights: fewer.
    weights[0, ::2] = 0.0
    assert p.measurement.spike_events(weights)[0] == pytest.approx(0.5 * expected, rel=0.01)


@pytest.mark.slow
def test_angles_that_may_wrap_take_no_control():
    """One realization in 2000 wraps: the linear model knows nothing of it."""
    p = problem({"initial.direction_error": "52 °"})
    truth = run_point(p, settings(realizations=1_000_000), 1, 2).estimates.value[3:4, :3]
    mc = settings(realizations=1000, confidence="95 %", estimator="control_variate")
    found = shares(p, truth, mc, slice(3, 4))
    assert np.all(found >= stats.binom.ppf(1e-4, TRIALS, 0.94) / TRIALS), found


@pytest.mark.slow
@pytest.mark.parametrize("overrides", [ALL_ERRORS, {"sensors.gyroscope.miscalibration": "3 °/s"}])
def test_intervals_of_controlled_estimates_hold(overrides):
    """95 % of 500 realizations, against a million controlled ones; binomial bound at 1e-4."""
    p = problem(overrides)
    known = settings(realizations=1_000_000, estimator="control_variate")
    truth = run_point(p, known, 1, 2).estimates.value[:, :3]
    mc = settings(realizations=500, confidence="95 %", estimator="control_variate")
    found = shares(p, truth, mc)
    assert np.all(found >= stats.binom.ppf(1e-4, TRIALS, 0.93) / TRIALS), found


def test_percentiles_that_few_realizations_do_not_bound_are_said():
    """0.95^n is below the tail of 3 sigma, 0.00135, from 129 realizations on."""
    for count, said in ((128, True), (129, False)):
        notes = run_point(problem(), settings(realizations=count), 2).notes
        assert ("do not bound p95" in notes.get("along", "")) == said


def test_the_linear_answer_is_checked_in_every_statistic():
    """Wide angles: the mean of the course is far from the linear model's, its RMS is not."""
    overrides = {"initial.direction_error": "30 °", "sensors.gyroscope.miscalibration": "10 °/s"}
    notes = run_point(problem(overrides), settings(estimator="linear"), 2).notes
    assert "RMS: mean" in notes["along"]
    assert run_point(problem(ALL_ERRORS), settings(estimator="linear"), 2).notes == {}


def test_progress_of_a_precision_counts_each_realization_once():
    told = []
    mc = settings(realizations=None, precision="2 %")
    result = run_point(problem(), mc, 5, 1, told.append)
    assert result.realizations > 1000
    assert sum(told) == result.realizations
