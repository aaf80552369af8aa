"""The public functions: what the commands do, where neither the commands nor click can be had."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import mcsim
from mcsim.errors import InputError
from mcsim.systems.velocity.raw_log import raw_log
from tests.conftest import BASE_YAML

SCENARIOS = Path(__file__).parent.parent / "scenarios"
A1 = SCENARIOS / "velocity" / "a1.yaml"
ENGINE = SCENARIOS / "vibration" / "engine.yaml"
#: What each public function is called with, and what its answer must hold.
CALLS = {
    "analyse_vibration": f"mcsim.analyse_vibration({str(ENGINE)!r}).analysis.table",
    "budget": f"mcsim.budget(mcsim.Scenario.from_yaml({str(A1)!r})).table",
    "calibrate": f"mcsim.calibrate({str(A1)!r}, samples=20).table",
    "characterise": "mcsim.characterise('static.csv', read={'rate': 100.0}).allan",
    "characterise_several": (
        "mcsim.characterise_several(['static.csv', 'other.csv'], read={'rate': 100.0}).table"
    ),
    "compare_stretches": (
        "mcsim.compare_stretches('static.csv', '0:60,60:120', read={'rate': 100.0}).table"
    ),
    "compare_vibrations": (
        f"mcsim.compare_vibrations([{str(ENGINE)!r}], sensors='MPU-9250,BNO055').found.table"
    ),
    "convert": "mcsim.convert('MPU-9250', rate=100.0, axis='x').texts",
    "convert_quantity": "mcsim.convert_quantity('0.2 °/√h').rows",
    "linearity": f"mcsim.linearity({str(A1)!r}).table",
    "load": "mcsim.load('out/case')",
    "read_parameters": "mcsim.read_parameters('sensor.yaml').sensor",
    "run": "mcsim.run(mcsim.Scenario.from_yaml('case.yaml'), output='out').table",
    "schema": "mcsim.schema('vibration')",
    "table": "mcsim.table('gravity-leakage').tables",
    "validate": "[mcsim.validate('case.yaml')]",
    "velocity": f"mcsim.velocity('runs.csv', {str(A1)!r}, monte_carlo={{'draws': 200}}).table",
}
_ORDER = sorted(CALLS, key=lambda name: name == "load")  # what `run` has written


def functions():
    """Public names that begin with a small letter and can be called, but for adding parts."""
    names = [n for n in mcsim.__all__ if n[0].islower() and callable(getattr(mcsim, n))]
    return {n for n in names if getattr(mcsim, n).__module__.startswith(("mcsim.api", "mcsim.p"))}


def test_every_function_is_tried():
    assert functions() <= CALLS.keys()


@pytest.mark.slow
def test_functions_work_without_the_command_line(tmp_path):
    (tmp_path / "case.yaml").write_text(BASE_YAML.replace("200", "20"))
    (tmp_path / "sensor.yaml").write_text("accelerometer: {velocity_random_walk: 0.1 m/s/√h}\n")
    log = np.random.default_rng(1).standard_normal((13_000, 2))
    columns = ["accel_x [m/s^2]", "accel_y [m/s^2]"]
    pd.DataFrame(log, columns=columns).to_csv(tmp_path / "static.csv", index=False)
    pd.DataFrame(log[::-1], columns=columns).to_csv(tmp_path / "other.csv", index=False)
    runs = raw_log(mcsim.Scenario.from_yaml(A1, ["runs=2"]).base, 1)
    pd.DataFrame(runs).to_csv(tmp_path / "runs.csv", index=False)
    lines = [
        "import sys, mcsim",
        "sys.modules['click'] = sys.modules['mcsim.cli'] = None",
        *(f"assert len({CALLS[name]}); print({name!r})" for name in _ORDER),
    ]
    result = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.split() == _ORDER


def test_what_was_found_is_written_with_its_origin(tmp_path):
    found = mcsim.linearity(A1, seed=3)
    files = found.write(tmp_path)
    assert files[-1].name == "provenance.json"
    told = json.loads(files[-1].read_text())
    assert told["command"] == "linearity"
    assert told["seed"] == 3
    assert set(told["inputs"]) == {"a1.yaml"}
    assert set(told["files"]) == {"linearity.csv"}
    written = pd.read_csv(tmp_path / "linearity.csv", engine="pyarrow")
    pd.testing.assert_frame_equal(written, found.table, check_exact=True)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: mcsim.table("sensor"), 'did you mean "sensors"'),
        (lambda: mcsim.table("sensors", sed=1), 'did you mean "seed"'),
        (lambda: mcsim.table("sensors", noise="pink"), "is not one of allan"),
        (lambda: mcsim.table("sensors", seed=-1), "at least 0"),
        (lambda: mcsim.table("sensors", seed="1"), "a whole number is needed"),
        (lambda: mcsim.table("sensors", duration="1 ms"), "between 1 s and 1 h"),
        (lambda: mcsim.schema("vibrations"), 'did you mean "vibration"'),
        (lambda: mcsim.calibrate(A1, alignment="12 °"), "between 0 ° and 11 °"),
        (lambda: mcsim.linearity(A1, full_scale="1 g"), "brings its own"),
        (lambda: mcsim.linearity("x.csv"), "full-scale: is missing"),
        (lambda: mcsim.convert("nothing/here"), "no such file"),
        (lambda: mcsim.analyse_vibration(ENGINE, read={"unit": "g"}), "belong to a log"),
        (lambda: mcsim.validate("none.yaml"), "no such file"),
        (lambda: mcsim.characterise("none.csv"), "no such file"),
    ],
)
def test_bad_arguments_are_explained(call, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if message.startswith("full"):
        Path("x.csv").write_text("reference,measured\n0.1,0.1\n0.2,0.2\n0.3,0.3\n0.5,0.5\n")
    with pytest.raises(InputError, match=message):
        call()


def test_nothing_is_replaced_unless_all_can_be_written(tmp_path):
    mcsim.linearity(A1).write(tmp_path)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}

    def broken(_):
        raise RuntimeError("no ink")

    table = pd.DataFrame({"x": [1.0]})
    report = mcsim.Report({}, tables={"linearity": table}, pictures={"linearity.png": broken})
    with pytest.raises(RuntimeError):
        report.write(tmp_path)
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


def test_tables_of_an_earlier_report_go_and_other_files_stay(tmp_path):
    table = pd.DataFrame({"x": [1.0]})
    both = ("csv", "parquet")
    mcsim.Report({}, tables={"one": table, "two": table}, formats=both).write(tmp_path)
    (tmp_path / "mine.csv").write_text("x\n")
    (tmp_path / "old.png").touch()
    mcsim.Report({}, tables={"one": table}, obsolete=("old",)).write(tmp_path)
    assert {file.name for file in tmp_path.iterdir()} == {"one.csv", "mine.csv", "provenance.json"}


@pytest.mark.parametrize("content", ["[", "[]", '{"files": 5}', '{"files": {"../x.csv": ""}}'])
def test_whatever_stands_in_an_old_provenance_harms_nothing(tmp_path, content):
    folder = tmp_path / "results"
    folder.mkdir()
    (tmp_path / "x.csv").write_text("precious")
    (folder / "provenance.json").write_text(content)
    mcsim.Report({"mcsim": "1"}, texts={"a.txt": "a"}).write(folder)
    assert {file.name for file in folder.iterdir()} == {"a.txt", "provenance.json"}
    assert (tmp_path / "x.csv").read_text() == "precious"
