"""Foreign text: plain arithmetic is read, the rest named with its line; nothing passed over."""

import math
import random

import pytest

from mcsim.cli.main import exit_code
from mcsim.dialects import Assumptions, read_sensor
from mcsim.dialects.arithmetic import NotPlain
from mcsim.dialects.matlab_text import evaluate, tokens
from mcsim.errors import InputError
from tests.test_dialects import GNSS_INS_SIM, IMU_UTILS, KALIBR, KF_GINS

DEG = math.pi / 180
ANSWERS = Assumptions({"n": "continuous", "w": "ignore"})


def values(text, name=None, assumptions=ANSWERS):
    elements = read_sensor(text, "file", name, assumptions).description.elements
    return {f"{e}.{k}": v for e, q in elements.items() for k, v in q.items()}


def refused(text, name=None, assumptions=ANSWERS):
    with pytest.raises(InputError) as error:
        read_sensor(text, "file", name, assumptions)
    return str(error.value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("4*9.81", 39.24),
        ("-2^2", -4.0),  # the power binds closer than the sign
        ("2^-1", 0.5),
        ("2^3^2", 64.0),  # MATLAB's powers go from the left
        ("1 - 2 - 3", -4.0),
        ("12/3/2", 2.0),
        ("--3", 3.0),
        ("deg2rad(180)", math.pi),
        ("deg2rad(0.2)/60", 0.2 * DEG / 60),
        ("150e-6*9.81", 150e-6 * 9.81),
        ("1.5d-3", 1.5e-3),
        ("pi/180*sqrt(4)", DEG * 2),
        ("3.*2", 6.0),
        ("[1 2 3]", (1, 2, 3)),
        ("[1, 2, 3]'", (1, 2, 3)),
        ("[1; 2; 3].*2", (2, 4, 6)),
        ("[1 -2]", (1, -2)),
        ("[1 - 2]", -1.0),
        ("[1 -2 + 4]", (1, 2)),
        ("[1 2 3]*deg2rad(1)", (DEG, 2 * DEG, 3 * DEG)),
        ("0.01*ones(1,3)", (0.01, 0.01, 0.01)),
        ("repmat(2, 1, 3)", (2, 2, 2)),
        ("[2 3].^2", (4, 9)),
        ("1/[1]", 1.0),
    ],
)
def test_matlabs_arithmetic(text, value):
    assert evaluate(list(tokens(text)), {}) == pytest.approx(value, rel=1e-15)


def test_sums_and_products_agree_with_python():
    """Random expressions of the grammar that both languages share, against Python's own answer."""
    draw = random.Random(4)

    def expression(depth):
        if depth == 0 or draw.random() < 0.2:
            return f"{draw.uniform(0.1, 9):.3g}"
        left, right = expression(depth - 1), expression(depth - 1)
        form = draw.choice(("{}+{}", "{} - {}", "{}*{}", "{}/({})", "({}+{})", "-({} - {})"))
        return form.format(left, right)

    compared = 0
    for _ in range(300):
        text = expression(4)
        try:
            expected = float(eval(text, {"__builtins__": {}}))  # our own text
        except ZeroDivisionError:
            continue
        assert evaluate(list(tokens(text)), {}) == pytest.approx(expected, rel=1e-12)
        compared += 1
    assert compared > 250


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("mg2si(3)", "the function mg2si"),
        ("noise", "`noise`"),
        ("[1 2 3]*[1 2 3]", "matrices"),
        ("2^[1 2]", "power of a matrix"),
        ("1/0", "no finite number"),
        ("sqrt(-1)", "no finite number"),
        ("10^400", "no finite number"),
        ("1:3", "`:`"),
        ("2*", "cut off"),
        ("(1", "open bracket"),
        ("x(2)", "the function x"),
        ("ones(3, 3)", "a matrix"),
        ("'text'", "`'text'`"),
        ("(" * 60 + "1" + ")" * 60, "nesting"),
        ("[1 2] + [1 2 3]", "different length"),
        ("1; 2", "`;`"),
    ],
)
def test_what_is_no_plain_arithmetic_is_named(text, named):
    with pytest.raises(NotPlain) as error:
        evaluate(list(tokens(text)), {})
    assert named in str(error.value)


MATLAB = """\
% gyroparams('NoiseDensity', 99)   a comment
g = 9.81;
spec.nd = 150e-6*g;   % a field
accel = accelparams('MeasurementRange', 4*g, 'NoiseDensity', spec.nd, ...
    'NoiseType', 'single-sided');
gyro = gyroparams;
gyro.NoiseType = "double-sided";
gyro.NoiseDensity = deg2rad([0.01 0.02 0.03]);
"""


def test_a_script_is_read_in_the_order_in_which_it_runs():
    given = values(MATLAB)
    assert given["accelerometer.velocity_random_walk"] == (pytest.approx(150e-6 * 9.81),)
    assert given["accelerometer.range"] == (pytest.approx(39.24),)
    assert given["gyroscope.noise_density"] == pytest.approx([0.01 * DEG, 0.02 * DEG, 0.03 * DEG])
    nested = "imu = imuSensor('accel-gyro', 'Gyroscope', gyroparams('NoiseDensity', 2*3));"
    assert values(nested) == {"gyroscope.noise_density": (6.0,)}
    owned = "imu.Gyroscope.NoiseDensity = 1e-3*[1 2 3];\nimu.Gyroscope.NoiseType = 'single-sided';"
    assert values(owned) == {"gyroscope.angle_random_walk": (1e-3, 2e-3, 3e-3)}
    named = "gyroparams(NoiseDensity=deg2rad(0.01), NoiseType='single-sided', MeasurementRange=Inf)"
    assert values(named) == {"gyroscope.angle_random_walk": (pytest.approx(0.01 * DEG),)}


def test_an_expression_never_swallows_the_next_pair():
    """A product in front of NoiseType once took it along: √2 of the noise, without a word."""
    for value in ("2*3", "deg2rad(0.01)", "sqrt(2)", "1/3", "(2)", "2^2", "[1 2 3]*2", "-(-2)"):
        text = f"gyroparams('NoiseDensity', {value}, 'NoiseType', 'single-sided')"
        assert list(values(text)) == ["gyroscope.angle_random_walk"]
        text = f"gyroparams('NoiseType', 'double-sided', 'NoiseDensity', {value})"
        assert list(values(text)) == ["gyroscope.noise_density"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("gyroparams('NoiseDensity', nd)", "file:1: gyroparams: NoiseDensity: `nd`"),
        ("\ngyroparams('NoiseDensity', f(2))", "file:2: gyroparams: NoiseDensity: `f(2)`"),
        ("gyroparams('NoiseDensity', convangvel(1,'deg/s','rad/s'))", "convangvel"),
        ("gyroparams('NoiseDensity', x.y*2)", "x.y"),
        ("nd = load('x');\ngyroparams('NoiseDensity', nd)", "whose value is not plain"),
        ("gyroparams('NoiseDensty', 1)", 'did you mean "NoiseDensity"'),
        ("gyroparams('NoiseDensity', 1, 'NoiseDensity', 2)", "stands twice"),
        ("gyroparams('NoiseDensity', 1, 'NoiseType')", "`'NoiseType'` is no name with its value"),
        ("gyroparams(p)", "`p` is no name with its value"),
        ("gyroparams(args{:})", "`args{:}`"),
        ("gyroparams('NoiseDensity', 1", "not closed"),
        ("gyroparams('NoiseDensity', [1 2])", "one number, or three"),
        ("gyroparams('NoiseDensity', -1)", "zero or above"),
        ("gyroparams('NoiseDensity', '1')", "one number, or three"),
        ("a = gyroparams('NoiseDensity', 1);\nb = gyroparams('NoiseDensity', 2);", "in line 1 too"),
        (
            "a = gyroparams('NoiseDensity', 1);\na.NoiseDensity(2) = 3;",
            "file:2: `a.NoiseDensity(2)",
        ),
        ("a = gyroparams('NoiseDensity', 1);\nb = a;\nb.Resolution = 3;", "on a copy"),
        ("a = gyroparams('NoiseDensity', 1);\nset(a, 'Resolution', 3);", "file:2: `set(a"),
        ("a = gyroparams('NoiseDensity', 1);\na.NoseDensity = 3;", "no such parameter"),
        ("if x\n a = gyroparams('NoiseDensity', 1);\nend", "file:2: parameters that a branch"),
        ("a = gyroparams('NoiseDensity', 1);\nif x, a.Resolution = 2; end", "branch"),
        ("if x, n = 1; else, n = 2; end\ngyroparams('NoiseDensity', n)", "`n`, whose value"),
        ("n = 1;\nn(2) = 2;\ngyroparams('NoiseDensity', n)", "`n`, whose value"),
        (
            "a = gyroparams('NoiseDensity', 1);\ni.Gyroscope = a;\ni.Gyroscope.Resolution = 2;",
            "on a copy",
        ),
    ],
)
def test_what_a_matlab_script_does_otherwise_is_refused(text, message):
    said = refused(text, "matlab")
    assert message in said
    assert said.startswith("file:")


def changed(old, new):
    assert old in GNSS_INS_SIM
    return GNSS_INS_SIM.replace(old, new)


ARW = "'gyro_arw': np.array([0.25, 0.25, 0.25])"


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("np.array([0.25, 0.25, 0.25]) * 1.0", 0.25),
        ("np.array([0.25, 0.25, 0.25]) * 1.0e0", 0.25),
        ("2.0 * numpy.array((0.25, 0.25, 0.25)) / 2", 0.25),
        ("np.array([0.25] * 3)", 0.25),
        ("[0.25] * 3", 0.25),
        ("0.25 * np.ones(3)", 0.25),
        ("np.full(3, 0.25)", 0.25),
        ("np.array([1, 1, 1]) * np.sqrt(2) * math.pi", math.sqrt(2) * math.pi),
        ("np.degrees(np.radians(np.array([3, 3, 3])))", 3.0),
        ("np.array([2**3**2] * 3) / 512", 1.0),
        ("np.array([-2**2 + 5] * 3)", 1.0),
        ("np.array([ARW, ARW, ARW])", 0.5),
        ("np.array([1, 1, 1]) * ARW", 0.5),
        ("ARW", 0.5),
    ],
)
def test_python_arithmetic(expression, value):
    text = changed(ARW, f"'gyro_arw': {expression}") + "\nARW = 0.5 * 1.0\n"
    given = values(text)["gyroscope.angle_random_walk"]
    assert given == pytest.approx([value * DEG / 60] * len(given), rel=1e-14)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (changed(ARW, "'gyro_arw': np.random.rand(3)"), "file:3: gyro_arw: only plain numbers"),
        (changed(ARW, "'gyro_arw': unknown"), "`unknown`, which is not set"),
        (changed(ARW, "'gyro_arw': [1, 2, 3] * 1.5"), "arithmetic with a list"),
        (changed(ARW, "'gyro_arw': np.array([1, 2, 3]) ^ 2"), "^ 2"),
        (changed(ARW, "'gyro_arw': np.array([1, 2, 3]) // 2"), "// 2"),
        (changed(ARW, "'gyro_arw': np.array([[1, 2, 3]])"), "list within a list"),
        (changed(ARW, "'gyro_arw': np.array([1, 2, 3], dtype=int)"), "dtype"),
        (changed(ARW, "'gyro_arw': True"), "`True`"),
        (changed(ARW, "'gyro_arw': 9**9**9**9"), "no finite number"),
        (changed(ARW, "'gyro_arw': (-1.0)**0.5"), "no real number"),
        (changed(ARW, "'gyro_arw': __import__('os').getpid()"), "__import__"),
        (changed(ARW, "'gyro_arw': ARW") + "ARW = 1\nARW = 2\n", "not set once"),
        (changed(ARW, "'gyro_arw': ARW") + "ARW = 1\nARW *= 2\n", "not set once"),
        (changed("'gyro_b_stability'", "'gyro_b_stabilty'"), 'did you mean "gyro_b_stability"'),
        (changed("'gyro_b':", "**base, 'gyro_b':"), "`base`"),
        (changed("'gyro_b':", "key: 1, 'gyro_b':"), "`key`"),
        (changed("'gyro_b':", "'gyro_arw': [1, 1, 1], 'gyro_b':"), "stands twice"),
        (GNSS_INS_SIM + GNSS_INS_SIM.partition("\n")[2], "2 dictionaries"),
        (GNSS_INS_SIM + "imu_err['gyro_arw'] *= 2\n", "this change of the dictionary"),
        (GNSS_INS_SIM + "imu_err.update(gyro_arw=[1, 1, 1])\n", "this change of the dictionary"),
        (GNSS_INS_SIM + "if x:\n    imu_err['gyro_arw'] = [1, 1, 1]\n", "this change of"),
        (changed("'gyro_b_corr'", "'gyro_b_drift': [1, 1, 1], 'gyro_b_corr'"), "twice"),
    ],
)
def test_what_a_python_text_does_otherwise_is_refused(text, message):
    assert message in refused(text, "gnss-ins-sim")


def test_later_items_and_dict_calls_count():
    text = GNSS_INS_SIM + "imu_err['gyro_arw'] = np.array([1, 2, 3]) * 0.5\n"
    given = values(text)["gyroscope.angle_random_walk"]
    assert given == pytest.approx([0.5 * DEG / 60, DEG / 60, 1.5 * DEG / 60])
    text = "e = dict(gyro_arw=[1, 1, 1], accel_vrw=[60, 60, 60])"
    assert values(text)["accelerometer.velocity_random_walk"] == pytest.approx([1, 1, 1])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (KALIBR.replace("1.87e-04", "deg2rad(0.01)"), 'not "deg2rad(0.01)"'),
        (KALIBR.replace("1.87e-04", "2*9.81e-5"), "file:5: gyroscope_noise_density"),
        (
            KALIBR.replace("gyroscope_noise", "gyroscope_nose"),
            "gyroscope_noise_density: is missing",
        ),
        (KALIBR.replace("200.0", "[200.0, 1]"), "update_rate"),
        (KALIBR.replace("200.0", "-1"), "update_rate"),
        ("imu0:\n  gyroscope_noise_density: 1\nimu1:\n  gyroscope_noise_density: 1\n", "imu1"),
        (KF_GINS.replace("gbstd:", "gbstdd:"), 'did you mean "gbstd"'),
        (KF_GINS.replace("[0.003, 0.003, 0.003]", "[0.003*60, 1, 1]"), "file:3: imunoise.arw"),
        (KF_GINS.replace("imudatarate: 200", "imudatarate: [1, 2]"), "imudatarate"),
        (KF_GINS.replace("[0.003, 0.003, 0.003]", "9" * 400), "imunoise.arw"),
        ("imunoise: [1, 2]\n", "imunoise.arw: is missing"),
        (IMU_UTILS.replace("1.95e-04", "1.95e-04*20"), "file:7: Gyr.x-axis.gyr_n"),
        (IMU_UTILS.replace("y-axis: {acc", "w-axis: {acc"), "Acc.y-axis.acc_n: is missing"),
        (IMU_UTILS.replace('" rad/s"', '" furlong"'), 'Gyr.unit: "furlong": unknown unit'),
        (IMU_UTILS.replace("Gyr:", "Gyr: 3\nx:"), "x: is not known here"),
        ("gyroscope:\n  noise_density: 2*0.01 °/s/√Hz\n", "file:2: gyroscope.noise_density"),
    ],
)
def test_yaml_of_other_tools_is_refused_by_name_and_line(text, message):
    assert message in refused(text)


def test_opencvs_head_is_passed_over_with_the_lines_kept():
    for head in ("%YAML:1.0\n", "%YAML:1.0 # head\n---\n", "%YAML:1.0\n\n"):
        for text in (KALIBR, KF_GINS):
            assert values(head + text) == values(text)
        line = head.count("\n") + 2
        assert f"file:{line}: " in refused(head + KALIBR.replace("1.86e-03", "much"))


def test_the_unit_that_imu_utils_states_is_used():
    text = IMU_UTILS.replace('" rad/s"', '" deg/s"')
    plain = values(IMU_UTILS)["gyroscope.angle_random_walk"]
    assert values(text)["gyroscope.angle_random_walk"] == pytest.approx([DEG * n for n in plain])


def test_brackets_without_end_are_refused_at_once():
    for text in ("[" * 6000, "Gyr: " + "{" * 6000, "Gyr: " + "[" * 3000 + "]" * 3000):
        assert "brackets are open" in refused(text, "imu_utils")
    for sign in ("(", "[", "-", "{"):
        assert refused(f"gyroparams('NoiseDensity', {sign * 6000}1)", "matlab")
        assert refused(changed(ARW, f"'gyro_arw': {sign * 6000}1"), "gnss-ins-sim")


SEEDS = (
    (KALIBR, "kalibr"),
    (KF_GINS, "kf-gins"),
    (GNSS_INS_SIM, "gnss-ins-sim"),
    (IMU_UTILS, "imu_utils"),
    (MATLAB, "matlab"),
)
JUNK = (
    *("[", "}", "(", ":", "'", '"', "\n", "\t", "-", "!!binary ", "&a ", "*a", "%", "...", "1e999"),
    *("null", "true", "[1, 2]", "{a: b}", "9" * 400, "\0", "**", "-1", "2026-01-01", "!t "),
)


def mutated(draw, text):
    for _ in range(draw.choice((1, 1, 2, 4))):
        lines = text.split("\n")
        place, line = draw.randrange(len(text) + 1), draw.randrange(len(lines))
        form = draw.randrange(5)
        if form == 0:
            text = text[:place] + draw.choice(JUNK) + text[place + draw.choice((0, 1, 5)) :]
        elif form == 1:
            text = text[:place]
        elif form == 2:
            text = "\n".join(lines[:line] + lines[line + 1 :])
        elif form == 3:
            name = lines[line].partition(":")[0]
            text = "\n".join([*lines[:line], f"{name}: {draw.choice(JUNK)}", *lines[line + 1 :]])
        else:
            text = text[:place] + text[place : place + 20] * 2 + text[place + 20 :]
    return text


def test_damaged_texts_are_read_or_refused():
    """Nothing but InputError comes out of a reader, whatever it is given."""
    draw = random.Random(6)
    read = 0
    for _ in range(250):
        seed, name = draw.choice(SEEDS)
        text = mutated(draw, seed)
        try:
            read_sensor(text, "file", draw.choice((None, name)), ANSWERS)
            read += 1
        except InputError:
            pass
    assert 10 < read < 200


def test_a_file_that_is_not_understood_writes_nothing(tmp_path, capsys):
    path = tmp_path / "sensor.m"
    path.write_text("gyroparams('NoiseDensity', nd)", encoding="utf-8")
    assert exit_code(["convert", str(path), "--to", "kalibr"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert f"{path}:1: gyroparams: NoiseDensity: `nd`" in err
