"""Dates and times of day as time stamps, in logs, vibration logs and recorded drives."""

import numpy as np
import pytest

from mcsim.errors import InputError
from mcsim.logs import ReadOptions, read_log
from mcsim.logs.date_times import nanoseconds
from mcsim.tracks.recorded.block import Columns, Recorded
from mcsim.tracks.recorded.manoeuvre import load_manoeuvre
from mcsim.vibration.log import read_vibration_log

RATE, ROWS = 100.0, 400
SAMPLES = 0.01 * np.random.default_rng(4).standard_normal((ROWS, 3)) + [0.0, 0.0, 9.8]


def clock(t):
    """hh:mm:ss.mmm, t seconds after 10:59:58."""
    s = round((10 * 3600 + 59 * 60 + 58 + t) * 1000) / 1000
    return f"{int(s // 3600) % 24:02d}:{int(s // 60) % 60:02d}:{s % 60:06.3f}"


def write(path, stamp, title="timestamp"):
    rows = [",".join([stamp(i / RATE), *map(repr, row)]) for i, row in enumerate(SAMPLES.tolist())]
    path.write_text("\n".join([f"{title},ax [m/s²],ay [m/s²],az [m/s²]", *rows]) + "\n")
    return path


@pytest.mark.parametrize(
    "stamp",
    [
        lambda t: f"2023-05-01T{clock(t)}Z",
        lambda t: f"2023-05-01 {clock(t)}+02:00",
        lambda t: f"2023-05-01 {clock(t)} +0200",
        lambda t: f"2023-05-01 {clock(t)}".removesuffix(".000"),
        lambda t: f"01.05.2023 {clock(t)}",
        lambda t: f"01-May-2023 {clock(t)}",
        clock,
        # Midnight, with a date and without one.
        lambda t: f"2023-05-0{1 + (t >= 2)} {clock(t + 13 * 3600)}",
        lambda t: clock(t + 13 * 3600),
    ],
)
def test_dates_and_times_are_time_stamps(tmp_path, stamp):
    log = read_log(write(tmp_path / "log.csv", stamp))
    assert log.rate == pytest.approx(RATE, rel=1e-6)
    np.testing.assert_array_equal(log.channels[2].samples, SAMPLES[:, 2])
    assert '"timestamp" as time in date and time' in log.remarks[0]


def test_zones_and_fractions_count():
    """Against Python's own calendar."""
    from datetime import datetime

    texts = ["2024-02-29T23:59:59.123456+05:30", "2024-03-01 00:00:00-01:00"]
    expected = [datetime.fromisoformat(text).timestamp() for text in texts]
    stamps, bad = nanoseconds(texts)
    assert not bad.any()
    np.testing.assert_allclose(stamps * 1e-9, expected, rtol=1e-15)
    others = ["2023-02-30 10:00:00", "10:00", "05/01/2023 10:00:00"]
    assert nanoseconds([*texts, *others])[1].tolist() == [False, False, True, True, True]


def test_what_is_no_time_is_named_with_its_line(tmp_path):
    path = write(tmp_path / "log.csv", lambda t: f"2023-05-01 {clock(t)}")
    lines = path.read_text().splitlines()
    with pytest.raises(InputError, match="in no unit; leave out --units of time"):
        read_log(path, ReadOptions(units="time=s"))
    with pytest.raises(InputError, match="in no unit"):
        read_vibration_log(path, time="timestamp in s")
    path.write_text("\n".join([*lines, lines[-1][:25]]))
    assert len(read_log(path).channels[0].samples) == ROWS
    path.write_text("\n".join([*lines[:350], "soon" + lines[350][23:], *lines[351:]]) + "\n")
    with pytest.raises(InputError, match=r'log.csv:351: .* "soon", where a date and time like'):
        read_log(path)
    write(path, lambda t: f"05/01/2023 {clock(t)}")
    with pytest.raises(InputError, match="no dates and times that are read"):
        read_log(path)


def test_the_other_readers_take_them_too(tmp_path):
    path = write(tmp_path / "log.csv", lambda t: f"2023-05-01T{clock(t)}Z", "Date Time")
    assert read_vibration_log(path).rate == pytest.approx(RATE, rel=1e-6)
    t = np.arange(200) / 10
    rows = [f"2023-05-01T{clock(at)}Z,10.0,{at!r}" for at in t.tolist()]
    drive = tmp_path / "drive.csv"
    drive.write_text("\n".join(["time,speed [m/s],course [deg]", *rows]) + "\n")
    columns = Columns(time="time", speed="speed", course="course")
    track = Recorded(shape="recorded", file="drive.csv", columns=columns, smoothing="1 s")
    assert load_manoeuvre(track, tmp_path).duration == pytest.approx(19.9)
    wrong = columns.model_copy(update={"time": "time in s"})
    with pytest.raises(InputError, match="correct one"):
        load_manoeuvre(track.model_copy(update={"columns": wrong}), tmp_path)
