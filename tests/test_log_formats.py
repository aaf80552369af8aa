"""The list of log formats: each knows its own files, and all that read logs take any of them."""

import json
from pathlib import Path

import numpy as np
import pytest

import mcsim
from mcsim.calibration.six_positions import POSITIONS, TRUE
from mcsim.cli.main import exit_code
from mcsim.errors import InputError
from mcsim.logs import LOG_FORMATS, LogFormat, log_columns, open_log, read_log
from mcsim.logs.formats import format_of, recognising
from mcsim.logs.names import meaning_of
from mcsim.vibration.log import read_vibration_log
from tests.test_logs import (
    ACCEL,
    GYRO,
    TIME,
    TITLES,
    check,
    make_bag,
    make_euroc,
    make_gnss_ins_sim,
    write,
)

EXAMPLE = Path(__file__).parent.parent / "docs" / "examples" / "json_lines.py"


def make_csv(folder):
    return write(folder / "log.csv", [TIME, ACCEL, GYRO], TITLES)


def make_timed_gnss_ins_sim(folder):
    write(folder / "time.csv", [TIME], ["time (sec)"])
    return make_gnss_ins_sim(folder)


MAKERS = {
    "csv": make_csv,
    "euroc": make_euroc,
    "gnss-ins-sim": make_timed_gnss_ins_sim,
    "ros-bag": lambda folder: make_bag(folder, "ros2", ["/imu"]),
}


def test_every_format_is_tried():
    assert list(MAKERS) == list(LOG_FORMATS)


@pytest.mark.parametrize("name", MAKERS)
def test_every_format_knows_its_own_files_and_no_other_does(name, tmp_path):
    path = MAKERS[name](tmp_path)
    assert format_of(path).name == name
    assert {log_format.name for log_format in recognising(path)} <= {name}


@pytest.mark.parametrize("name", MAKERS)
def test_every_format_refuses_the_files_of_others_in_one_message(name, tmp_path):
    for other, make in MAKERS.items():
        if other == name:
            continue
        (tmp_path / other).mkdir()
        path = make(tmp_path / other)
        with pytest.raises(InputError, match=other) as error:
            LOG_FORMATS[name].columns(path, mcsim.logs.ReadOptions())
        assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", MAKERS)
def test_all_readers_take_every_format(name, tmp_path):
    path = MAKERS[name](tmp_path)
    check(read_log(path))
    titles = open_log(path).titles
    named = {meaning.name: title.name for title in titles if (meaning := meaning_of(title))}
    channels = named["accel_x"], named["accel_y"]
    log = read_vibration_log(path, channels=channels)
    assert log.rate == pytest.approx(100.0, rel=1e-9)
    np.testing.assert_allclose(log.samples, ACCEL[:, :2], rtol=1e-12)
    assert log.name == path.stem


def test_a_folder_of_no_format_is_told_what_is_known(tmp_path):
    with pytest.raises(InputError) as error:
        open_log(tmp_path)
    for log_format in LOG_FORMATS.values():
        assert log_format.folder in str(error.value)


@pytest.fixture
def listed():
    """Adds formats for one test."""
    before = set(LOG_FORMATS)
    yield mcsim.add
    for name in set(LOG_FORMATS) - before:
        LOG_FORMATS.remove(name)


def anything(_):
    return True


def nothing(path, _):
    return log_columns(path, {"time [s]": []})


def test_two_formats_that_want_a_file_are_named(tmp_path, listed):
    path = make_csv(tmp_path)
    for name in ("one", "other"):
        listed(LogFormat(name, "log", anything, nothing))
    with pytest.raises(InputError, match=r"several formats of logs \(one, other\)"):
        read_log(path)


def test_a_format_that_fails_is_named(tmp_path, listed):
    path = make_csv(tmp_path)
    listed(LogFormat("own", "record of mine", lambda _: 1 / 0, nothing))
    with pytest.raises(InputError, match=r"log.csv: cannot be read as a record of mine \(division"):
        open_log(path)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"time [s]": [], "ax [g]": []}, "no rows"),
        ({}, "no rows"),
        ({"time [s]": [0.0, 1.0], "ax [g]": [1.0]}, r"differ in length \(time \[s\]: 2"),
        ({"ax [g]": [[1.0, 2.0]]}, "2 dimensions"),
        ({"time [s]": [0, 1], "ax [g]": [1.0, np.inf]}, r':2: column "ax \[g\]" holds inf'),
        ({"time [s]": ["a", "b"], "ax [g]": [1.0, 2.0]}, "no numbers|holds text"),
    ],
)
def test_bad_columns_end_in_one_message(columns, message, tmp_path, listed):
    path = make_csv(tmp_path)
    listed(LogFormat("own", "log", anything, lambda path, _: log_columns(path, columns)))
    with pytest.raises(InputError, match=message):
        read_log(path)


@pytest.fixture
def own(tmp_path, monkeypatch):
    """Runs a command line with the format of the example, and forgets it again."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        try:
            return exit_code(["--with", str(EXAMPLE), *arguments])
        finally:
            LOG_FORMATS.remove("json-lines")

    return run


def twins(name, units, columns):
    """The same numbers as a CSV file and as lines of JSON."""
    titles = [f"{title} [{unit}]" for title, unit in units.items()]
    write(Path(f"{name}.csv"), [columns], titles)
    rows = [dict(zip(units, map(float, row), strict=True)) for row in columns]
    Path(f"{name}.jsonl").write_text("\n".join(map(json.dumps, [units, *rows])) + "\n")


def same(first, second):
    assert Path(first).read_bytes() == Path(second).read_bytes()


def test_a_static_log_of_ones_own_format(own):
    rng = np.random.default_rng(7)
    t = np.arange(6000) / 100.0
    twins("log", {"t": "s", "gx": "deg/s"}, np.column_stack([t, rng.standard_normal(6000)]))
    assert own("characterise", "log.csv", "--output", "csv", "--quiet") == 0
    assert own("characterise", "log.jsonl", "--quiet") == 0
    for table in ("allan.csv", "psd.csv"):
        same(f"output/log/{table}", f"csv/{table}")


def test_a_vibration_of_ones_own_format(own):
    t = np.arange(1000) / 200.0
    twins("log", {"t": "s", "az": "m/s²"}, np.column_stack([t, np.sin(2 * np.pi * 20 * t)]))
    assert own("vibration", "log.csv", "--output", "csv", "--quiet") == 0
    assert own("vibration", "log.jsonl", "--output", "own", "--quiet") == 0
    for table in ("table.csv", "spectrum.csv"):
        same(f"own/log/{table}", f"csv/log/{table}")


DRIVE = """
case: planar
trajectory:
  shape: recorded
  file: drive.ENDING
  columns: {time: t, x: x, y: y}
sensors: {rate: 100 Hz, accelerometer: LSM330DL, gyroscope: LSM330DL}
monte_carlo: {realizations: 20}
"""


def test_a_drive_of_ones_own_format(own):
    t = np.arange(0.0, 10.0, 0.1)
    circle = np.column_stack([t, 60 * np.sin(t / 5), 60 - 60 * np.cos(t / 5)])
    twins("drive", {"t": "s", "x": "m", "y": "m"}, circle)
    for ending in ("csv", "jsonl"):
        Path(f"{ending}.yaml").write_text(DRIVE.replace("ENDING", ending))
        assert own("run", f"{ending}.yaml", "--no-figures", "--output", "out") == 0
    same("out/jsonl/table.csv", "out/csv/table.csv")


def test_a_bench_test_of_ones_own_format(own, capsys):
    means = 1.02 * TRUE + [0.01, -0.02, 0.03]
    rows = [dict(zip(("position", *"xyz"), (p, *m), strict=True)) for p, m in zip(
        POSITIONS, means.tolist(), strict=True)]  # fmt: skip
    units = {"position": "", "x": "g", "y": "g", "z": "g"}
    Path("test.jsonl").write_text("\n".join(map(json.dumps, [units, *rows])) + "\n")
    lines = ["position,x [g],y [g],z [g]", *(",".join(map(str, row.values())) for row in rows)]
    Path("test.csv").write_text("\n".join(lines) + "\n")
    said = []
    for file in ("test.csv", "test.jsonl"):
        assert own("calibrate", file) == 0
        said.append(capsys.readouterr().out.replace(file, "FILE"))
    assert said[0] == said[1]
    assert "1.02" in said[0]


def test_a_damaged_file_of_ones_own_format(own, capsys):
    Path("log.jsonl").write_text('{"t": "s"}\n{"t"\n')
    assert own("characterise", "log.jsonl") == 2
    assert "log.jsonl: cannot be read as a log of JSON lines (Expecting" in capsys.readouterr().err
    # Without the format it is a table of text, and none.
    assert exit_code(["characterise", "log.jsonl"]) == 2
