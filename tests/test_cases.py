"""What every case owes the engine, over the list of cases: none has tests of its own for it."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from jsonschema import Draft7Validator

import mcsim
from mcsim.engine import run_point
from mcsim.scenario_file.schema import scenario_schema
from mcsim.systems import SYSTEMS, problem_of
from tests import strapdown, test_velocity_sensor
from tests.conftest import ALL_ERRORS
from tests.conftest import scenario as planar

#: Every disturbance of the sensors, as far as they do not bound or digitise the output.
TERMS = {
    "sensors.accelerometer.bias_instability": "0.3 mg",
    "sensors.accelerometer.gauss_markov": {"deviation": "1 mg", "correlation_time": "2 s"},
    "sensors.accelerometer.scale_factor_error": "0.5 %",
    "sensors.gyroscope.rate_random_walk": "0.01 °/s/√s",
    "sensors.gyroscope.misalignment": "0.1 °",
}
SLOW = {"trajectory.deceleration": "1 m/s^2", "initial.heading_error": "0.2 °"}
TRAPEZOIDAL = {"reconstruction.integration": "trapezoidal"}
LEVEL = {"reconstruction.algorithm": "planar"}
#: Scenarios of each case, for all that its kernels do in different ways.
TYPICAL = {
    "planar": lambda: planar({**ALL_ERRORS, **SLOW}),
    "planar, all terms": lambda: planar({**ALL_ERRORS, **SLOW, **TERMS}),
    "planar, trapezoidal": lambda: planar({**ALL_ERRORS, **TRAPEZOIDAL}),
    "strapdown": lambda: strapdown.scenario(strapdown.EVERYTHING),
    "strapdown, levelled": lambda: strapdown.scenario(
        {**strapdown.EVERYTHING, **TERMS, "initial.levelling": {"duration": "1 s"}}
    ),
    "strapdown, taken for level": lambda: strapdown.scenario({**strapdown.EVERYTHING, **LEVEL}),
    "velocity": lambda: test_velocity_sensor.scenario(),
    "velocity, all terms": lambda: test_velocity_sensor.scenario(SMOOTH),
}  # fmt: skip
SMOOTH = {
    key: value
    for key, value in test_velocity_sensor.EVERY.items()
    if key not in ("spikes", "resolution")
}
KEY = 7


@pytest.fixture(params=TYPICAL)
def scenario(request) -> mcsim.Scenario:
    """A typical scenario of a case."""
    return TYPICAL[request.param]()


@pytest.fixture
def problem(scenario):
    """Its problem."""
    return problem_of(scenario.base, scenario.folder)


def test_every_case_is_tried():
    assert {name.partition(",")[0] for name in TYPICAL} == set(SYSTEMS)


def test_realizations_do_not_depend_on_how_they_are_simulated(problem):
    """Not on blocks, the size of the last one, or whether controls are asked for."""
    whole = problem.simulate(KEY, 0, 300, controls=True)
    pieces = [
        problem.simulate(KEY, a, b - a, controls=True) for a, b in ((0, 1), (1, 130), (130, 300))
    ]
    assert np.array_equal(whole.errors, np.concatenate([p.errors for p in pieces], 1))
    assert np.array_equal(whole.controls, np.concatenate([p.controls for p in pieces], 1))
    assert np.array_equal(whole.errors, problem.simulate(KEY, 0, 300).errors)
    assert not np.array_equal(whole.errors, problem.simulate(KEY + 1, 0, 300).errors)


def test_realization_numbers_beyond_32_bits_are_their_own(problem):
    far = 2**32
    assert not np.array_equal(
        problem.simulate(KEY, 0, 5).errors, problem.simulate(KEY, far, 5).errors
    )
    across = problem.simulate(KEY, far - 5, 10).errors[:, 5:]
    assert np.array_equal(across, problem.simulate(KEY, far, 5).errors)


def test_results_do_not_depend_on_threads(scenario, problem):
    settings = scenario.base.monte_carlo.model_copy(update={"realizations": 9001})
    one, three = (run_point(problem, settings, 5, threads).estimates for threads in (1, 3))
    for name in ("value", "low", "high"):
        np.testing.assert_array_equal(getattr(one, name), getattr(three, name))


def test_sobol_nets_are_the_same_realizations_however_they_are_drawn(problem):
    whole = problem.simulate(KEY, 0, 128, net=64).errors
    second = problem.simulate(KEY, 64, 64, net=64).errors
    assert np.array_equal(whole[:, 64:], second)
    assert not np.array_equal(whole, problem.simulate(KEY, 0, 128).errors)


def test_controls_follow_the_errors_and_have_the_moments_of_the_linear_model(problem):
    """Small disturbances; moments within five sampling errors."""
    n = 20_000
    sample = problem.simulate(11, 0, n, controls=True)
    u = sample.errors - problem.method_errors()[:, None]
    linear = problem.linear
    controlled = np.flatnonzero(linear.control_second_moment > 1e-30)
    assert len(controlled) > 0
    controls, errors = sample.controls[controlled], u[controlled]
    mean, second = linear.control_mean[controlled], linear.control_second_moment[controlled]
    spread = np.sqrt(second - mean**2)
    assert np.abs((controls.mean(axis=1) - mean) / spread).max() < 5 / np.sqrt(n)
    squares = controls**2
    deviation = squares.std(axis=1)
    assert np.abs((squares.mean(axis=1) - second) / deviation).max() < 5 / np.sqrt(n)
    correlation = [np.corrcoef(*pair)[0, 1] for pair in zip(controls, errors, strict=True)]
    assert min(correlation) > 0.9


def test_sources_are_the_whole_variance(problem):
    linear = problem.linear
    assert all(np.all(parts >= 0.0) for parts in linear.variances.values())
    total = np.sum(list(linear.variances.values()), axis=0)
    signed = [row for row in np.flatnonzero(linear.mean == 0.0) if row not in linear.quantiles]
    np.testing.assert_allclose(total[signed], linear.second_moment[signed], rtol=1e-9)
    assert np.count_nonzero([parts.max() > 0.0 for parts in linear.variances.values()]) > 3


def test_linear_answers_are_those_of_monte_carlo(problem):
    """Deviations within five sampling errors and the second order of the disturbances."""
    n = 20_000
    errors = problem.simulate(3, 0, n).errors
    mean, second = problem.linear.mean, problem.linear.second_moment
    found = np.sqrt(np.mean((errors - problem.method_errors()[:, None]) ** 2, axis=1))
    np.testing.assert_allclose(found, np.sqrt(second), rtol=5 / np.sqrt(n), atol=1e-9)
    assert np.all(second >= mean**2)


def test_control_variates_narrow_the_intervals(scenario, problem):
    width = {}
    for estimator in ("plain", "control_variate"):
        settings = scenario.base.monte_carlo.model_copy(
            update={"estimator": estimator, "realizations": 2000}
        )
        e = run_point(problem, settings, 5).estimates
        width[estimator] = (e.high - e.low)[:, 2]
    helped = problem.linear.control_second_moment > 1e-30
    assert np.all(width["plain"][helped] > 1.5 * width["control_variate"][helped])


def test_histories_end_in_the_errors(problem):
    history = problem.history(KEY, 10, 70)
    errors = problem.simulate(KEY, 10, 70).errors
    rows = len(history.errors)
    np.testing.assert_allclose(history.errors[:, -1], errors[-rows:], rtol=1e-9, atol=1e-9)
    assert history.tracks.shape[1:] == (len(history.time), 70)


def test_tables_are_tidy_and_do_not_depend_on_jobs(scenario):
    few = scenario.with_values(
        {
            "monte_carlo.realizations": 300,
            "sweep": {"monte_carlo.seed": [1, 2]},
            "outputs": {"history": True, "tracks": 2},
        }
    )
    one, two = (mcsim.run(few, jobs=jobs) for jobs in (1, 2))
    for name in ("table", "budget", "history", "tracks"):
        pd.testing.assert_frame_equal(getattr(one, name), getattr(two, name), check_exact=True)
    assert list(dict.fromkeys(one.table["error"])) == list(few.base.ERRORS)
    assert not one.table[["unit", "statistic"]].isna().any().any()


def test_scenarios_are_those_of_the_schema_and_read_back(scenario):
    schema = scenario_schema()
    Draft7Validator.check_schema(schema)
    tree = dict(scenario.document.tree)
    Draft7Validator(schema).validate(tree)
    assert not Draft7Validator(schema).is_valid(tree | {"lean": "3 °"})
    again = mcsim.run(scenario.with_values({"monte_carlo.realizations": 10})).provenance["scenario"]
    assert (
        mcsim.Scenario.from_dict(again, folder=scenario.folder).base
        == scenario.with_values({"monte_carlo.realizations": 10}).base
    )
