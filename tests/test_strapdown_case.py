"""The strapdown case from a scenario to its tables: messages, threads, order, what it answers."""

import json
import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import mcsim
from mcsim import InputError, Scenario
from mcsim.cli.main import exit_code
from mcsim.papers.gravity_leakage import NOTE_GRAVITY, RATE, gravity_leakage, verdict
from mcsim.papers.shipped import shipped_scenarios
from mcsim.systems.strapdown.scenario import StrapdownScenario
from tests.conftest import ALL_ERRORS
from tests.strapdown import LEANING, problem, scenario

YAML = """\
case: strapdown
trajectory: {shape: half_cosine, length: 50 m, width: 5 m, speed: 20 m/s}
body:
  bank: 2 °
  roll: {gradient: 0.3 °/(m/s²), natural_frequency: 1.5 Hz, damping: 30 %}
sensors:
  rate: 100 Hz
  accelerometer: {model: LSM330DL, miscalibration: 0.01 m/s²}
  gyroscope: LSM330DL
reconstruction: {integration: two_sample}
initial: {tilt_error: 0.1 °, levelling: {duration: 10 s}}
monte_carlo: {realizations: 200, seed: 1}
sweep:
  body.roll.gradient: [0 °/(m/s²), 3 °/g]
  initial.tilt_error: [0.1 °, 1 °]
"""


@pytest.mark.parametrize(
    ("old", "new", "place", "message"),
    [
        ("bank: 2 °", "bank: 60 °", ":4: body.bank", "at most 45.8366 °"),
        ("bank: 2 °", "incline: 2 °", ":4: body.incline", 'unknown key "incline"'),
        ("0.3 °/(m/s²)", "0.3 °", ":5: body.roll.gradient", "angle gradient is needed here"),
        ("0.3 °/(m/s²)", "0.3", ":5: body.roll.gradient", "has no unit"),
        ("1.5 Hz", "0.01 Hz", ":5: body.roll", "0 Hz (at once) or at least 0.05 Hz"),
        ("30 %", "0.3", ":5: body.roll.damping", "has no unit"),
        ("30 %", "0 %", ":5: body.roll.damping", "at least 5 %"),
        ("two_sample", "runge_kutta", ":10: reconstruction.integration", "is not one of"),
        (
            "integration: two_sample",
            "algorithm: planar, integration: two_sample",
            ":10: reconstruction",
            "the planar algorithm has no integration `two_sample`",
        ),
        ("duration: 10 s", "duration: 0 s", ":11: initial.levelling.duration", "greater than"),
    ],
)
def test_bad_input_gets_one_clear_message(old, new, place, message):
    with pytest.raises(InputError) as refused:
        Scenario.from_yaml(YAML.replace(old, new))
    assert str(refused.value).count("\n") == 0
    assert place in str(refused.value)
    assert message in str(refused.value)


@pytest.mark.parametrize(
    ("text", "degrees"),
    [
        ("0.3 °/(m/s²)", 0.3),
        ("0.3 deg/(m/s^2)", 0.3),
        ("2.941995 °/g", 0.3),
        ("2.941995 deg/g", 0.3),
        ("5.235987756 mrad/(m/s²)", 0.3),
    ],
)
def test_roll_gradients_are_read_as_sheets_write_them(text, degrees):
    gradient = scenario({"body.roll.gradient": text}).base.body.roll.gradient
    assert math.degrees(gradient) == pytest.approx(degrees, rel=1e-9)


def test_a_recorded_attitude_excludes_a_leaning_body():
    overrides = {
        "trajectory": {
            "shape": "recorded",
            "file": "drive.csv",
            "columns": {"x": "x in m", "y": "y in m", "roll": "r in °", "pitch": "p in °"},
        },
        **LEANING,
    }
    with pytest.raises(InputError, match="the record has roll and pitch columns"):
        scenario(overrides)
    del overrides["trajectory"]["columns"]["pitch"]
    with pytest.raises(InputError, match="roll and pitch go together; `pitch` is missing"):
        scenario(overrides)


def test_points_that_cannot_lean_are_refused_before_anything_runs():
    s = scenario(
        {
            "body.roll.gradient": "0.3 °/(m/s²)",
            "sweep": {"body.roll.natural_frequency": ["1 Hz", "0 Hz"]},
        }
    )
    with pytest.raises(InputError, match=r"would jump with it.*natural_frequency = 0 Hz"):
        mcsim.run(s)


def test_an_added_point_changes_no_other_row():
    s = Scenario.from_yaml(YAML)
    more = s.with_values({"sweep.initial.tilt_error": ["0.1 °", "0.5 °", "1 °"]})
    few, many = mcsim.run(s).table, mcsim.run(more).table
    kept = many[many["initial.tilt_error [°]"] != 0.5].reset_index(drop=True)
    pd.testing.assert_frame_equal(few, kept, check_exact=True)


@pytest.mark.parametrize("algorithm", ["strapdown", "planar"])
def test_standing_vehicle_has_no_course_and_says_why(algorithm):
    p = problem(
        {
            "trajectory.speed": "10 m/s",
            "trajectory.deceleration": "2 m/s^2",
            "reconstruction.algorithm": algorithm,
        }
    )
    errors = p.simulate(1, 0, 50).errors
    assert np.isnan(errors[7]).all()
    assert np.isfinite(errors[:7]).all()
    assert "comes to rest" in p.missing["course"]
    assert np.isnan(p.history(1, 0, 5).errors[7, -1]).all()


# ---- what it answers -------------------------------------------------------------------


def rms(overrides) -> dict[str, float]:
    table = mcsim.run(scenario({**ALL_ERRORS, **overrides})).table
    rows = table[table["statistic"] == "rms"]
    return dict(zip(rows["error"], rows["value"], strict=True))


def test_three_dimensions_cost_little_while_the_drive_is_short():
    """Known attitude, all errors, 2.5 s: less than twice the planar case; over 10 s, 4 times."""
    for length, low, high in (("50 m", 1.2, 2.0), ("200 m", 4.0, 8.0)):
        both = [
            rms({"trajectory.length": length, "reconstruction.algorithm": a})["along"]
            for a in ("planar", "strapdown")
        ]
        assert low < both[1] / both[0] < high


def test_tilt_dominates_everything_from_a_fraction_of_a_degree_on():
    s = scenario({**ALL_ERRORS, "initial.tilt_error": "1 °"})
    budget = mcsim.run(s).budget
    across = budget[budget["error"] == "across"].set_index("source")
    assert across.loc["initial tilt error", "share"] > 0.95
    # The closed form g eps t^2 / 2, t from the first sample on.
    time = problem().n_samples * 0.01
    expected = 9.80665 * math.radians(1.0) * time**2 / 2
    assert across.loc["initial tilt error", "std"] == pytest.approx(expected, rel=0.01)


def test_shipped_scenarios_are_valid_and_small():
    paths = sorted((shipped_scenarios() / "strapdown").glob("*.yaml"))
    assert len(paths) >= 4
    for path in paths:
        s = Scenario.from_yaml(path)
        assert isinstance(s.base, StrapdownScenario)
        assert s.n_points <= 120
        mcsim.results.check(s)


# ---- Table 1 of the application note ---------------------------------------------------


@pytest.fixture(scope="module")
def entries():
    return list(gravity_leakage())


def test_table_1_is_reproduced_to_its_printed_digits(entries):
    """Accelerations and velocities are right; positions are a t^2, twice a t^2 / 2."""
    assert len(entries) == 42
    for e in entries:
        a = NOTE_GRAVITY * math.sin(math.radians(float(e.angle.split()[0])))
        power = {"acceleration": 1.0, "velocity": e.time, "position": e.time**2}[e.quantity]
        assert e.printed == pytest.approx(a * power, rel=0.015)
        assert e.ratio == pytest.approx(2.0 if e.quantity == "position" else 1.0, rel=0.015)


def test_the_kernel_sides_with_the_closed_form(entries):
    """Forward Euler lags by T / t in position; nothing in velocity."""
    for e in entries:
        lag = 1.0 - (1 / RATE) / e.time if e.quantity == "position" else 1.0
        assert e.simulated == pytest.approx(e.exact * lag, rel=1e-6)
        assert e.exact == pytest.approx(e.with_9_8 * 9.80665 / 9.8, rel=1e-12)


@pytest.mark.slow
def test_table_command_prints_and_writes(tmp_path, capsys):
    file = tmp_path / "leakage.csv"
    assert exit_code(["table", "gravity-leakage", "--csv", str(file)]) == 0
    out = capsys.readouterr().out
    assert "factor of two (median ratio 2.00)" in out
    assert "85.4" in out
    assert len(pd.read_csv(file)) == 42
    assert exit_code(["table", "gravity-leakage", "--csv", str(tmp_path / "no" / "x.csv")]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_provenance_repeats_the_run():
    results = mcsim.run(Scenario.from_yaml(YAML))
    told = json.loads(json.dumps(results.provenance))
    again = mcsim.run(Scenario.from_dict(told["scenario"], told["name"]))
    pd.testing.assert_frame_equal(results.table, again.table, check_exact=True)


def test_sensor_files_belong_to_the_scenario(tmp_path):
    """A checkpoint must not outlive a change of such a file."""
    (tmp_path / "mine.yaml").write_text("accelerometer: {velocity_random_walk: 0.1 m/s/√h}\n")
    tree = scenario().document.tree
    tree = {**tree, "sensors": {**tree["sensors"], "accelerometer": "mine.yaml"}}
    assert Scenario.from_dict(tree, folder=tmp_path).base.files == ("mine.yaml",)


def test_the_notes_verdict_follows_from_its_ratios(entries):
    words = verdict(entries)
    assert "as printed, to the note's rounding" in words
    assert "a factor of two (median ratio 2.00)" in words
    halved = [
        replace(e, printed=e.printed / 2.0) if e.quantity == "position" else e for e in entries
    ]
    assert "agree\n(median ratio 1.00)" in verdict(halved)
    wrong = [replace(e, printed=1.5 * e.printed) for e in entries]
    assert "printed values differ by up to" in verdict(wrong)
    assert "2.99 times that" in verdict(wrong)
