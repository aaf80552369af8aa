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
from tests.conftest import ALL_ERRORS, BASE_YAML, problem
from tests.reference.random_numpy import constants, white_noise
from tests.strapdown import EVERYTHING, RULES
from tests.strapdown import problem as spatial_problem

EXAMPLE = Path(__file__).parent.parent / "docs" / "examples" / "midpoint.py"
MIDPOINT = {"reconstruction.integration": "midpoint"}
INITIAL = {"initial.heading_error": "0.2 °", "initial.course_error": "0.3 °"}
#: A state's weights of this size beside the largest are rounding of the differences.
CLOSE = 1e-7


@pytest.fixture(scope="module", autouse=True)
def _midpoint():
    run_own(EXAMPLE)


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
