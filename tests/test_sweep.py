"""Sweeps and stored results: reproducible to the last bit, whole files, resumable."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import mcsim
from mcsim import InputError, Scenario
from mcsim.checkpoints import Checkpoint
from mcsim.results import COLUMNS, circumstances
from mcsim.scenario.document import Document
from mcsim.scenario.validation import validate
from mcsim.store import load_results
from mcsim.sweep import run_sweep
from mcsim.systems.planar.scenario import PlanarScenario
from mcsim.vibration.scenario import VibrationScenario, is_vibration, read_vibration
from tests.conftest import ALL_ERRORS, BASE_YAML, NO_NOISE, scenario

ERRORS = PlanarScenario.ERRORS
STATISTICS = len(PlanarScenario.PERCENTILES) + 4


def files_of(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.slow
def test_table_is_tidy_and_complete(tmp_path):
    s = Scenario.from_yaml(BASE_YAML)
    results = mcsim.run(s, output=tmp_path)
    table = results.table
    assert len(table) == 4 * len(ERRORS) * STATISTICS
    assert list(table.columns[2:]) == list(COLUMNS)
    assert table.columns[0] == "sensors.accelerometer.noise_density [m/s^2/√Hz]"
    assert set(table["unit"]) == {"m", "deg"}
    assert (table["realizations"] == 200).all()
    assert (table["ci_low"] <= table["value"]).all()
    assert (table["value"] <= table["ci_high"]).all()
    for _, rows in table.groupby([*table.columns[:2], "error"]):
        v = rows.set_index("statistic")["value"]
        assert v["rms"] ** 2 == pytest.approx(v["mean"] ** 2 + v["std"] ** 2, rel=1e-12)
    assert files_of(tmp_path / "scenario") == [
        "budget.csv",
        "budget.parquet",
        "figure.png",
        "figure.svg",
        "provenance.json",
        "table.csv",
        "table.parquet",
    ]


@pytest.mark.slow
def test_csv_and_parquet_hold_the_same_numbers(tmp_path):
    results = mcsim.run(Scenario.from_yaml(BASE_YAML), output=tmp_path)
    folder = tmp_path / "scenario"
    for path in (folder, folder / "table.csv", folder / "table.parquet"):
        pd.testing.assert_frame_equal(
            mcsim.load(path), results.table, check_exact=True, check_dtype=False
        )


def test_any_number_of_jobs_gives_the_same_table():
    s = Scenario.from_yaml(BASE_YAML)
    tables = [mcsim.run(s, jobs=jobs).table for jobs in (1, 2, 5)]
    for table in tables[1:]:
        pd.testing.assert_frame_equal(tables[0], table, check_exact=True)


def test_an_added_point_changes_no_other_row():
    s = Scenario.from_yaml(BASE_YAML)
    key = "sweep.sensors.accelerometer.noise_density"
    more = s.with_values({key: ["5e-4 m/s^2/√Hz", "1e-3 m/s^2/√Hz", "1e-2 m/s^2/√Hz"]})
    few, many = mcsim.run(s).table, mcsim.run(more).table
    kept = many[many[many.columns[0]] != 5e-4].reset_index(drop=True)
    pd.testing.assert_frame_equal(few, kept, check_exact=True)


def test_the_unit_a_value_is_written_in_changes_nothing():
    a = scenario({"sweep": {"trajectory.speed": ["20 m/s"]}, "monte_carlo.realizations": 50})
    b = scenario({"sweep": {"trajectory.speed": ["72 km/h"]}, "monte_carlo.realizations": 50})
    ours, theirs = mcsim.run(a).table, mcsim.run(b).table
    np.testing.assert_array_equal(ours["value"], theirs["value"])
    assert list(theirs["trajectory.speed [km/h]"].unique()) == [72.0]


def test_points_have_streams_of_their_own_unless_common():
    """Two points that differ in a value without influence: equal only with common numbers."""
    sweep = {"initial.speed_error": ["0 m/s", "1e-9 m/s"]}
    for common in (False, True):
        s = scenario(
            {
                "sweep": sweep,
                "monte_carlo.realizations": 100,
                "monte_carlo.common_random_numbers": common,
                "monte_carlo.estimator": "plain",
            }
        )
        t = mcsim.run(s).table
        heading = t[(t["error"] == "heading") & (t["statistic"] == "std")]["value"].to_numpy()
        assert bool(heading[0] == heading[1]) == common


@pytest.mark.slow
def test_provenance_tells_how_to_repeat_the_run(tmp_path):
    s = Scenario.from_yaml(BASE_YAML)
    results = mcsim.run(s, output=tmp_path)
    told = json.loads((tmp_path / "scenario" / "provenance.json").read_text())
    assert told["seed"] == 1
    assert told["points"] == told["points_done"] == 4
    assert {"python", "numpy", "numba"} <= told["versions"].keys()
    assert told["resolved"]["sensors"]["rate"] == "100 Hz"
    again = mcsim.run(Scenario.from_dict(told["scenario"], told["name"]))
    pd.testing.assert_frame_equal(results.table, again.table, check_exact=True)


SHIPPED = sorted((Path(__file__).parent.parent / "scenarios").glob("*/*.yaml"))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_resolved_scenarios_are_scenarios_again(path):
    if is_vibration(path):
        base = read_vibration(path)
        resolved = base.model_dump(mode="json", exclude_none=True)
        assert validate(Document(resolved, "resolved"), VibrationScenario) == base
        return
    s = Scenario.from_yaml(path)
    resolved = json.loads(json.dumps(circumstances(s)["resolved"]))
    assert Scenario.from_dict(resolved, folder=path.parent).base == s.base


def test_resolved_ratios_read_back():
    terms = {"sensors.accelerometer.scale_factor_error": ["1 %", "123.456 ppm", "0.3 %"]}
    s = scenario(terms)
    resolved = circumstances(s)["resolved"]
    assert resolved["sensors"]["accelerometer"]["scale_factor_error"][0] == "1 %"
    assert Scenario.from_dict(resolved).base == s.base
    # Control: the SI unit of a ratio has no sign, and a bare number is refused.
    resolved["sensors"]["accelerometer"]["scale_factor_error"][0] = "0.01 1"
    with pytest.raises(InputError, match="unknown unit"):
        Scenario.from_dict(resolved)


@pytest.mark.slow
def test_stored_results_load_with_their_scenario(tmp_path):
    s = scenario(
        {
            "monte_carlo.realizations": 50,
            "outputs": {"history": True, "tracks": 3},
        }
    )
    mcsim.run(s, output=tmp_path)
    stored = load_results(tmp_path / "base")
    assert stored.history is not None
    assert stored.tracks is not None
    assert stored.scenario.base == s.base
    assert set(stored.tracks["realization"]) == {-1, 0, 1, 2}
    # A run that keeps neither removes what the one before left.
    mcsim.run(s.with_values({"outputs": {}}), output=tmp_path)
    assert not [name for name in files_of(tmp_path / "base") if "history" in name]
    assert not [name for name in files_of(tmp_path / "base") if "tracks" in name]


@pytest.mark.slow
@pytest.mark.parametrize("offsets", ["random", "sobol"])
@pytest.mark.parametrize("estimator", ["plain", "control_variate", "linear"])
@pytest.mark.parametrize("count", [300, 6000])
def test_history_ends_in_the_table(offsets, estimator, count):
    """Whatever the table is estimated from; and it leads there without a jump."""
    s = scenario(
        {
            **ALL_ERRORS,
            "monte_carlo.realizations": count,
            "monte_carlo.estimator": estimator,
            "monte_carlo.offsets": offsets,
            "outputs": {"history": True},
        }
    )
    results = mcsim.run(s)
    by = ["error", "statistic"]
    times = np.sort(results.history["time [s]"].unique())
    end, before = (
        results.history[results.history["time [s]"] == t].set_index(by)["value"]
        for t in times[[-1, -2]]
    )
    table = results.table.set_index(by)["value"]
    both = [row for row in end.index if row in table.index]
    assert len(both) == 5 * len(ERRORS)
    assert (end[both] == table[both]).all()
    rms = [row for row in both if row[1] == "rms"]
    np.testing.assert_allclose(before[rms], end[rms], rtol=0.02)


class Stopped(Exception):
    pass


@pytest.mark.slow
def test_a_killed_sweep_goes_on_where_it_was(tmp_path):
    """Stopped after two points, its checkpoint cut mid-line: the same bits as undisturbed."""
    s = Scenario.from_yaml(BASE_YAML)
    undisturbed = mcsim.run(s)
    folder = tmp_path / "scenario"
    checkpoint = Checkpoint.of(s, folder)
    finished = []

    def keep_two(index, result):
        write(index, result)
        finished.append(index)
        if len(finished) == 2:
            raise Stopped

    with checkpoint.writer() as write, pytest.raises(Stopped):
        run_sweep(s, 1, on_result=keep_two)
    path = checkpoint.path
    path.write_text(path.read_text() + '{"index": 2, "value": [["0x1.')
    assert sorted(checkpoint.read()) == sorted(finished)

    class Watch:
        resumed = None

        def start(self, _scenario, _realizations, resumed):
            Watch.resumed = resumed

        def advance(self, _realizations): ...
        def point_done(self): ...
        def finish(self): ...

    resumed = mcsim.run(s, output=tmp_path, progress=Watch())
    assert Watch.resumed == 2
    pd.testing.assert_frame_equal(undisturbed.table, resumed.table, check_exact=True)
    assert not path.exists()


def test_checkpoints_of_another_scenario_are_ignored(tmp_path):
    s = Scenario.from_yaml(BASE_YAML)
    checkpoint = Checkpoint.of(s, tmp_path)
    with checkpoint.writer() as write:
        run_sweep(s, 1, on_result=write)
    assert len(checkpoint.read()) == 4
    other = s.with_values({"monte_carlo.seed": 2})
    assert Checkpoint.of(other, tmp_path).read() == {}
    checkpoint.path.write_bytes(b"\xff\xfe garbage")
    assert checkpoint.read() == {}


def test_a_failing_point_leaves_the_others(monkeypatch):
    import mcsim.sweep as sweep_module

    real = sweep_module.problem_of

    def sometimes(model, folder):
        if model.sensors.accelerometer.noise_density == (1e-2,):
            raise MemoryError("no room")
        return real(model, folder)

    monkeypatch.setattr(sweep_module, "problem_of", sometimes)
    results = mcsim.run(Scenario.from_yaml(BASE_YAML))
    assert len(results.failures) == 2
    assert "no room" in results.failures[0]
    assert len(results.table) == 2 * len(ERRORS) * STATISTICS


def test_points_that_cannot_run_are_refused_before_anything_runs(tmp_path):
    s = scenario({"sweep": {"sensors.rate": ["100 Hz", "0.2 Hz"]}})
    with pytest.raises(InputError, match="less than one sampling interval"):
        mcsim.run(s, output=tmp_path)
    assert not list(tmp_path.iterdir())


def test_absurdly_long_drives_are_refused():
    s = scenario({"trajectory.length": "9e7 m"})
    with pytest.raises(InputError, match="more than mcsim can hold"):
        mcsim.run(s)


def test_undisturbed_errors_are_remarked_not_repeated():
    s = scenario({**NO_NOISE, "monte_carlo.realizations": 20})
    results = mcsim.run(s)
    assert len(results.remarks) == 5
    assert "nothing disturbs" in results.remarks[0]
    t = results.table
    method = t[t["statistic"] == "method"]["value"].to_numpy()
    mean = t[t["statistic"] == "mean"]["value"].to_numpy()
    np.testing.assert_array_equal(method, mean)


def test_an_unwritable_output_is_explained(tmp_path):
    blocker = tmp_path / "file"
    blocker.write_text("here")
    with pytest.raises(InputError, match="cannot be written"):
        mcsim.run(scenario({"monte_carlo.realizations": 10}), output=blocker)


@pytest.mark.parametrize("name", ["absent", "empty"])
def test_loading_what_is_no_result(tmp_path, name):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError):
        mcsim.load(tmp_path / name)


def test_results_are_frozen():
    results = mcsim.run(scenario({"monte_carlo.realizations": 10}))
    with pytest.raises(AttributeError):
        results.table = None
    assert replace(results, history=None) is not results


@pytest.mark.slow
def test_two_runs_in_one_folder_do_not_mix(tmp_path):
    """Their checkpoints have different names: neither reads nor cuts the other's."""
    one = Scenario.from_yaml(BASE_YAML)
    two = one.with_values({"monte_carlo.seed": 2})
    a, b = (Checkpoint.of(s, tmp_path) for s in (one, two))
    with a.writer() as first, b.writer() as second:
        run_sweep(one, 1, on_result=first)
        run_sweep(two, 1, on_result=second)
    mixed = mcsim.run(two, output=tmp_path.parent / "other")
    assert a.read().keys() == b.read().keys()
    value = b.read()[0].estimates.value[0, 0]
    row = mixed.table.iloc[0]
    assert value == row["value"]


def test_recorded_files_belong_to_the_checkpoint(tmp_path):
    rows = ["time,x,y", *(f"{0.1 * i},{i},{0.01 * i * i}" for i in range(100))]
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text("\n".join(rows))
    s = Scenario.from_dict(
        {
            "case": "planar",
            "trajectory": {
                "shape": "recorded",
                "file": "a.csv",
                "columns": {"x": "x in m", "y": "y in m"},
            },
            "sensors": {"rate": "50 Hz", "accelerometer": "LSM330DL", "gyroscope": "LSM330DL"},
            "monte_carlo": {"realizations": 10},
            "sweep": {"trajectory.file": ["a.csv", "b.csv"]},
        },
        folder=tmp_path,
    )
    before = Checkpoint.of(s, tmp_path).path
    (tmp_path / "b.csv").write_text("\n".join(rows[:-1]))
    assert Checkpoint.of(s, tmp_path).path != before


def test_budgets_tell_where_the_scatter_comes_from(tmp_path):
    """Shares add to one; each source alone, squared and summed, gives the whole deviation."""
    s = scenario({**ALL_ERRORS, "monte_carlo.realizations": 20_000})
    results = mcsim.run(s, output=tmp_path)
    budget = load_results(tmp_path / "base").budget
    pd.testing.assert_frame_equal(budget, results.budget, check_dtype=False)
    std = results.table[results.table["statistic"] == "std"].set_index("error")["value"]
    for name, rows in budget.groupby("error"):
        assert rows["share"].sum() == pytest.approx(1.0)
        if name != "position":
            assert np.sqrt((rows["std"] ** 2).sum()) == pytest.approx(std[name], rel=0.005)


def test_linear_answers_have_the_tables_shape_and_flag_contradictions():
    easy = mcsim.run(scenario({**ALL_ERRORS, "monte_carlo.estimator": "linear"}))
    exact = mcsim.run(scenario({**ALL_ERRORS, "monte_carlo.realizations": 200_000}))
    assert list(easy.table.columns) == list(exact.table.columns)
    a = easy.table.set_index(["error", "statistic"])["value"]
    b = exact.table.set_index(["error", "statistic"])["value"]
    for name in ERRORS:
        for statistic in ("std", "rms", "p95"):
            assert a[name, statistic] == pytest.approx(b[name, statistic], rel=0.01)
    assert not easy.remarks
    hard = mcsim.run(
        scenario({"sensors.gyroscope.miscalibration": "3 °/s", "monte_carlo.estimator": "linear"})
    )
    assert any("across: Monte Carlo contradicts the linear model" in r for r in hard.remarks)
    assert not any(r.startswith("heading") for r in hard.remarks)


def test_an_undefined_error_has_no_budget():
    s = scenario(
        {
            "trajectory.speed": "10 m/s",
            "trajectory.deceleration": "2 m/s^2",
            "monte_carlo.realizations": 200,
        }
    )
    assert set(mcsim.run(s).budget["error"]) == set(ERRORS) - {"course"}


def test_a_run_interrupted_before_its_first_point_leaves_nothing(tmp_path):
    checkpoint = Checkpoint.of(Scenario.from_yaml(BASE_YAML), tmp_path / "case")

    def interrupted():
        with checkpoint.writer():
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not list(tmp_path.iterdir())
    (tmp_path / "case").mkdir()
    (tmp_path / "case" / "table.csv").touch()
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert files_of(tmp_path / "case") == ["table.csv"]


def test_reproducible_provenance_says_nothing_of_time_and_machine(monkeypatch):
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    usual = circumstances(scenario())
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    same = circumstances(scenario())
    assert set(usual) - set(same) == {"versions", "platform", "finished"}
