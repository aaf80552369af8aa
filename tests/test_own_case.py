"""A case from outside: what the package gives it without being asked."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import mcsim
from mcsim.cli.main import exit_code
from mcsim.cli.own import run_own
from mcsim.scenario.error_quantities import ERROR_QUANTITIES
from mcsim.scenario_file.schema import scenario_schema
from mcsim.systems import SYSTEMS, problem_of
from tests.reference.random_numpy import constants, white_noise

EXAMPLES = Path(__file__).parent.parent / "docs" / "examples"
EXAMPLE, SCENARIO = EXAMPLES / "rail.py", EXAMPLES / "rail.yaml"


@pytest.fixture
def rail():
    """The case of the example, for one test."""
    run_own(EXAMPLE)
    yield mcsim.Scenario.from_yaml(SCENARIO)
    _forget()


def _forget():
    SYSTEMS.remove("rail")
    ERROR_QUANTITIES.remove("speed")


def twin(p, key, count):
    """Plain numpy with the same random numbers: along, across, speed, heading at the end."""
    z = constants(key, np.arange(count))
    d = p.deviations(p.measurement, disturbed=True)
    noise = white_noise(key, np.arange(count), p.n_samples)
    measured = p.signals[1:, :3, None] + (d[:3, None] * z[:3])[None]
    measured = measured + p.sensor_errors.white[None, :, None] * noise
    along, across, speed, psi = p.truth[:, 0, None] + d[3:7, None] * z[3:7]
    for forward, _, turn in measured:
        speed, psi = speed + p.interval * forward, psi + turn
        along = along + p.interval * speed * np.cos(psi)
        across = across + p.interval * speed * np.sin(psi)
    return np.array([along, across, speed, psi]) - p.truth[:, -1, None]


@pytest.mark.slow
def test_realizations_equal_a_plain_twin_and_follow_the_linear_model(rail):
    p = problem_of(rail.points[0].model, rail.folder)
    sample = p.simulate(5, 0, 2000, controls=True)
    expected = twin(p, 5, 2000)
    scale = expected.std(axis=1, keepdims=True)
    assert np.abs((sample.errors[:4] - expected) / scale).max() < 2e-6  # normals are float32
    np.testing.assert_allclose(sample.errors[4], np.hypot(*sample.errors[:2]), rtol=1e-12)
    shifted = sample.errors - p.method_errors()[:, None]
    assert np.all((shifted - sample.controls).std(axis=1) < 0.01 * shifted.std(axis=1))
    predicted = np.sqrt(p.linear.second_moment)
    np.testing.assert_allclose(shifted.std(axis=1)[:4], predicted[:4], rtol=4 / np.sqrt(4000))
    history = p.history(5, 0, 50)
    np.testing.assert_allclose(history.errors[:, -1], sample.errors[:, :50], atol=1e-9)
    # The channel that the algorithm does not read disturbs nothing.
    assert np.all(p.weights.samples[:, :, 1] == 0.0)


@pytest.mark.slow
def test_it_runs_from_a_scenario_to_table_and_picture(tmp_path, request):
    request.addfinalizer(_forget)
    command = ["run", str(SCENARIO), "--with", str(EXAMPLE), "--output", str(tmp_path), "--quiet"]
    assert exit_code(command) == 0
    table = pd.read_csv(tmp_path / "rail" / "table.csv")
    assert set(table["error"]) == {"along", "across", "speed", "heading", "position"}
    assert len(table.query("statistic == 'rms'")) == 5 * 12
    budget = pd.read_csv(tmp_path / "rail" / "budget.csv")
    assert "initial speed error" in set(budget["source"])
    assert (tmp_path / "rail" / "figure.png").stat().st_size > 10_000


def test_schema_sweeps_and_messages_know_it(rail):
    assert "rail" in scenario_schema()["properties"]["case"]["enum"]
    swept = rail.with_values({"sweep.speed_error": ["0 m/s", "1 m/s"]})
    assert swept.n_points == 24
    with pytest.raises(mcsim.InputError, match=r"the case rail has no error `height`"):
        rail.with_values({"figure": {"panels": [{"errors": "height"}]}})
    with pytest.raises(mcsim.InputError, match=r"speed_erorr.*did you mean"):
        rail.with_values({"speed_erorr": "1 m/s"})


def test_what_is_no_part_is_refused(rail):
    del rail
    with pytest.raises(mcsim.InputError, match=r"mcsim\.add takes a Case"):
        mcsim.add("rail")
    with pytest.raises(mcsim.InputError, match="there is a case of that name already"):
        mcsim.add(SYSTEMS["rail"])
    nameless = mcsim.Case("ski", type("Model", (), {"ERRORS": ("glide",)}), None, None)
    with pytest.raises(mcsim.InputError, match="nobody knows its error glide"):
        mcsim.add(nameless)
    assert "ski" not in SYSTEMS
