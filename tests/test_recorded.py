"""Recorded drives: made here with known truth, jitter, repeats and noise."""

import math
from pathlib import Path

import numpy as np
import pytest

from mcsim import Scenario
from mcsim.errors import InputError
from mcsim.systems import problem_of
from mcsim.tracks import drive_of
from mcsim.tracks.recorded.block import Columns, Recorded
from mcsim.tracks.recorded.manoeuvre import load_manoeuvre
from mcsim.trajectory.geodesy import local_position

RADIUS, SPEED = 60.0, 12.0
EARTH = 6371e3
COLUMNS = {"time": "t in ms", "x": "x in m", "y": "y in m"}


def circle(t):
    """A vehicle on a circle, heading north-east at first."""
    angle = SPEED * t / RADIUS + math.pi / 4
    return RADIUS * np.sin(angle), -RADIUS * np.cos(angle), angle


def write_circle(folder: Path, noise: float = 0.0, fix_every: int = 5) -> Path:
    """50 Hz rows with jittery stamps; positions repeat between fixes, as receivers do."""
    rng = np.random.default_rng(3)
    t = np.arange(0, 20, 0.02) + rng.uniform(-0.008, 0.008, 1000)
    t[0] = 0.0
    held = t[(np.arange(1000) // fix_every) * fix_every]
    x, y, angle = circle(held)
    fix_noise = noise * rng.standard_normal((2, 1000 // fix_every)).repeat(fix_every, axis=1)
    x, y = x + fix_noise[0], y + fix_noise[1]
    _, _, angle = circle(t)
    compass = np.degrees(np.pi / 2 - angle) % 360
    path = folder / "drive.csv"
    rows = ["t,x,y,course,speed,note"]
    rows += [
        f"{1e3 * a + 5e4:.4f},{b:.6f},{c:.6f},{d:.6f},{3.6 * SPEED},ok"
        for a, b, c, d in zip(t, x, y, compass, strict=True)
    ]
    path.write_text("\n".join(rows) + "\n")
    return path


def recorded(folder: Path, **trajectory) -> Scenario:
    return Scenario.from_dict(
        {
            "case": "planar",
            "trajectory": {
                "shape": "recorded",
                "file": "drive.csv",
                "columns": COLUMNS,
                "smoothing": "0.3 s",
                **trajectory,
            },
            "sensors": {"rate": "100 Hz", "accelerometer": "LSM330DL", "gyroscope": "LSM330DL"},
            "monte_carlo": {"realizations": 100},
        },
        folder=folder,
    )


def test_a_noisy_jittery_record_gives_back_its_circle(tmp_path):
    write_circle(tmp_path, noise=0.1)
    drive = drive_of(recorded(tmp_path).base.trajectory, tmp_path)
    t = np.linspace(2, 17, 500)
    motion = drive.motion(t)
    # 10 Hz fixes of 0.1 m, smoothed over 0.3 s: speed to some 0.1 m/s, yaw rate to some 1 °/s.
    assert np.mean(motion.speed) == pytest.approx(SPEED, rel=0.005)
    assert np.std(motion.speed) < 0.3
    assert np.mean(motion.left) == pytest.approx(SPEED**2 / RADIUS, rel=0.02)
    assert np.mean(motion.yaw_rate) == pytest.approx(SPEED / RADIUS, rel=0.02)


def test_the_undisturbed_reconstruction_returns_to_the_smoothed_track(tmp_path):
    write_circle(tmp_path, noise=0.1)
    s = recorded(tmp_path).with_values({"reconstruction.integration": "trapezoidal"})
    along, across, *_ = problem_of(s.base, tmp_path).method_errors()
    # Half a kilometre in 20 s; sampling and integration alone lose less than a centimetre.
    assert math.hypot(along, across) < 0.01


def test_speed_and_course_serve_instead_of_positions(tmp_path):
    write_circle(tmp_path)
    s = recorded(
        tmp_path,
        columns={"time": "t in ms", "speed": "speed in km/h", "course": "course in deg"},
    )
    drive = drive_of(s.base.trajectory, tmp_path)
    motion = drive.motion(np.linspace(2, 17, 100))
    np.testing.assert_allclose(motion.speed, SPEED, rtol=2e-3)
    np.testing.assert_allclose(motion.yaw_rate, SPEED / RADIUS, rtol=2e-2)


def test_a_recorded_heading_gives_the_side_slip(tmp_path):
    write_circle(tmp_path)
    s = recorded(tmp_path, columns={**COLUMNS, "heading": "course in deg"})
    motion = drive_of(s.base.trajectory, tmp_path).motion(np.linspace(2, 17, 100))
    slip = np.angle(np.exp(1j * (motion.course - motion.heading)))
    # Positions are held for up to 80 ms after their fix, so the course lags the heading a little.
    assert np.abs(slip).max() < math.radians(3)


def test_start_and_duration_cut_the_drive(tmp_path):
    write_circle(tmp_path)
    s = recorded(tmp_path, start="5 s", duration="4 s")
    drive = drive_of(s.base.trajectory, tmp_path)
    assert drive.manoeuvre.duration == pytest.approx(4.0, abs=0.05)


@pytest.mark.parametrize("first", [0, 12345, 1_700_000_000_000])
def test_rows_on_the_ends_belong_to_the_cut(tmp_path, first):
    """Stamps in ms whose differences are off by rounding: 0.4 s to 2.9 s are 126 rows."""
    stamps = first + 20 * np.arange(219)
    place = 16.0 * (stamps - first) / 1000.0
    rows = "".join(f"{t}.000,{x:.6f},0\n" for t, x in zip(stamps, place, strict=True))
    (tmp_path / "drive.csv").write_text("t,x,y\n" + rows)
    columns = {"time": "t in ms", "x": "x in m", "y": "y in m"}
    s = recorded(tmp_path, columns=columns, start="0.4 s", duration="2.5 s")
    drive = drive_of(s.base.trajectory, tmp_path)
    assert drive.manoeuvre.duration == pytest.approx(2.5, abs=1e-5)


def test_geographic_positions_become_metres():
    """One minute of arc is a nautical mile (1852 m) to half a percent."""
    latitude = np.radians([50.0, 50.0 + 1 / 60])
    x, y = local_position(latitude, np.radians([13.0, 13.0]))
    assert y[1] == pytest.approx(1852, rel=5e-3)
    assert x[1] == 0.0
    x, _ = local_position(np.radians([50.0, 50.0]), np.radians([13.0, 13.0 + 1 / 60]))
    assert x[1] == pytest.approx(1852 * math.cos(math.radians(50)), rel=5e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: text.replace("t,x,y", "t,x,z"), 'no column "y" for y'),
        (lambda text: text.replace("\n5", "\nfive", 3), "where a finite number is needed"),
        (lambda _: "t,x,y\n1,2,3\n", "rows; at least 8 are needed"),
        (lambda _: "", "is empty"),
    ],
)
def test_bad_files_are_explained(tmp_path, change, message):
    path = write_circle(tmp_path)
    path.write_text(change(path.read_text()))
    with pytest.raises(InputError, match=message):
        drive_of(recorded(tmp_path).base.trajectory, tmp_path)


def test_a_clock_that_errs_is_mended(tmp_path):
    """Rows out of order, a clock set back, and one that begins anew give the same drive."""
    path = write_circle(tmp_path)
    header, *lines = path.read_text().splitlines()
    whole = drive_of(recorded(tmp_path).base.trajectory, tmp_path).manoeuvre
    t = np.linspace(0.5, whole.duration - 0.5, 50)

    def moved(line, by, from_ms):
        time, _, rest = line.partition(",")
        return f"{float(time) + (by if float(time) > from_ms else 0.0)!r},{rest}"

    swapped = [*lines[:9], lines[10], lines[9], *lines[11:]]
    back = [moved(line, -3210.0, 55_000.0) for line in lines]
    anew = [moved(line, -65536.0, 55_000.0) for line in lines]
    told = ("1 of 1000 time stamps are no later", "set back by", "begins anew")
    for rows, words in zip((swapped, back, anew), told, strict=True):
        path.write_text("\n".join([header, *rows]))
        mended = load_manoeuvre(recorded(tmp_path).base.trajectory, tmp_path)
        # Two samples: the vehicle goes 0.25 m in one.
        assert np.abs(mended.motion(t).along - whole.motion(t).along).max() < 0.5
        assert any(words in note for note in mended.notes), (words, mended.notes)
    assert not any("clock" in note or "stamps" in note for note in whole.notes)
    # Control: taken as the file says, the drive would be shorter.
    assert mended.duration == pytest.approx(whole.duration, abs=0.03)


def test_a_clock_that_stands_still_is_explained_with_its_line(tmp_path):
    path = write_circle(tmp_path)
    header, *lines = path.read_text().splitlines()
    path.write_text("\n".join([header, *("7" + line[line.index(",") :] for line in lines)]))
    with pytest.raises(InputError, match=r"drive.csv:3: the time runs backwards or stands still"):
        drive_of(recorded(tmp_path).base.trajectory, tmp_path)


def drive_with(folder, change):
    folder.mkdir(exist_ok=True)
    path = write_circle(folder)
    path.write_text(change(path.read_text()))
    s = recorded(folder, columns={"time": "t in ms", "speed": "speed in km/h", "course": "course"})
    text = path.read_text().replace(",course,", ",course [deg],")
    path.write_text(text)
    return drive_of(s.base.trajectory, folder)


def commas(text):
    return text.replace(",", ";").replace(".", ",")


def test_drives_are_read_like_logs(tmp_path):
    """Any delimiter, decimal commas, comments; the header's unit where the scenario has none."""
    plain = drive_with(tmp_path, str).motion(np.array([5.0]))
    for i, change in enumerate(
        [
            lambda text: text.replace(",", "\t").replace("\tcourse\t", "\tcourse [deg]\t"),
            lambda text: "# made by hand\n\n" + text.replace("\nx", "\n# pause\nx"),
            lambda text: commas(text).replace(";course;", ";course [deg];"),
        ]
    ):
        other = drive_with(tmp_path / str(i), change).motion(np.array([5.0]))
        np.testing.assert_allclose(other.along, plain.along, rtol=1e-12)


def unknown_rows(first, last, text="-1"):
    def change(whole):
        lines = whole.splitlines()
        for i in range(first + 1, last + 1):
            t, x, y, _, _, note = lines[i].split(",")
            lines[i] = f"{t},{x},{y},{text},{text},{note}"
        return "\n".join(lines) + "\n"

    return change


@pytest.mark.parametrize("text", ["-1", "", "nan"])
def test_unknown_is_unknown(tmp_path, text):
    """Within two seconds of a circle without speed and course the truth is still the circle."""
    drive = drive_with(tmp_path, unknown_rows(400, 450, text))
    motion = drive.motion(np.linspace(2, 17, 100))
    np.testing.assert_allclose(motion.speed, SPEED, rtol=5e-3)
    assert any("50 of 1000 values are unknown" in note for note in drive.manoeuvre.notes)
    # At the beginning there is nothing to be bridged: the drive begins later.
    drive = drive_with(tmp_path / "begin", unknown_rows(0, 100, text))
    assert drive.manoeuvre.duration == pytest.approx(18.0, abs=0.1)
    assert any("begins 2 s later" in note for note in drive.manoeuvre.notes)
    with pytest.raises(InputError, match="too long to be bridged"):
        drive_with(tmp_path / "long", unknown_rows(300, 700, text))


def test_speeds_are_not_negative_and_units_agree(tmp_path):
    with pytest.raises(InputError, match=r"drive.csv:12: .* where a speed that is not"):
        drive_with(tmp_path, unknown_rows(10, 12, "-3"))
    write_circle(tmp_path)
    path = tmp_path / "drive.csv"
    path.write_text(path.read_text().replace("t,x", "t [s],x", 1))
    with pytest.raises(InputError, match="correct one"):
        drive_of(recorded(tmp_path).base.trajectory, tmp_path)


def test_a_stated_value_is_unknown(tmp_path):
    path = write_circle(tmp_path)
    path.write_text(unknown_rows(400, 420, "999")(path.read_text()))
    s = recorded(tmp_path, unknown=999, columns={**COLUMNS, "heading": "course in deg"})
    drive = drive_of(s.base.trajectory, tmp_path)
    assert any(
        "heading: 20 of 1000 values are unknown (empty or 999)" in n for n in drive.manoeuvre.notes
    )
    motion = drive.motion(np.linspace(2, 17, 100))
    np.testing.assert_allclose(motion.yaw_rate, SPEED / RADIUS, rtol=5e-2)


GEOGRAPHIC = Columns(time="t", latitude="lat", longitude="lon")
POLAR = Columns(time="t", speed="v", course="c")


def fixes(folder, rows, header):
    (folder / "gps.csv").write_text("\n".join([header, *rows]) + "\n")


@pytest.mark.parametrize(
    ("columns", "header", "row", "unknown"),
    [
        (GEOGRAPHIC, "t [s],lat [deg],lon [deg]", ("48.0{:04d}", "11.0", "0.0", "0.0"), 0.0),
        (POLAR, "t [s],v [m/s],c [deg]", ("10.{:04d}", "90", "999.9", "999.9"), 999.9),
        (POLAR, "t [s],v [m/s],c [deg]", ("10.{:04d}", "90", "10", "655.35"), 655.35),
    ],
)
@pytest.mark.parametrize("at", [range(2), range(20, 23)])
def test_what_no_vehicle_does_is_not_driven(tmp_path, columns, header, row, unknown, at):
    """Values that stand for unknown are named with their line, and the advice works."""
    a, b, no_a, no_b = row
    rows = [
        f"{i / 10},{no_a},{no_b}" if i in at else f"{i / 10},{a.format(i)},{b}" for i in range(60)
    ]
    fixes(tmp_path, rows, header)
    track = Recorded(shape="recorded", file="gps.csv", columns=columns, smoothing="1 s")
    with pytest.raises(InputError, match=rf"gps.csv:\d+: .*`unknown: {unknown:g}`"):
        load_manoeuvre(track, tmp_path)
    drive = load_manoeuvre(track.model_copy(update={"unknown": unknown}), tmp_path)
    motion = drive.motion(np.linspace(0.0, drive.duration, 50))
    assert np.abs(motion.forward).max() < 5.0


def test_digits_of_a_clock_are_no_seconds(tmp_path):
    """NMEA's hhmmss leaves out 40 s at each minute."""
    seconds = 59 * 60 + 50 + np.arange(100) / 5
    digits = [f"{10000 * (s // 3600) + 100 * (s // 60 % 60) + s % 60:.1f}" for s in seconds - 600]
    fixes(tmp_path, [f"{d},10,90" for d in digits], "t [s],v [m/s],c [deg]")
    track = Recorded(shape="recorded", file="gps.csv", columns=POLAR, smoothing="1 s")
    with pytest.raises(InputError, match="times as digits, hhmmss"):
        load_manoeuvre(track, tmp_path)
    # Control: plain seconds beyond a hundred are none.
    fixes(tmp_path, [f"{90 + i / 5},10,90" for i in range(100)], "t [s],v [m/s],c [deg]")
    assert load_manoeuvre(track, tmp_path).duration == pytest.approx(19.8)


def test_a_missing_file_is_explained(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        drive_of(recorded(tmp_path).base.trajectory, tmp_path)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"time": "t in ms"}, "exactly one pair"),
        ({"time": "t in ms", "x": "x in m"}, "`y` is missing"),
        ({**COLUMNS, "speed": "v in m/s", "course": "c in deg"}, "exactly one pair"),
        ({**COLUMNS, "time": "t"}, "has no unit"),
        ({**COLUMNS, "time": "t in m"}, "a time is needed"),
    ],
)
def test_bad_columns_are_explained(tmp_path, columns, message):
    write_circle(tmp_path)
    with pytest.raises(InputError, match=message):
        drive_of(recorded(tmp_path, columns=columns).base.trajectory, tmp_path)


def test_delimiters_at_the_end_of_rows_do_not_shift_columns(tmp_path):
    path = write_circle(tmp_path)
    header, *rows = path.read_text().splitlines()
    plain = drive_of(recorded(tmp_path).base.trajectory, tmp_path).motion(np.array([5.0]))
    other = tmp_path / "other"
    other.mkdir()
    (other / "drive.csv").write_text("\n".join([header, *(row + "," for row in rows)]))
    shifted = drive_of(recorded(other).base.trajectory, other).motion(np.array([5.0]))
    assert shifted.along[0] == plain.along[0]


def test_columns_of_one_name_are_refused(tmp_path):
    path = write_circle(tmp_path)
    path.write_text(path.read_text().replace("t,x,y", "t,x,x", 1))
    columns = {"time": "t in ms", "x": "x in m", "y": "x in m"}
    with pytest.raises(InputError, match="occurs twice"):
        drive_of(recorded(tmp_path, columns=columns).base.trajectory, tmp_path)


def test_impossible_latitudes_are_refused(tmp_path):
    path = write_circle(tmp_path)
    columns = {"time": "t in ms", "latitude": "course in °", "longitude": "x in °"}
    with pytest.raises(InputError, match=r"drive.csv:\d+: .*an angle within"):
        drive_of(recorded(tmp_path, columns=columns).base.trajectory, tmp_path)
    assert path.exists()


def test_the_date_line_is_no_jump():
    east, _ = local_position(np.zeros(3), np.unwrap(np.radians([179.9999, 180.0, -179.9999])))
    assert east[-1] == pytest.approx(2 * 11.13, rel=1e-2)
