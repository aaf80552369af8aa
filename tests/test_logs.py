"""Logs of every kind, and what is wrong with them."""

import gzip
import lzma
import sys
from pathlib import Path

import numpy as np
import pytest

from mcsim.characterisation.findings import check_length
from mcsim.errors import InputError
from mcsim.logs import ReadOptions, read_log
from mcsim.units import STANDARD_GRAVITY

RATE, ROWS = 100.0, 400
RNG = np.random.default_rng(1)
TIME = np.arange(ROWS) / RATE
ACCEL = np.column_stack([*(0.01 * RNG.standard_normal((2, ROWS))), 9.8 + np.zeros(ROWS)])
GYRO = 0.001 * RNG.standard_normal((ROWS, 3))
TITLES = ["time (s)", *(f"accel_{a} [m/s^2]" for a in "xyz"), *(f"gyro_{a} (rad/s)" for a in "xyz")]


def write(path: Path, columns, titles=None, delimiter=","):
    rows = [delimiter.join(titles)] if titles else []
    rows += [delimiter.join(f"{float(x)!r}" for x in row) for row in np.column_stack(columns)]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def check(log, accel=ACCEL, gyro=GYRO):
    assert log.rate == pytest.approx(RATE, rel=1e-9)
    found = {channel.name: channel.samples for channel in log.channels}
    for k, axis in enumerate("xyz"):
        if accel is not None:
            np.testing.assert_allclose(found[f"accel_{axis}"], accel[:, k], rtol=1e-12)
        if gyro is not None:
            np.testing.assert_allclose(found[f"gyro_{axis}"], gyro[:, k], rtol=1e-12)


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_csv_with_units_in_its_header(tmp_path, delimiter):
    check(read_log(write(tmp_path / "log.csv", [TIME, ACCEL, GYRO], TITLES, delimiter)))


def test_units_of_the_header_are_converted(tmp_path):
    titles = ["t [ms]", *(f"a{x} (g)" for x in "xyz"), *(f"w{x} (deg/s)" for x in "xyz")]
    columns = [TIME * 1e3, ACCEL / STANDARD_GRAVITY, np.rad2deg(GYRO)]
    check(read_log(write(tmp_path / "log.csv", columns, titles)))


@pytest.mark.parametrize("units", ["s,g,g,g,°/s,°/s,°/s", "accelerometer=g,gyro=deg/s,time=s"])
def test_files_without_a_header_take_everything_from_options(tmp_path, units):
    path = write(tmp_path / "log.csv", [TIME, ACCEL / STANDARD_GRAVITY, np.rad2deg(GYRO)])
    columns = "time,accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z"
    check(read_log(path, ReadOptions(columns=columns, units=units)))


def test_files_without_time_take_the_rate(tmp_path):
    path = write(tmp_path / "log.txt", [GYRO[:, 0], ACCEL[:, 1], GYRO[:, 2]], delimiter=" ")
    options = ReadOptions(rate=RATE, columns="gyro_x,-,gyro_z", units="gyroscope=rad/s")
    log = read_log(path, options)
    assert [channel.name for channel in log.channels] == ["gyro_x", "gyro_z"]
    np.testing.assert_allclose(log.channels[1].samples, GYRO[:, 2])
    assert not log.timing.stamped


def test_a_single_column_is_enough(tmp_path):
    path = write(tmp_path / "one.csv", [GYRO[:, 0]])
    log = read_log(path, ReadOptions(rate=RATE, columns="gyro_z", units="rad/s"))
    assert [channel.name for channel in log.channels] == ["gyro_z"]


def test_columns_are_named_by_their_titles(tmp_path):
    path = write(tmp_path / "log.csv", [TIME, GYRO], ["clock", "p", "q", "r"])
    options = ReadOptions(columns="time=clock,gyro_z=r", units="time=s,gyroscope=rad/s")
    log = read_log(path, options)
    np.testing.assert_allclose(log.channels[0].samples, GYRO[:, 2])


@pytest.mark.parametrize(("ending", "opener"), [(".gz", gzip.open), (".xz", lzma.open)])
def test_compressed_files_are_read_directly(tmp_path, ending, opener):
    plain = write(tmp_path / "log.csv", [TIME, ACCEL, GYRO], TITLES)
    packed = tmp_path / f"log.csv{ending}"
    with opener(packed, "wb") as file:
        file.write(plain.read_bytes())
    check(read_log(packed))


@pytest.mark.parametrize("folder", ["imu0", "mav0/imu0"])
def test_euroc_folders(tmp_path, folder):
    """Nanoseconds since 1970 do not fit into a float; the intervals must survive."""
    make_euroc(tmp_path, folder)
    log = read_log(tmp_path)
    check(log)
    assert log.timing.jitter < 1e-6


def make_euroc(path, folder="imu0"):
    (path / folder).mkdir(parents=True)
    titles = ["#timestamp [ns]", *(f"w_RS_S_{a} [rad s^-1]" for a in "xyz")]
    titles += [f"a_RS_S_{a} [m s^-2]" for a in "xyz"]
    stamps = 1_403_636_579_758_555_392 + np.arange(ROWS, dtype=np.int64) * 10_000_000
    rows = [",".join(titles)]
    for stamp, w, a in zip(stamps, GYRO, ACCEL, strict=True):
        rows.append(",".join([str(stamp), *(repr(float(x)) for x in (*w, *a))]))
    (path / folder / "data.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def make_gnss_ins_sim(path):
    write(path / "accel-0.csv", [ACCEL], [f"accel_{a} (m/s^2)" for a in "xyz"])
    write(path / "gyro-0.csv", [np.rad2deg(GYRO)], [f"gyro_{a} (deg/s)" for a in "xyz"])
    return path


def test_gnss_ins_sim_folders(tmp_path):
    make_gnss_ins_sim(tmp_path)
    with pytest.raises(InputError, match="no time stamps"):
        read_log(tmp_path)
    write(tmp_path / "time.csv", [TIME], ["time (sec)"])
    check(read_log(tmp_path))


@pytest.mark.parametrize("kind", ["ros1", "ros2", "mcap"])
def test_bags(tmp_path, kind):
    path = make_bag(tmp_path, kind, ["/imu"])
    check(read_log(path))


def test_a_bag_of_two_imus_asks_for_a_topic(tmp_path):
    path = make_bag(tmp_path, "ros2", ["/front/imu", "/rear/imu"])
    with pytest.raises(InputError, match="--topic /front/imu"):
        read_log(path)
    check(read_log(path, ReadOptions(topic="/rear/imu")))
    with pytest.raises(InputError, match='no IMU under "/imu"'):
        read_log(path, ReadOptions(topic="/imu"))


def test_bags_without_stamps_in_their_headers_take_the_bags(tmp_path):
    path = make_bag(tmp_path, "ros2", ["/imu"], stamped=False)
    log = read_log(path)
    check(log)
    assert any("arrival" in remark for remark in log.remarks)
    # Or none, and the rate that is stated.
    names = "accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z"
    with pytest.raises(InputError, match="give the sampling rate"):
        read_log(path, ReadOptions(columns=names))
    check(read_log(path, ReadOptions(columns=names, rate=RATE)))


def test_an_accelerometer_and_a_gyroscope_on_two_topics_are_joined(tmp_path):
    path = make_bag(tmp_path, "ros2", ["/b/accel", "/a/gyro"], halves=True)
    check(read_log(path))
    check(read_log(path, ReadOptions(topic="/b/accel,/a/gyro")))
    alone = read_log(path, ReadOptions(topic="/a/gyro"))
    check(alone, accel=None)
    assert len(alone.channels) == 3
    with pytest.raises(InputError, match="holds none of what --columns names"):
        read_log(path, ReadOptions(topic="/a/gyro", columns="time,accel_x"))


def test_channels_of_a_bag_are_left_out_and_its_units_kept(tmp_path):
    path = make_bag(tmp_path, "mcap", ["/imu"])
    log = read_log(path, ReadOptions(columns="time,gyro_y,-", units="gyro=rad/s"))
    assert [channel.name for channel in log.channels] == ["gyro_y"]
    for options in ({"columns": "time,ax"}, {"columns": "time"}, {"units": "accelerometer=g"}):
        with pytest.raises(InputError, match=r"--columns|--units"):
            read_log(path, ReadOptions(**options))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["ros1", "ros2", "mcap"])
def test_damaged_bags_end_in_one_sentence(tmp_path, kind):
    """Bits flipped, lengths of nonsense, parts missing, another kind of file."""
    path = make_bag(tmp_path, kind, ["/imu"])
    path = next(path.glob("*.db3")) if kind == "ros2" else path
    whole, rng = path.read_bytes(), np.random.default_rng(7)
    damaged = tmp_path / f"damaged{path.suffix}"
    contents = [b"", b"x", b"time [s],gx\n0,1\n", whole[: len(whole) // 2], whole[:9]]
    for _ in range(40):
        content = bytearray(whole)
        for at in rng.integers(0, 600 if rng.random() < 0.5 else len(whole), 4):
            content[at : at + 4] = bytes(rng.choice([0, 127, 255], 4).astype(np.uint8))
        contents.append(bytes(content))
    refusals = []
    for content in contents:
        damaged.write_bytes(content)
        try:
            read_log(damaged)
        except InputError as error:
            refusals.append(str(error))
    assert len(refusals) > 10
    assert not any("\n" in message for message in refusals)


def test_metadata_of_a_bag_may_be_nonsense(tmp_path):
    path = make_bag(tmp_path, "ros2", ["/imu"])
    text = (path / "metadata.yaml").read_text()
    contents = ["", "[", "- 1", "&a [*a, *b]", "rosbag2_bagfile_information: 7"]
    contents += [
        text.replace(*change)
        for change in (
            ("version: 9", "version: [9]"),
            ("message_count", "x"),
            ("sqlite3", "none"),
            ("nanoseconds: ", "nanoseconds: a"),
        )
    ]
    for content in contents:
        (path / "metadata.yaml").write_text(content)
        with pytest.raises(InputError, match="not a bag that can be read"):
            read_log(path)


def test_bags_without_rosbags_name_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    (tmp_path / "log.bag").write_bytes(b"")
    with pytest.raises(InputError, match=r"pip install 'mcsim\[bags\]'"):
        read_log(tmp_path / "log.bag")


def make_bag(folder, kind, topics, stamped=True, halves=False):
    rosbags = pytest.importorskip("rosbags")
    assert rosbags
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    first = kind == "ros1"
    store = get_typestore(Stores.ROS1_NOETIC if first else Stores.ROS2_HUMBLE)
    path = folder / ("log.bag" if first else "log")
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    writer = Writer1(path) if first else Writer2(path, version=9, storage_plugin=plugin)
    types = store.types
    name = "sensor_msgs/msg/Imu"
    vector, header = types["geometry_msgs/msg/Vector3"], types["std_msgs/msg/Header"]
    stamp, turn = types["builtin_interfaces/msg/Time"], types["geometry_msgs/msg/Quaternion"]
    nothing = np.zeros(9)
    with writer as bag:
        for topic in topics:
            connection = bag.add_connection(topic, name, typestore=store)
            for k in range(ROWS):
                ns = 10_000_000 * k
                at = stamp(sec=ns // 10**9, nanosec=ns % 10**9) if stamped else stamp(0, 0)
                accel = ACCEL[k] * (not halves or "accel" in topic)
                gyro = GYRO[k] * (not halves or "gyro" in topic)
                head = {"stamp": at, "frame_id": "imu"} | ({"seq": k} if first else {})
                message = types[name](
                    header(**head), turn(0.0, 0.0, 0.0, 1.0), nothing, vector(*map(float, gyro)),
                    nothing, vector(*map(float, accel)), nothing,
                )  # fmt: skip
                write_one = store.serialize_ros1 if first else store.serialize_cdr
                bag.write(connection, ns, write_one(message, name))
    return next(path.glob("*.mcap")) if kind == "mcap" else path


def test_gaps_duplicates_and_jitter_are_told(tmp_path):
    rng = np.random.default_rng(2)
    n = 5000
    time = np.arange(n) / RATE + 0.0015 * rng.standard_normal(n).clip(-2, 2)
    ramp = np.arange(n) / n
    keep = np.ones(n, bool)
    keep[2000:2003] = False
    time, ramp = np.insert(time[keep], 100, time[99]), np.insert(ramp[keep], 100, ramp[99])
    log = read_log(write(tmp_path / "log.csv", [time, ramp], ["t [s]", "gx [rad/s]"]))
    assert (log.timing.duplicates, log.timing.missing) == (1, 3)
    assert log.timing.jitter == pytest.approx(0.0015 * np.sqrt(2) * RATE, rel=0.15)
    # What is missing is bridged: the ramp goes on.
    np.testing.assert_allclose(log.channels[0].samples, np.arange(n) / n, atol=1e-9)
    assert any("bridged" in note for note in log.notes)


def test_a_long_gap_leaves_the_longer_part(tmp_path):
    time = np.concatenate([np.arange(100) / RATE, 50 + np.arange(300) / RATE])
    log = read_log(write(tmp_path / "log.csv", [time, GYRO[:, 0]], ["t [s]", "gx [rad/s]"]))
    np.testing.assert_allclose(log.channels[0].samples, GYRO[100:, 0])
    assert any("longest stretch" in note for note in log.notes)


def test_start_and_end_cut(tmp_path):
    path = write(tmp_path / "log.csv", [TIME, ACCEL, GYRO], TITLES)
    log = read_log(path, ReadOptions(start=1.0, end=3.0))
    np.testing.assert_allclose(log.channels[0].samples, ACCEL[100:300, 0])
    with pytest.raises(InputError, match="leave nothing"):
        read_log(path, ReadOptions(start=5.0))


def replaced(values, row, text):
    rows = [[repr(float(x)) for x in line] for line in values]
    rows[row][1] = text
    return "\n".join(["t [s],gx [rad/s]", *(",".join(r) for r in rows)])


@pytest.mark.parametrize(
    ("content", "options", "message"),
    [
        ("", {}, "is empty"),
        ("t [s],gx [rad/s]\n", {}, "header and no rows"),
        ("a,b\n1,2\n3,4", {}, "no accelerometer or gyroscope column"),
        ("1,2\n3,4\n", {}, "has no header"),
        ("t [s],gx\n0,1\n1,2\n", {}, r'"gx" \(gyro_x\) has no unit'),
        ("t [s],gx [furlong]\n0,1\n1,2\n", {}, 'unknown unit "furlong"'),
        ("t [s],gx [m/s^2]\n0,1\n1,2\n", {}, "is an acceleration"),
        ("t [s],gx [rad/s],wx [rad/s]\n0,1,1\n1,2,2\n", {}, "two columns are gyro_x"),
        ("gx [rad/s],gy [rad/s]\n0,1\n1,2\n", {}, "no time stamps; give the sampling rate"),
        (replaced(np.column_stack([TIME, TIME]), 7, "oops"), {}, r':9: column "gx.*holds "oops"'),
        (replaced(np.column_stack([TIME, TIME]), 7, "nan"), {}, ":9: column .* nothing"),
        (replaced(np.column_stack([TIME, TIME]), 7, ""), {}, ":9: column .* nothing"),
        (replaced(np.column_stack([-np.cumsum(TIME % 0.05 + 0.01), TIME]), 0, "0"), {},
         "the time does not go forward; give the sampling rate, --rate 100"),
        (replaced(np.column_stack([TIME, TIME]), 0, "0"), {"rate": 50.0}, "time stamps say 100 Hz"),
        (replaced(np.column_stack([TIME * 1e9, TIME]), 0, "0"), {}, "is their unit right"),
        (replaced(np.column_stack([TIME // 0.5, TIME]), 0, "0"), {}, "too coarse"),
        (replaced(np.column_stack([TIME * 1e-3, TIME]), 0, "0"), {}, "say 100000 Hz, which no"),
        (replaced(np.column_stack([TIME * 1e-3, TIME]), 0, "0"), {"rate": 100.0},
         "agree if the unit of time is 1000 times larger"),
        (replaced(np.column_stack([TIME * 1e6, TIME]), 0, "0"), {"rate": 100.0},
         "agree if the unit of time is 1000000 times smaller"),
        (replaced(np.column_stack([TIME, TIME]), 3, "1e300"), {}, "reaches 1e.300 rad/s, beyond"),
        (replaced(np.column_stack([TIME, TIME]), 0, "oops"), {}, ':2: column .* holds "oops"'),
        (replaced(np.column_stack([TIME, TIME]), 5, "\N{MINUS SIGN}x"), {}, ":7: column"),
        ("# by hand\n\n" + replaced(np.column_stack([TIME, TIME]), 7, "oops"), {}, ":11: column"),
        ("t [s];gx [rad/s]\n0.5;1.5\n0,6;1,6\n", {}, ":3: column .* with a decimal point"),
        ("t [s],gx [rad/s]\n0,1\n", {}, "1 row: too few for a rate"),
        ("t [s],gx [rad/s]\n" + 9 * "0,1\n", {}, "all 9 time stamps are the same"),
        ("gx [rad/s],gy [rad/s]\n0,1\n1,2\n", {"rate": -1.0}, "--rate -1 Hz"),
        ("1,2\n3,4\n", {"rate": 1.0, "columns": "gyro_x"}, "has 2 columns, --columns names 1"),
        ("1,2\n3,4\n", {"rate": 1.0, "columns": "gyro_x,foo"}, '"foo" is none of'),
        ("1,2\n3,4\n", {"columns": "gyro_x,-", "units": "s"}, "--units holds 1"),
        ("1,2\n3,4\n", {"columns": "gyro_x,-", "units": "foo=s"}, '"foo" is none of'),
    ],
)  # fmt: skip
def test_bad_files_end_in_one_message(tmp_path, content, options, message):
    path = tmp_path / "log.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match=message) as error:
        read_log(path, ReadOptions(**options))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("scale", "hint"), [(1e3, "1000 times smaller"), (2e-3, "times larger")])
def test_unusual_rates_are_doubted(tmp_path, scale, hint):
    """Milliseconds under a header of s, and seconds under one of ms."""
    path = write(tmp_path / "log.csv", [TIME * scale, GYRO[:, 0]], ["t [s]", "gx [rad/s]"])
    log = read_log(path)
    assert any(hint in note for note in log.notes)
    with pytest.raises(InputError, match=hint):
        check_length(log)
    # Control: a rate that is confirmed is not doubted.
    assert not read_log(path, ReadOptions(rate=RATE / scale)).notes


def test_cells_may_hold_real_minus_signs_and_lines_comments(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("# by hand\nt [s],gx [rad/s]\n0,\N{MINUS SIGN}1\n# pause\n1,-2\n\n2,3\n")
    log = read_log(path)
    np.testing.assert_array_equal(log.channels[0].samples, [-1.0, -2.0, 3.0])


@pytest.mark.parametrize("pack", [gzip.compress, lzma.compress])
def test_truncated_archives_are_refused(tmp_path, pack):
    whole = pack(
        write(tmp_path / "plain.csv", [TIME, GYRO[:, 0]], ["t [s]", "gx [rad/s]"]).read_bytes()
    )
    ending = ".gz" if pack is gzip.compress else ".xz"
    for part in (len(whole) // 2, 20):
        path = tmp_path / f"cut.csv{ending}"
        path.write_bytes(whole[:part])
        with pytest.raises(InputError, match=r"cannot be read as a table \(Compressed file ended"):
            read_log(path)


@pytest.mark.parametrize(
    ("scale", "unit", "message"),
    [
        (1 / STANDARD_GRAVITY, "m/s^2", "gravity in g; state it by --units accelerometer=g"),
        (1e3 / STANDARD_GRAVITY, "m/s^2", "gravity in mg"),
        (1.0, "g", "gravity in m/s²"),
        (1e3, "m/s^2", "gravity in mm/s²"),
    ],
)
def test_a_header_that_lies_about_gravity(tmp_path, scale, unit, message):
    titles = ["time (s)", *(f"accel_{a} [{unit}]" for a in "xyz")]
    path = write(tmp_path / "log.csv", [TIME, ACCEL * scale], titles)
    with pytest.raises(InputError, match=message):
        read_log(path)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_log(tmp_path / "none.csv")
    with pytest.raises(InputError, match="holds no log that is known"):
        read_log(tmp_path)
    for name, content in (("a.csv.xz", b"no xz"), ("a.csv.gz", b"no gz"), ("a.csv", b"\xff\xfe1")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=r"cannot be read|UTF-8"):
            read_log(tmp_path / name)
    (tmp_path / "a.bag").write_bytes(b"no bag")
    with pytest.raises(InputError, match="not a bag"):
        read_log(tmp_path / "a.bag")


LABVIEW = """LabVIEW Measurement\t
Decimal_Separator\t.
***End_of_Header***\t
\t
Channels\t3\t\t\t
Samples\t400\t400\t400\t
Y_Unit_Label\tg\tg\tg\t
X_Dimension\tTime\tTime\tTime\t
X0\t0.0E+0\t0.0E+0\t0.0E+0\t
***End_of_Header***\t\t\t\t
time [s]\taccel_x [m/s^2]\taccel_y [m/s^2]\taccel_z [m/s^2]\tComment
"""


@pytest.mark.parametrize("end", ["", "\t"])
def test_a_preamble_with_numbers_is_no_row(tmp_path, end):
    path = write(tmp_path / "log.lvm", [TIME, ACCEL], delimiter="\t")
    rows = path.read_text().replace("\n", f"{end}\n")
    path.write_text(LABVIEW + rows)
    check(read_log(path), gyro=None)


def test_stamps_of_a_serial_monitor_are_left_aside(tmp_path):
    path = write(tmp_path / "log.txt", [TIME, ACCEL], TITLES[:4])
    lines = path.read_text().splitlines()
    path.write_text("".join(f"10:00:{i // 10:02d}.123 -> {x}\n" for i, x in enumerate(lines)))
    check(read_log(path), gyro=None)


def test_a_counter_beside_a_stated_rate_is_set_aside(tmp_path):
    titles = ["t_us", *TITLES[1:4]]
    path = write(tmp_path / "log.csv", [TIME * 1e6 % 65536, ACCEL], titles)
    with pytest.raises(InputError, match="--rate sets stamps that are no times aside"):
        read_log(path)
    check(read_log(path, ReadOptions(rate=RATE)), gyro=None)


@pytest.mark.parametrize(
    ("titles", "units"),
    [
        (["iTOW [ms]", "accSmooth[0]", "accSmooth[1]", "accSmooth[2]"], "accelerometer=m/s^2"),
        (["TimeStartup [ms]", *(f"UncompAccel_{a}" for a in "XYZ")], "accelerometer=m/s^2"),
        (["time", *(f"accelerometeruncalibrated_{a}" for a in "xyz")],
         "accelerometer=m/s^2,time=ms"),
        (["field.header.stamp", *(f"field.linear_acceleration.{a}" for a in "xyz")],
         "accelerometer=m/s^2,time=ms"),
    ],
)  # fmt: skip
def test_names_of_other_loggers(tmp_path, titles, units):
    path = write(tmp_path / "log.csv", [TIME * 1e3, ACCEL], titles)
    check(read_log(path, ReadOptions(units=units)), gyro=None)


def test_the_advice_about_two_times_names_one_of_them(tmp_path):
    titles = ["date", "accelTimestamp [s]", "gyroTimestamp [s]", *TITLES[1:]]
    path = write(tmp_path / "log.csv", [0 * TIME, TIME, TIME, ACCEL, GYRO], titles)
    with pytest.raises(InputError, match="two columns are time") as caught:
        read_log(path)
    advice = str(caught.value).split("--columns '")[1].rstrip("'")
    check(read_log(path, ReadOptions(columns=advice)))


def test_a_title_of_many_characters_takes_no_time(tmp_path):
    path = write(tmp_path / "log.csv", [TIME, ACCEL], [*TITLES[:3], f"accel_z [{'(' * 40_000}"])
    with pytest.raises(InputError, match="has no unit"):
        read_log(path)
