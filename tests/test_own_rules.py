"""Rules of a user's own, and the linear model that follows from any system's steps."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import mcsim
from mcsim.cli.main import exit_code
from mcsim.cli.own import run_own
from mcsim.sensors.measurement import Measurement
from mcsim.simulation.running import adjoint_weights
from tests.conftest import ALL_ERRORS, BASE_YAML, NO_NOISE, problem
from tests.reference.random_numpy import constants, white_noise
from tests.reference.strapdown_scipy import TIME_CONSTANT, end_errors
from tests.strapdown import EVERYTHING, RULES
from tests.strapdown import problem as spatial_problem

EXAMPLES = Path(__file__).parent.parent / "docs" / "examples"
EXAMPLE, FILTER = EXAMPLES / "midpoint.py", EXAMPLES / "levelling_filter.py"
FILTERED = {"reconstruction.integration": "levelling_filter"}
STRAIGHT = {"trajectory": {"shape": "straight", "length": "1200 m", "speed": "20 m/s"}}
MIDPOINT = {"reconstruction.integration": "midpoint"}
INITIAL = {"initial.heading_error": "0.2 °", "initial.course_error": "0.3 °"}
#: A state's weights of this size beside the largest are rounding of the differences.
CLOSE = 1e-7


@pytest.fixture(scope="module", autouse=True)
def _rules():
    run_own(EXAMPLE)
    run_own(FILTER)


def midpoint(p, key, count):
    """Plain numpy, exact functions, the same random numbers: along, across, heading, course."""
    truth, t = p.truth, p.interval
    z = constants(key, np.arange(count))
    d = p.deviations(p.measurement, disturbed=True)
    noise = np.concatenate([z[None, 8:11], white_noise(key, np.arange(count), p.n_samples)])
    measured = p.signals[:, :3, None] + (d[:3, None] * z[:3])[None]
    measured = measured + p.sensor_errors.white[None, :, None] * noise
    psi = truth.heading[0] + d[4] * z[4] + d[5] * z[5]
    chi = truth.course[0] + d[4] * z[4] + d[6] * z[6]
    v = (truth.speed[0] + d[3] * z[3]) * np.exp(1j * chi)
    place = np.full(count, truth.along[0] + 1j * truth.across[0])
    for forward, left, turn in measured[1:]:
        new = v + t * (forward + 1j * left) * np.exp(1j * (psi + 0.5 * turn))
        place, v, psi = place + 0.5 * t * (v + new), new, psi + turn
    error = place - (truth.along[-1] + 1j * truth.across[-1])
    return np.array(
        [error.real, error.imag, psi - truth.heading[-1], np.angle(v) - truth.course[-1]]
    )


@pytest.mark.slow
def test_an_own_rule_equals_its_plain_twin():
    p = problem({**ALL_ERRORS, **INITIAL, **MIDPOINT})
    ours = p.simulate(7, 0, 300).errors[[0, 1, 3, 4]]
    twin = midpoint(p, 7, 300)
    scale = twin.std(axis=1, keepdims=True)
    assert np.abs((ours - twin) / scale).max() < 2e-6  # normals are float32
    other = problem({**ALL_ERRORS, **INITIAL}).simulate(7, 0, 300).errors[[0, 1, 3, 4]]
    assert np.abs((other - twin) / scale).max() > 1e-3  # the shipped rule is another one


@pytest.mark.slow
def test_an_own_rule_has_a_linear_model():
    """Controls follow the errors, and their covariance is what 4000 realizations scatter by."""
    p = problem({**ALL_ERRORS, **INITIAL, **MIDPOINT})
    sample = p.simulate(3, 0, 4000, controls=True)
    errors = sample.errors - p.method_errors()[:, None]
    rows = [0, 1, 3, 4]
    assert np.all(np.std((errors - sample.controls)[rows], axis=1) < 0.05 * errors[rows].std(1))
    predicted = np.sqrt(p.linear.second_moment[rows])
    np.testing.assert_allclose(errors[rows].std(axis=1), predicted, rtol=4.0 / np.sqrt(2 * 4000))


@pytest.mark.slow
def test_an_own_rule_is_named_in_a_scenario_and_drawn(tmp_path):
    scenario = tmp_path / "own.yaml"
    scenario.write_text(BASE_YAML + "reconstruction: {integration: midpoint}\n", encoding="utf-8")
    out = tmp_path / "out"
    command = ["run", str(scenario), "--with", str(EXAMPLE), "--output", str(out), "--quiet"]
    assert exit_code(command) == 0
    assert (out / "own" / "figure.png").stat().st_size > 10_000
    rms = pd.read_csv(out / "own" / "table.csv").query("statistic == 'rms' and error == 'along'")
    assert (rms["value"] > 0.0).all()


@pytest.mark.slow
def test_a_filter_in_space_equals_its_plain_twin():
    """Scipy's rotations, one realization at a time, with the same random numbers."""
    p = spatial_problem({**EVERYTHING, **FILTERED})
    ours = p.simulate(7, 0, 40).errors
    twin = end_errors(p, 7, range(40), "levelling_filter")
    scale = twin.std(axis=1, keepdims=True)
    assert np.abs((ours - twin) / scale).max() < 2e-6  # normals are float32
    other = end_errors(p, 7, range(40), "rectangular")
    assert np.abs((ours - other) / scale).max(axis=1).min() > 0.01


@pytest.mark.slow
def test_a_filter_in_space_has_a_linear_model():
    """Controls follow the errors, and their covariance is what 4000 realizations scatter by."""
    p = spatial_problem({**EVERYTHING, **FILTERED})
    sample = p.simulate(3, 0, 4000, controls=True)
    errors = sample.errors - p.method_errors()[:, None]
    rows = [0, 1, 2, 4, 5, 6, 7]
    assert np.all(np.std((errors - sample.controls)[rows], axis=1) < 0.05 * errors[rows].std(1))
    predicted = np.sqrt(p.linear.second_moment[rows])
    scattered = np.sqrt(np.mean(errors[rows] ** 2, axis=1))
    np.testing.assert_allclose(scattered, predicted, rtol=4.0 / np.sqrt(2 * 4000))
    # Forces pull the attitude: other than with shipped rules they act on roll and pitch.
    assert np.all(np.abs(p.weights.samples[[4, 5]][:, 5:, [0, 1]]).max(axis=(1, 2)) > 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("axis", [0, 1])
def test_a_filter_settles_where_offset_and_pull_are_even(axis):
    """A rate b tilts by asin(b tau), whatever it tilts without the filter; see the docstring."""
    rates = ["0 °/s"] * 3
    rates[axis] = "0.1 °/s"
    p = spatial_problem(
        {**STRAIGHT, **FILTERED, **NO_NOISE, "sensors.gyroscope.miscalibration": rates}
    )
    z = constants(5, np.arange(200), 17)[1 + axis]
    rate = np.deg2rad(0.1) * z
    found = p.simulate(5, 0, 200).errors[4 + axis]
    expected = np.arcsin(rate * TIME_CONSTANT)
    left = np.exp(-60.0 / TIME_CONSTANT)  # of the way from no tilt
    assert np.abs(found - expected).max() < 1.1 * left * np.abs(expected).max()


@pytest.mark.slow
def test_a_filter_takes_lateral_acceleration_for_a_tilt():
    """At the lane change's end: the direction of the force, through the filter's first order."""
    p = spatial_problem({**NO_NOISE, **FILTERED})
    force = p.signals[1:, [0, 1, 3]]
    times = p.interval * np.arange(p.n_samples)[::-1]
    direction = force[:, 1] / np.linalg.norm(force, axis=1)
    pulled = np.sum(direction * np.exp(-times / TIME_CONSTANT)) * p.interval / TIME_CONSTANT
    roll = p.method_errors()[4]
    assert np.rad2deg(roll) == pytest.approx(-0.83, abs=0.01)
    assert roll == pytest.approx(pulled, rel=0.02)


@pytest.mark.slow
def test_a_filter_runs_from_a_scenario_to_table_and_picture(tmp_path):
    """It bounds the tilt of a long drive; both numbers of the docstring."""
    scenario = FILTER.with_suffix(".yaml")
    out = ["--output", str(tmp_path), "--quiet"]
    assert exit_code(["run", str(scenario), "--with", str(FILTER), *out]) == 0
    assert (tmp_path / FILTER.stem / "figure.png").stat().st_size > 10_000
    table = pd.read_csv(tmp_path / FILTER.stem / "table.csv")
    last = table.query("`trajectory.length [m]` == 1200 and statistic == 'rms'")
    rms = last.set_index(["reconstruction.integration", "error"])["value"]
    assert rms["levelling_filter", "roll"] == pytest.approx(0.504, rel=0.01)
    assert rms["rectangular", "roll"] == pytest.approx(6.04, rel=0.01)
    assert rms["levelling_filter", "along"] < 0.25 * rms["rectangular", "along"]


def test_unknown_rules_and_bad_files_are_refused(tmp_path, capsys):
    scenario = tmp_path / "s.yaml"
    scenario.write_text(BASE_YAML + "reconstruction: {integration: midpiont}\n", encoding="utf-8")
    bad = tmp_path / "bad.py"
    bad.write_text("import mcsim\n\nmcsim.nothing\n", encoding="utf-8")
    assert exit_code(["validate", str(scenario)]) == 2
    assert '"midpiont" is not one of rectangular, trapezoidal' in capsys.readouterr().err
    assert exit_code(["run", str(scenario), "--with", str(bad)]) == 2
    assert f"{bad}:3: AttributeError" in capsys.readouterr().err
    with pytest.raises(mcsim.InputError, match="has a rule of that name already"):
        mcsim.add_rule("planar", "rectangular", state=tuple, start=abs, step=abs, end=abs)


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["rectangular", "trapezoidal"])
@pytest.mark.parametrize("sampling", ["fir", "average"])
def test_closed_planar_weights_equal_those_of_the_steps(rule, sampling):
    p = problem(
        {
            **ALL_ERRORS,
            **INITIAL,
            "trajectory.deceleration": "1 m/s^2",
            "reconstruction.integration": rule,
            "sensors.sampling": sampling,
        }
    )
    samples, drawn = adjoint_weights(_system(p), p.signals)
    assert _far(samples, p.weights.samples) < CLOSE
    assert np.all(p.initial_deviations[3:7] > 0.0)
    assert _far(drawn[:, 3:7], p.weights.constants[:, 3:7]) < CLOSE


@pytest.mark.slow
@pytest.mark.parametrize("rule", RULES)
def test_closed_spatial_weights_equal_those_of_the_steps(rule):
    p = spatial_problem({**EVERYTHING, "reconstruction.integration": rule})
    samples, drawn = adjoint_weights(_system(p), p.rows)
    assert _far(samples, p.weights.samples) < CLOSE
    assert (
        _far(drawn[:, [3, 4, 5, 6, 15, 16]], p.weights.constants[:, [3, 4, 5, 6, 15, 16]]) < CLOSE
    )


def _system(p):
    return p.system(Measurement.none(p.sensor_errors), disturbed=False)


def _far(found, expected):
    """Largest difference beside the largest weight, of the worst error."""
    rows = range(len(expected))
    return max(np.abs(found[e] - expected[e]).max() / np.abs(expected[e]).max() for e in rows)
