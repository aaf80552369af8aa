"""Reading logs of vibrations from CSV files."""

import numpy as np
import pytest

from mcsim.errors import InputError
from mcsim.vibration.log import read_vibration_log

RATE, COUNT = 100.0, 200
TIME = np.arange(COUNT) / RATE
SIGNAL = np.sin(2 * np.pi * 3.0 * TIME)


@pytest.fixture
def csv(tmp_path):
    def write(header, *columns, name="log.csv"):
        path = tmp_path / name
        lines = [",".join(f"{value:.12g}" for value in row) for row in zip(*columns, strict=True)]
        path.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")
        return path

    return write


def test_units_come_from_the_header(csv):
    log = read_vibration_log(
        csv("time [ms],ax [g],gz [°/s],az (m/s^2)", 1e3 * TIME, SIGNAL, TIME, 2 * SIGNAL)
    )
    assert log.name == "log"
    assert log.channels == ("ax", "az")
    assert log.rate == pytest.approx(RATE)
    np.testing.assert_allclose(log.samples, np.stack([9.80665 * SIGNAL, 2 * SIGNAL], 1), atol=1e-9)
    np.testing.assert_allclose(log.time, TIME, atol=1e-12)
    assert log.notes == ()


def test_units_and_rate_come_from_options(csv):
    path = csv("ax,ay", SIGNAL, TIME)
    log = read_vibration_log(path, unit="mg", rate=50.0, channels=("ay",))
    assert log.channels == ("ay",)
    assert log.rate == 50.0
    np.testing.assert_allclose(log.samples[:, 0], TIME * 9.80665e-3, atol=1e-12)
    log = read_vibration_log(csv("millis,ax [g]", 1e3 * TIME, SIGNAL), time="millis in ms")
    assert log.rate == pytest.approx(RATE)


def test_simulated_logs_are_read_back(csv):
    log = read_vibration_log(csv("time [s],ax [m/s^2],ay [m/s^2]", TIME, SIGNAL, SIGNAL))
    np.testing.assert_allclose(log.samples[:, 1], SIGNAL, atol=1e-11)


def test_jittery_stamps_are_evened_out(csv):
    jitter = np.random.default_rng(1).uniform(-0.2, 0.2, COUNT) / RATE
    stamps = TIME + jitter
    stamps[[0, -1]] = TIME[[0, -1]]
    log = read_vibration_log(csv("t [s],a [m/s²]", stamps, np.sin(2 * np.pi * 3.0 * stamps)))
    assert "interpolated to 100 Hz" in log.notes[0]
    # Linear interpolation over a step h errs by at most (2 pi f h)² / 8, 2 % of 0.3.
    np.testing.assert_allclose(log.samples[:, 0], SIGNAL, atol=8e-3)
    # Taken at face value the samples would be wrong by 2 pi f 0.2 h, five times as much.
    assert np.abs(np.sin(2 * np.pi * 3.0 * stamps) - SIGNAL).max() > 0.03


def test_logs_of_a_wandering_rate_keep_their_usual_step(csv):
    stamps = np.concatenate([TIME, TIME[-1] + np.arange(1, 41) / 20.0])
    log = read_vibration_log(csv("t [s],a [m/s²]", stamps, stamps))
    assert log.rate == pytest.approx(RATE)
    np.testing.assert_allclose(log.samples[:, 0], log.time, atol=1e-9)


@pytest.mark.parametrize(
    ("header", "columns", "options", "message"),
    [
        ("t [s],a", (TIME, SIGNAL), {}, "no column with a unit of an acceleration"),
        ("t [s],a", (TIME, SIGNAL), {"channels": ("b",)}, 'no column "b" (it has t, a)'),
        ("t [s],a", (TIME, SIGNAL), {"channels": ("a",)}, "has no unit; give --unit"),
        ("t [s],a [Hz]", (TIME, SIGNAL), {"channels": ("a",)}, "is a frequency"),
        ("t,a [g]", (TIME, SIGNAL), {}, "--time 't in ms'"),
        ("b,a [g]", (TIME, SIGNAL), {}, "no time column"),
        ("b,a [g]", (TIME, SIGNAL), {"time": "c in s"}, 'no column "c" for the time'),
        ("t [g],a [g]", (TIME, SIGNAL), {}, "is an acceleration; a time is needed"),
        ("t [s],a [g]", (TIME[:9], SIGNAL[:9]), {}, "9 rows are too few"),
        (
            "t [s],a [g]",
            (0 * TIME, SIGNAL),
            {},
            "all 200 time stamps are the same; give --rate '100 Hz'",
        ),
        ("t [s],a [g]", (TIME + (TIME > 1.0) * 9, SIGNAL), {}, "log.csv:103: a gap of 9.01 s"),
    ],
)
def test_bad_logs_are_explained(csv, header, columns, options, message):
    with pytest.raises(InputError) as error:
        read_vibration_log(csv(header, *columns), **options)
    assert message in str(error.value)


def test_cells_that_are_no_numbers_are_found(csv, tmp_path):
    path = csv("t [s],a [g]", TIME, SIGNAL)
    lines = path.read_text().splitlines()
    lines[6] = "0.05,oops"
    path.write_text("\n".join(lines))
    with pytest.raises(
        InputError, match=r'log.csv:7: column "a \[g\]" holds "oops", where a finite'
    ):
        read_vibration_log(path)
    with pytest.raises(InputError, match="no such file"):
        read_vibration_log(tmp_path / "absent.csv")
    (tmp_path / "empty.csv").write_text("")
    with pytest.raises(InputError, match="is empty"):
        read_vibration_log(tmp_path / "empty.csv")
