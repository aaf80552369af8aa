"""Tables as loggers and people write them: one reader, and what it says of them."""

import numpy as np
import pytest

from mcsim.calibration import read_amplitudes, read_six_positions
from mcsim.errors import InputError, UnitError
from mcsim.logs import ReadOptions, read_log
from mcsim.logs.cells import Notation, notation_of, number
from mcsim.logs.csv_file import open_csv
from mcsim.logs.formats import read_table
from mcsim.logs.names import meaning_of
from mcsim.logs.titles import factor_of, split_title
from mcsim.units import KINDS, STANDARD_GRAVITY
from mcsim.vibration.log import read_vibration_log

ROWS = 100
RNG = np.random.default_rng(4)
TIME = np.arange(ROWS) * 0.02
ACCEL = np.column_stack([0.1 + TIME, -1234.5678 + RNG.standard_normal(ROWS), 9.8 - TIME])
TITLES = [
    "Time (s)", "Acceleration x (m/s^2)", "Acceleration y (m/s^2)", "Acceleration z (m/s^2)",
]  # fmt: skip


def point(value):
    return f"{value:.6f}"


def comma(value):
    return point(value).replace(".", ",")


def comma_exponent(value):
    return f"{value:.9E}".replace(".", ",")


def grouped(value):
    return f"{value:,.6f}"


def grouped_comma(value):
    return grouped(value).translate(str.maketrans(",.", ".,"))


def quoted(write):
    return lambda value: f'"{write(value)}"'


def table(write=point, sep=",", header=None):
    rows = [sep.join(map(write, row)) for row in np.column_stack([TIME, ACCEL])]
    return "\n".join([sep.join(TITLES) if header is None else header, *rows]) + "\n"


UNIT_ROW = "Time;AccX;AccY;AccZ\n[s];[m/s²];[m/s²];[m/s²]"
PLAIN = table()
VARIANTS = {
    "quoted header": table(header=",".join(f'"{title}"' for title in TITLES)),
    "all quoted": table(quoted(point), header=",".join(f'"{title}"' for title in TITLES)),
    "semicolon": table(sep=";"),
    "tab": table(sep="\t"),
    "pipe": table(sep="|"),
    "blanks": table(sep="  "),
    "decimal comma": table(comma, ";"),
    "decimal comma, exponents": table(comma_exponent, ";"),
    "decimal comma, tabs": table(comma, "\t"),
    "decimal comma, blanks": table(comma, "  "),
    "decimal comma, quoted": table(quoted(comma)),
    "thousands": table(grouped, ";"),
    "thousands, quoted": table(quoted(grouped)),
    "thousands, decimal comma": table(grouped_comma, ";"),
    "thousands, apostrophe": table(lambda v: grouped(v).replace(",", "'"), ";"),
    "preamble": "Device;Phone\nRate;50 Hz\n\n" + table(comma, ";"),
    "slashes": "// Start: Unknown\n// Rate: 50.0Hz\n" + PLAIN,
    "sep line": "sep=;\n\n" + table(point, ";"),
    "commented header": "# " + PLAIN,
    "units in a second row": table(comma, ";", UNIT_ROW),
    "groups of titles": table(header="Time (s),Accelerometer (m/s²),,\n,X,Y,Z"),
    "empty column": PLAIN.replace(",", ",,").replace("Time (s),,", "Time (s),SampleTimeFine,")
    .replace("x (m/s^2),,", "x (m/s^2),A,").replace("y (m/s^2),,", "y (m/s^2),B,"),
    "delimiter at the end": PLAIN.replace("\n", ",\n"),
    "delimiter at the end of rows": PLAIN.replace("\n", ",\n").replace(",\n", "\n", 1),
    "index": "\n".join(
        f"{i - 1 if i else ''},{line}" for i, line in enumerate(PLAIN.split("\n")[:-1])
    ),
    "text column": PLAIN.replace("\n", ",walking\n").replace(",walking", ",label", 1),
    "text first": "\n".join(
        f"{'2021-03-04 12:00:00' if i else 'date'},{line}"
        for i, line in enumerate(PLAIN.split("\n")[:-1])
    ),
    "CRLF": PLAIN.replace("\n", "\r\n"),
    "CR": PLAIN.replace("\n", "\r"),
    "no end": PLAIN[:-1],
    "empty lines": PLAIN.replace("\n", "\n\n") + " \n\t\n",
    "comments": PLAIN.replace("\n0.4", "\n# pause\n  # on\n0.4") + "# end, of log\n",
    "cut within a row": PLAIN + "2.000000,0.1",
    "cut within a cell": PLAIN + "2.000000,0.1,-1234.0,-",
    "null bytes at the end": PLAIN + "\0" * 300,
    "names with units": table(header="time_s,accel_x_mps2,accel_y_mps2,accel_z_mps2"),
    "indexed names": table(
        header="seconds,accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2]"
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", VARIANTS)
def test_one_table_in_many_dialects(tmp_path, name):
    path = tmp_path / "log.csv"
    path.write_bytes(VARIANTS[name].encode())
    read = read_table(path, ReadOptions())
    assert set(read.values) == {"time", "accel_x", "accel_y", "accel_z"}
    np.testing.assert_allclose(read.values["time"], TIME, atol=1e-9)
    for i, axis in enumerate("xyz"):
        np.testing.assert_allclose(read.values[f"accel_{axis}"], ACCEL[:, i], atol=1e-6)
    assert ("cut off" in read.notes[-1]) == ("cut" in name or "null" in name)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-be", "utf-32", "cp1252"])
def test_other_encodings_are_read_and_said(tmp_path, encoding):
    path = tmp_path / "log.csv"
    path.write_bytes(PLAIN.replace("^2", "²").encode(encoding))
    read = read_table(path, ReadOptions())
    np.testing.assert_allclose(read.values["accel_z"], ACCEL[:, 2], atol=1e-6)
    assert any("no UTF-8" in note for note in read.notes) == (encoding != "utf-8-sig")


def test_a_cut_last_line_leaves_whole_nanoseconds_whole(tmp_path):
    start = 1_403_636_579_758_555_392
    rows = [f"{start + i * 5_000_001},{i}" for i in range(20)]
    (tmp_path / "a.csv").write_text("t [ns],gx [rad/s]\n" + "\n".join(rows) + "\n1403636579")
    read = read_table(tmp_path / "a.csv", ReadOptions())
    np.testing.assert_allclose(read.values["time"], np.arange(20) * 5_000_001e-9, rtol=1e-15)


def test_rows_are_counted_as_they_are_read(tmp_path):
    """The line in a message is that of the row, whatever stands between."""
    between = ["", "  ", "\t", ",,,", ";;", "# c", "  # c, d", "// c", "% c", "\t# c"]
    for sep in (",", ";", "\t", " "):
        nothing = [b for b in between if not set(b) & set(",;") - {sep}]
        lines, numbers = [sep.join(["a[s]", "b[g]", "c[g]"])], []
        for i in range(60):
            if i % 3 == 0:
                lines.append(nothing[i // 3 % len(nothing)])
            lines.append(sep.join([str(i), str(2 * i), "7"]))
            numbers.append(len(lines))
        (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
        file = open_csv(tmp_path / "a.csv")
        np.testing.assert_array_equal(file.numbers([0])[0], np.arange(60))
        assert [file.line(i) for i in range(60)] == numbers


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t [s];ax [g]\n" + "1;1,100\n" * 9, "could be a decimal comma or a group"),
        ("t [s],ax [g]\n" + "0,5,1,5\n" * 9, "has 2 titles, the rows have 4 cells"),
        ("t [s],ax [counts]\n0,1\n1,2\n", "16384 counts/g"),
        ("t [s],ax [LSB/g]\n0,1\n1,2\n", "16384 counts/g"),
        ("t,ax,gx\n0,1,1\n1,2,2\n", "--units time=s,accelerometer=m/s^2,gyroscope=deg/s with"),
        ("t [s],gx [rad/s]\n0,1\n1," + "9" * 400 + "\n2,3\n", ":3: column"),
        ("\x01\x02\0\0\x03", "holds null bytes"),
    ],
)
def test_refusals_tell_the_way_out(tmp_path, text, message):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(InputError) as error:
        read_table(tmp_path / "a.csv", ReadOptions())
    assert message in str(error.value)


def test_notation_is_never_guessed():
    assert notation_of(["0,123"]).notation is Notation.COMMA
    assert notation_of(["1.234,5"]).notation is Notation.COMMA
    assert notation_of(["1,234.5"]).notation is Notation.POINT
    assert notation_of(["1,234"]).open
    assert not notation_of(["1,234", "0.5"]).open
    assert number("1,234", Notation.POINT) == 1234.0
    assert number("1,234", Notation.COMMA) == 1.234
    assert number("12,34", Notation.POINT) is None
    assert number("0,123", Notation.POINT) is None


@pytest.mark.parametrize(
    ("kind", "unit", "value"),
    [
        ("acceleration", "G", STANDARD_GRAVITY),
        ("acceleration", "mG", STANDARD_GRAVITY / 1e3),
        ("acceleration", "m/sec^2", 1.0),
        ("acceleration", "M/S^2", 1.0),
        ("acceleration", "m·s⁻²", 1.0),
        ("acceleration", "m/(s^2)", 1.0),
        ("acceleration", "meters per second squared", 1.0),
        ("acceleration", "16384 counts/g", STANDARD_GRAVITY / 16384),
        ("acceleration", "0.061 mg/LSB", 0.061e-3 * STANDARD_GRAVITY),
        ("angular rate", "DPS", np.pi / 180),
        ("angular rate", "˚/s", np.pi / 180),
        ("angular rate", "radians/s", 1.0),
        ("angular rate", "131 LSB/(°/s)", np.pi / 180 / 131),
        ("angular rate", "8.75 mdps/digit", 8.75e-3 * np.pi / 180),
        ("time", "msec", 1e-3),
        ("time", "milliseconds", 1e-3),
        ("time", "usec", 1e-6),
        ("time", "Sec", 1.0),
        ("time", "100 µs", 1e-4),
        ("time", "32768 ticks/s", 1 / 32768),
        ("speed", "knots", 1852 / 3600),
        ("speed", "KPH", 1 / 3.6),
        ("speed", "MPH", 0.44704),
    ],
)
def test_units_as_headers_spell_them(kind, unit, value):
    assert factor_of(unit, KINDS[kind]) == pytest.approx(value, rel=1e-12)


def test_units_that_are_none_are_refused():
    for unit in ("furlong", "0 counts/g", "counts", "deg/s", "g/counts/g", "m", "s"):
        with pytest.raises(UnitError):
            factor_of(unit, KINDS["acceleration"])
    for unit in ("m", "n", "µ", "g"):
        with pytest.raises(UnitError):
            factor_of(unit, KINDS["time"])


@pytest.mark.parametrize(
    ("title", "name", "unit"),
    [
        ("Time since start in ms", "time", "ms"),
        ("millis", "time", "millis"),
        ("seconds_elapsed", "time", "seconds"),
        ("TimeUS", "time", "us"),
        ("accelerometerAccelerationX(G)", "accel_x", "G"),
        ("Accel_LN_Y_CAL  m/(s^2)", "accel_y", "m/(s^2)"),
        ("x-axis (g)", "accel_x", "g"),
        ("gx [g]", "accel_x", "g"),
        ("gx", "gyro_x", ""),
        ("gFz", "accel_z", ""),
        ("field.angular_velocity.y", "gyro_y", ""),
        ("accelerometer_abc.x", "accel_x", ""),
        ("imu0_acc_z", "accel_z", ""),
        ("xgyro", "gyro_x", ""),
        ("Yaw rate (deg/s)", "gyro_z", "deg/s"),
        ("magnetometerX", None, ""),
        ("gyro_bias_x", None, ""),
        ("velocity_x", None, ""),
        ("linear_acceleration_covariance_x", None, ""),
        ("Temp [°C]", None, "°C"),
    ],
)
def test_titles_say_what_a_column_is(title, name, unit):
    parts = split_title(title)
    meaning = meaning_of(parts)
    assert (meaning.name if meaning else None, parts.unit) == (name, unit)


def columns_of(tmp_path, titles, **options):
    rows = np.column_stack([TIME, *[k + RNG.standard_normal(ROWS) for k in range(len(titles) - 1)]])
    path = tmp_path / "log.csv"
    lines = [",".join(map(repr, map(float, row))) for row in rows]
    path.write_text("\n".join([",".join(titles), *lines]) + "\n")
    read = read_table(path, ReadOptions(**options))
    return rows, read


def test_sensors_go_before_what_is_made_of_them(tmp_path):
    rows, read = columns_of(
        tmp_path,
        ["t [s]", "linear_acceleration_x [g]", "gravity_x [g]", "accelerometer_a.x [g]",
         "gyro_uncalibrated_x [deg/s]", "gyro_x [deg/s]"],
    )  # fmt: skip
    np.testing.assert_allclose(read.values["accel_x"], rows[:, 3] * STANDARD_GRAVITY)
    np.testing.assert_allclose(read.values["gyro_x"], np.radians(rows[:, 5]))
    assert '"accelerometer_a.x [g]" as accel_x in g' in read.notes[0]
    assert 'not used: "linear_acceleration_x [g]", "gravity_x [g]"' in read.notes[0]
    # What alone is there, and may be the sensor's, is used and named.
    rows, read = columns_of(tmp_path, ["t [s]", "linear_acceleration_x [g]", "gravity_x [g]"])
    np.testing.assert_allclose(read.values["accel_x"], rows[:, 1] * STANDARD_GRAVITY)
    # What a filter made is not.
    with pytest.raises(InputError, match="no accelerometer or gyroscope column"):
        columns_of(tmp_path, ["t [s]", "gravity_x [g]", "user_acceleration_x [g]"])


def test_two_sensors_are_asked_for_and_the_answer_works(tmp_path):
    titles = ["t [s]", "acc1_x [g]", "acc2_x [g]"]
    with pytest.raises(InputError, match="two columns are accel_x") as error:
        columns_of(tmp_path, titles)
    answer = str(error.value).split("--columns '")[1].rstrip("'")
    rows, read = columns_of(tmp_path, titles, columns=answer)
    np.testing.assert_allclose(read.values["accel_x"], rows[:, 1] * STANDARD_GRAVITY)
    rows, read = columns_of(tmp_path, titles, columns="time=t,accel_x=column 3")
    np.testing.assert_allclose(read.values["accel_x"], rows[:, 2] * STANDARD_GRAVITY)


def test_a_stated_unit_of_no_column_is_refused(tmp_path):
    with pytest.raises(InputError, match="--units gyroscope=deg/s: no column is one"):
        columns_of(tmp_path, ["t [s]", "ax [g]"], units="gyroscope=deg/s")
    columns_of(tmp_path, ["t [s]", "ax"], units="accelerometer=mg")


def test_counts_take_their_scale_from_options_or_header(tmp_path):
    rng = np.random.default_rng(5)
    force = np.array([0.1, 0.2, 0.97]) + 0.002 * rng.standard_normal((ROWS, 3))
    counts = np.round(force * 16384).astype(int)
    path = tmp_path / "raw.csv"
    rows = [f"{20 * i},{a},{b},{c}" for i, (a, b, c) in enumerate(counts)]
    path.write_text("\n".join(["millis,ax,ay,az", *rows]))
    log = read_log(path, ReadOptions(units="accelerometer=16384 counts/g"))
    np.testing.assert_allclose(log.channels[2].samples, counts[:, 2] * STANDARD_GRAVITY / 16384)
    inverse = read_log(path, ReadOptions(units="accelerometer=0.06103515625 mg/count"))
    np.testing.assert_allclose(inverse.channels[2].samples, log.channels[2].samples, rtol=1e-12)
    with pytest.raises(InputError, match=r"for counts of the converter .* counts/g'"):
        read_log(path, ReadOptions(units="accelerometer=m/s^2"))
    unit = "[16384 LSB/g]"
    path.write_text("\n".join([f"millis,ax {unit},ay {unit},az {unit}", *rows]))
    np.testing.assert_allclose(read_log(path).channels[2].samples, log.channels[2].samples)


def vibration(tmp_path, header, **options):
    path = tmp_path / "v.csv"
    rows = [f"{10 * i},{i % 7},{20 + 0.1 * (i % 5)},{i % 3}" for i in range(ROWS)]
    path.write_text("\n".join([header, *rows]))
    return read_vibration_log(path, **options)


def test_vibrations_ask_for_units_and_give_them_to_accelerations_alone(tmp_path):
    with pytest.raises(InputError, match=r'"time" has no unit; .*--time .time in ms'):
        vibration(tmp_path, "time,az [g],temp,gz")
    log = vibration(tmp_path, "time,az,temp,gz", time="time in ms", unit="mg")
    assert (log.channels, log.rate) == (("az",), pytest.approx(100.0))
    assert '"az" as az in mg; not used: "temp", "gz"' in log.remarks[0]
    log = vibration(tmp_path, "time [ms],a,b,c", unit="mg", channels=("b", "column 4"))
    assert log.channels == ("b", "c")
    with pytest.raises(InputError, match="every column that is used has its unit"):
        vibration(tmp_path, "time [ms],az [g],temp,gz", unit="mg")
    with pytest.raises(InputError, match="name the columns with --channel"):
        vibration(tmp_path, "time [ms],foo,temp,gz", unit="mg")
    log = vibration(tmp_path, "-10,6,7,8", time="column 1 in ms", unit="g", channels=("column 2",))
    assert log.rate == pytest.approx(100.0)


def test_benches_take_metres_counts_and_say_so(tmp_path):
    rows = ["+x,1,0,0", "-x,-1,0,0", "+y,0,1,0", "-y,0,-1,0", "+z,0,0,1", "-z,0,0,-1"]
    scaled = [
        ";".join([r.split(",")[0], *(f"{float(v) * 9.80665:.5f}" for v in r.split(",")[1:])])
        for r in rows
    ]
    path = tmp_path / "six.csv"
    path.write_text("\n".join(["position,x,y,z", *rows]))
    plain, told = read_six_positions(path), []
    header = "position;x [m/s^2];y [m/s^2];z [m/s^2]"
    path.write_text("\n".join([header, *scaled]).replace(".", ","))
    np.testing.assert_allclose(read_six_positions(path, told.append).means, plain.means, atol=1e-6)
    assert '"x [m/s^2]" as x in m/s²' in told[0]
    assert "standard gravity" in told[1]
    path.write_text("reference [m/s^2],measured [mg]\n" + "1,100\n2,200\n3,300\n4,400\n")
    reference, measured = read_amplitudes(path)
    np.testing.assert_allclose(reference, np.arange(1, 5) / STANDARD_GRAVITY)
    np.testing.assert_allclose(measured, np.arange(1, 5) / 10)
