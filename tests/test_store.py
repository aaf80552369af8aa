"""Stored results and checkpoints: damage is found, said in one sentence, and never blocks a run."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import mcsim
from mcsim import InputError
from mcsim.checkpoints import Checkpoint
from mcsim.cli.main import exit_code
from mcsim.provenance import mark_of
from mcsim.scenario_file import Scenario
from mcsim.store import load, load_results
from mcsim.writing import LOCK, alone_in, write_whole

SHIPPED = Path(__file__).parent.parent / "results"
LARGE = ("log", "spectrum")
SCENARIO = """case: planar
trajectory: {shape: half_cosine, length: 50 m, width: 5 m, speed: 20 m/s}
sensors: {rate: 50 Hz, accelerometer: LSM330DL, gyroscope: LSM330DL}
monte_carlo: {realizations: 20, seed: 3, resamples: 100}
outputs: {history: true, tracks: 2}
sweep: {trajectory.speed: [10 m/s, 20 m/s, 30 m/s]}
"""


def drawn_nowhere(*_):
    """Pictures take time, and say nothing here."""


def run(output, overrides=(), **kwargs):
    scenario = Scenario.from_yaml(SCENARIO, overrides)
    return mcsim.run(scenario, output=output, draw=drawn_nowhere, jobs=1, **kwargs)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A result, and one of another rate."""
    folder = tmp_path_factory.mktemp("stored")
    run(folder / "a")
    run(folder / "b", ["sensors.rate=40 Hz", "outputs.history=false"])
    return folder / "a" / "scenario", folder / "b" / "scenario"


@pytest.fixture
def result(stored, tmp_path):
    return shutil.copytree(stored[0], tmp_path / "result")


def refusal(folder, capsys):
    """What `plot` says, which must be one sentence and exit code 2, and `load_results` too."""
    with pytest.raises(InputError):
        load_results(folder)
    capsys.readouterr()
    assert exit_code(["plot", str(folder)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "internal" not in error
    return error


TABLES = ("table.parquet", "budget.parquet", "history.parquet", "tracks.parquet")


@pytest.mark.slow
@pytest.mark.parametrize("name", [*TABLES, "provenance.json"])
@pytest.mark.parametrize("damage", ["empty", "cut", "flipped", "text", "folder", "pipe", "other's"])
def test_damaged_parts_are_refused(result, stored, capsys, name, damage):
    file = result / name
    content = file.read_bytes()
    file.unlink()
    if damage == "folder":
        file.mkdir()
    elif damage == "pipe":
        os.mkfifo(file)
    else:
        half = len(content) // 2
        other = stored[1] / name
        changed = {
            "empty": b"",
            "cut": content[:half],
            "flipped": content[:half] + bytes([content[half] ^ 128]) + content[half + 1 :],
            "text": b"a,b\n1,2\n",
            # The other run has no history: its tracks stand in for them.
            "other's": (other if other.exists() else stored[1] / "tracks.parquet").read_bytes(),
        }
        file.write_bytes(changed[damage])
    assert name in refusal(result, capsys)


@pytest.mark.parametrize("name", TABLES)
def test_a_sound_result_is_read(result, name):
    """The control of the tests above."""
    assert name in json.loads((result / "provenance.json").read_text())["files"]
    assert len(load_results(result).table) == len(load(result))


SWEPT = {
    "numbers": "{trajectory.speed: [10 m/s, 1 m/s], sensors.rate: [30 Hz, 50 Hz]}",
    "texts": "{reconstruction.integration: [rectangular, trapezoidal]}",
    "names": "{sensors.accelerometer: [LSM330DL, MPU-9250]}",
    "whole numbers": "{monte_carlo.resamples: [100, 200]}",
    "nothing": "null",
}


@pytest.mark.slow
@pytest.mark.parametrize("swept", [*SWEPT.values(), "undisturbed"], ids=[*SWEPT, "undisturbed"])
def test_csv_holds_what_parquet_holds(tmp_path, swept):
    """Floats to the last bit, empty notes, tables without any value: read from either."""
    silent = [
        "sensors.accelerometer={noise_density: 0 m/s²/√Hz}",
        "sensors.gyroscope={noise_density: 0 °/s/√Hz}",
    ]
    results = run(tmp_path, silent if swept == "undisturbed" else [f"sweep={swept}"])
    folder = tmp_path / "scenario"
    by_parquet = load_results(folder)
    for file in folder.glob("*.parquet"):
        file.unlink()
    by_csv = load_results(folder)
    for name in ("table", "budget", "history", "tracks"):
        parquet, csv = getattr(by_parquet, name), getattr(by_csv, name)
        assert list(csv) == list(parquet)
        assert len(csv) == len(parquet)
        if len(csv):  # columns without rows have no type to speak of
            pd.testing.assert_frame_equal(csv, parquet, check_exact=True)
            pd.testing.assert_frame_equal(csv, getattr(results, name), check_exact=True)
    pd.testing.assert_frame_equal(load(folder), by_parquet.table, check_exact=True)


def test_formats_that_are_not_written_do_not_stay(tmp_path):
    """A result of both formats, made again as CSV alone, is one of CSV alone."""
    run(tmp_path)
    run(tmp_path, ["monte_carlo.seed=4"], formats=("csv",))
    folder = tmp_path / "scenario"
    assert not list(folder.glob("*.parquet"))
    assert set(json.loads((folder / "provenance.json").read_text())["files"]) == {
        "table.csv",
        "budget.csv",
        "history.csv",
        "tracks.csv",
    }
    assert load_results(folder).scenario.base.monte_carlo.seed == 4


def _is_large(stem):
    return stem in LARGE or stem.startswith("log-")


def test_shipped_results_are_read():
    """They hold CSV alone, and what their provenance tells of is what lies there."""
    folders = sorted(file.parent for file in SHIPPED.glob("*/table.csv"))
    runs = [f for f in folders if "scenario" in json.loads((f / "provenance.json").read_text())]
    assert len(runs) >= 10
    assert not list(SHIPPED.rglob("*.parquet"))
    for folder in runs:
        assert load_results(folder).budget is not None
    for provenance in SHIPPED.rglob("provenance.json"):
        for name, mark in json.loads(provenance.read_text()).get("files", {}).items():
            file = provenance.parent / name
            # Simulated logs and their full spectra are not shipped.
            assert mark_of(file.read_bytes()) == mark if file.exists() else _is_large(file.stem)


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t.drop(columns="value"),
        lambda t: t.assign(value=t["value"].astype(str)),
        lambda t: t.iloc[:0],
        lambda t: t.assign(error="zzz"),
        lambda t: t.rename(columns={"trajectory.speed [m/s]": "x"}),
        lambda t: t.assign(**{"trajectory.speed [m/s]": 11.0}),
        lambda t: t.assign(error=[[1]] * len(t)),
    ],
)
def test_tables_without_marks_are_looked_at(result, capsys, change):
    """Results of earlier versions carry no digests."""
    provenance = json.loads((result / "provenance.json").read_text())
    del provenance["files"]
    (result / "provenance.json").write_text(json.dumps(provenance))
    assert len(load_results(result).table)
    table = pd.read_parquet(result / "table.parquet")
    change(table).to_parquet(result / "table.parquet", index=False)
    assert "table.parquet" in refusal(result, capsys)


@pytest.mark.slow
def test_a_table_without_any_number_is_drawn(result):
    """A figure of nothing but missing values is empty, and no warning."""
    provenance = json.loads((result / "provenance.json").read_text())
    del provenance["files"]
    (result / "provenance.json").write_text(json.dumps(provenance))
    table = pd.read_parquet(result / "table.parquet").assign(value=np.nan)
    table.to_parquet(result / "table.parquet", index=False)
    assert exit_code(["plot", str(result)]) == 0


def checkpoint_of(tmp_path):
    """A checkpoint of all points, as a run leaves it that is stopped while it draws."""

    class Stopped(Exception):
        pass

    def stop(*_):
        raise Stopped

    scenario = Scenario.from_yaml(SCENARIO)
    with pytest.raises(Stopped):
        mcsim.run(scenario, output=tmp_path, draw=stop, jobs=1)
    return Checkpoint.of(scenario, tmp_path / "scenario")


@pytest.mark.slow
def test_every_flipped_bit_of_a_checkpoint_is_found(tmp_path):
    """What is read is what was written, or it is left out."""
    checkpoint = checkpoint_of(tmp_path)
    content = checkpoint.path.read_bytes()
    sound = {index: repr(point) for index, point in checkpoint.read().items()}
    assert len(sound) == 3
    generator = random.Random(1)
    left_out = 0
    for _ in range(300):
        flipped = bytearray(content)
        flipped[generator.randrange(len(content))] ^= 1 << generator.randrange(8)
        checkpoint.path.write_bytes(flipped)
        found = checkpoint.read()
        assert all(repr(point) == sound[index] for index, point in found.items())
        left_out += len(found) < 3
    assert left_out > 250


def _with(record, **changes):
    return {**record, **changes}


@pytest.mark.slow
@pytest.mark.parametrize(
    "forge",
    [
        lambda r: _with(r, index=77),
        lambda r: _with(r, index=-1),
        lambda r: _with(r, value=[["0x1p0"]]),
        lambda r: _with(r, value="abc"),
        lambda r: _with(r, method=[["0x1p0"]]),
        lambda r: _with(r, variances={"x": ["0x1p0"]}),
        lambda r: _with(r, variances=[1]),
        lambda r: _with(r, notes={"along": 5}),
        lambda r: _with(r, degenerate=[]),
        lambda r: _with(r, low=[["0x1.0p+99999"]]),
    ],
)
def test_lines_that_do_not_fit_are_computed_again(tmp_path, stored, forge):
    """Even with a right checksum: told, and the results are those of a run without them."""
    checkpoint = checkpoint_of(tmp_path)
    lines = [json.loads(line) for line in checkpoint.path.read_text().split("\n") if line]
    forged = forge({key: value for key, value in lines[0].items() if key != "check"})
    forged["check"] = checkpoint._check(forged)
    texts = [json.dumps(line) for line in (forged, *lines[1:])]
    checkpoint.path.write_text("\n".join(texts) + "\n")
    results = run(tmp_path)
    assert any("1 damaged line left out" in remark for remark in results.remarks)
    mine, right = (
        (folder / "table.csv").read_bytes() for folder in (tmp_path / "scenario", stored[0])
    )
    assert mine == right
    assert not checkpoint.path.exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"\xff\xfe garbage\n", True),
        (b"1\n2\nnull\n[]\n", True),
        (b"[" * 100_000 + b"\n", True),
        (b'{"index": ' + b"9" * 5000 + b"}\n", True),
        (b'{"index": 2, "value": [["0x1.', False),  # cut short by a kill
        (b"", False),
    ],
)
def test_garbage_in_a_checkpoint_is_left_out(tmp_path, content, told):
    scenario = Scenario.from_yaml(SCENARIO)
    checkpoint = Checkpoint.of(scenario, tmp_path / "scenario")
    checkpoint.path.parent.mkdir()
    checkpoint.path.write_bytes(content)
    assert any("damaged" in remark for remark in run(tmp_path).remarks) == told


def test_lines_of_another_scenario_are_left_out(tmp_path):
    checkpoint = checkpoint_of(tmp_path)
    other = Scenario.from_yaml(SCENARIO, ["monte_carlo.seed=4"])
    elsewhere = Checkpoint.of(other, tmp_path / "scenario")
    shutil.copy(checkpoint.path, elsewhere.path)
    assert len(checkpoint.read()) == 3
    assert elsewhere.recover() == ({}, 3)
    assert elsewhere.recover() == ({}, 0)


@pytest.mark.parametrize("kind", ["pipe", "folder", "link"])
def test_what_stands_in_a_checkpoints_place_is_refused(tmp_path, kind):
    path = Checkpoint.of(Scenario.from_yaml(SCENARIO), tmp_path / "scenario").path
    path.parent.mkdir()
    precious = tmp_path / "precious"
    precious.write_text("mine")
    {"pipe": os.mkfifo, "folder": os.mkdir, "link": lambda p: p.symlink_to(precious)}[kind](path)
    with pytest.raises(InputError, match="checkpoint"):
        run(tmp_path)
    assert precious.read_text() == "mine"


@pytest.mark.slow
def test_a_run_that_is_stopped_while_it_writes_is_not_taken_for_another(tmp_path, monkeypatch):
    """Tables of seed 4 beside the provenance of seed 3, whenever the second run stops."""
    run(tmp_path)
    replace, left = type(tmp_path).replace, [0]

    def stop_after(self, target):
        left[0] -= 1
        if left[0] < 0:
            raise KeyboardInterrupt
        return replace(self, target)

    monkeypatch.setattr(type(tmp_path), "replace", stop_after)
    for files in range(1, 9):
        left[0] = files
        with pytest.raises(KeyboardInterrupt):
            run(tmp_path, ["monte_carlo.seed=4"])
        with pytest.raises(InputError, match="provenance"):
            load_results(tmp_path / "scenario")
    monkeypatch.undo()
    run(tmp_path, ["monte_carlo.seed=4"])
    assert load_results(tmp_path / "scenario").scenario.base.monte_carlo.seed == 4


def test_two_runs_do_not_write_into_one_folder(tmp_path):
    with alone_in(tmp_path / "scenario"), pytest.raises(InputError, match="another run writes"):
        run(tmp_path)
    assert not (tmp_path / "scenario").exists()
    run(tmp_path)
    assert not (tmp_path / "scenario" / LOCK).exists()


def test_a_dead_runs_lock_is_none(tmp_path):
    (tmp_path / "scenario").mkdir()
    (tmp_path / "scenario" / LOCK).touch()
    run(tmp_path)
    assert not (tmp_path / "scenario" / LOCK).exists()


def test_what_a_kill_leaves_beside_a_file_is_removed(tmp_path):
    stale = tmp_path / ".table-abcd_123.csv"
    others = [".table-abcd_123.txt", ".table-.csv", "table-abcd_123.csv", ".other-abcd_123.csv"]
    for name in (stale.name, *others):
        (tmp_path / name).touch()

    def write(path):
        # A file that somebody still writes is no stale one.
        write_whole(tmp_path / "table.csv", lambda inner: inner.write_text("inner"))
        path.write_text("outer")

    write_whole(tmp_path / "table.csv", write)
    assert (tmp_path / "table.csv").read_text() == "outer"
    assert {file.name for file in tmp_path.iterdir()} == {"table.csv", *others}


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_other_signals_end_a_run_as_ctrl_c_does(tmp_path, number):
    path = tmp_path / "case.yaml"
    path.write_text(SCENARIO.replace("realizations: 20", "realizations: 2000000"))
    out = tmp_path / "out"
    process = subprocess.Popen(
        [sys.executable, "-m", "mcsim", "run", str(path), "--output", str(out), "--jobs", "1"],
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 100
    while time.monotonic() < deadline and not (out / "case" / LOCK).exists():
        time.sleep(0.05)
    process.send_signal(number)
    _, error = process.communicate(timeout=100)
    assert process.returncode == 130, error
    assert "interrupted with" in error
    assert "Traceback" not in error
    assert not list(out.glob("*/[!.]*"))
