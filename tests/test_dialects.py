"""Noise dialects: numbers of vendors and tools, exact round trips, questions instead of guesses."""

import math
import random

import numpy as np
import pytest

from mcsim.cli.main import exit_code
from mcsim.dialects import Assumptions, read_sensor, recognise, write_sensor
from mcsim.dialects.numbers import number, tidy
from mcsim.dialects.quantity import convert_quantity
from mcsim.errors import InputError

DEG = math.pi / 180
G = 9.80665
ROOT_2 = math.sqrt(2)

KALIBR = """\
#Accelerometers
accelerometer_noise_density: 1.86e-03   #Noise density (continuous-time)
accelerometer_random_walk:   4.33e-04   #Bias random walk
#Gyroscopes
gyroscope_noise_density:     1.87e-04
gyroscope_random_walk:       2.66e-05
rostopic:                    /imu0
update_rate:                 200.0
"""
# MathWorks' example on Allan variance: N, K and B of its logged gyroscope.
MATLAB = """\
% noise of the example
gyro = gyroparams('NoiseDensity', 0.0125631765533906, 'RandomWalk', 9.38284069320333e-05, ...
    'BiasInstability', 0.00203140909966965, 'NoiseType', 'single-sided');
"""
KF_GINS = """\
imudatarate: 200
imunoise:
  arw: [0.003, 0.003, 0.003]          # [deg/sqrt(hr)]
  vrw: [0.03, 0.03, 0.03]             # [m/s/sqrt(hr)]
  gbstd: [0.027, 0.027, 0.027]        # [deg/hr]
  abstd: [15.0, 15.0, 15.0]           # [mGal]
  gsstd: [300.0, 300.0, 300.0]        # [ppm]
  asstd: [300.0, 300.0, 300.0]        # [ppm]
  corrtime: 4.0                       # [hr]
"""
GNSS_INS_SIM = """\
import numpy as np
imu_err = {'gyro_b': np.array([0.0, 0.0, 0.0]),
           'gyro_arw': np.array([0.25, 0.25, 0.25]),
           'gyro_b_stability': np.array([3.5, 3.5, 3.5]),
           'gyro_b_corr': np.array([100.0, 100.0, 100.0]),
           'accel_b': np.array([0.0, 0.0, 0.0]),
           'accel_vrw': np.array([0.03, 0.03, 0.05]),
           'accel_b_stability': np.array([5.0e-5, 5.0e-5, 5.0e-5]),
           'accel_b_corr': np.array([100.0, 100.0, 100.0])}
"""
IMU_UTILS = """\
%YAML:1.0
---
type: IMU
name: "16448"
Gyr:
   unit: " rad/s"
   x-axis: {gyr_n: 1.95e-04, gyr_w: 7.7e-05}
   y-axis: {gyr_n: 1.82e-04, gyr_w: 6.6e-05}
   z-axis: {gyr_n: 1.80e-04, gyr_w: 7.4e-05}
Acc:
   unit: " m/s^2"
   x-axis: {acc_n: 1.9e-03, acc_w: 9.3e-04}
   y-axis: {acc_n: 2.3e-03, acc_w: 1.9e-03}
   z-axis: {acc_n: 1.8e-03, acc_w: 8.5e-04}
"""
NOMINAL = Assumptions({"b_stability": "deviation"})


def read(text, name=None, assumptions=NOMINAL):
    return read_sensor(text, "file", name, assumptions).description


def values(text, assumptions=NOMINAL):
    elements = read(text, None, assumptions).elements
    return {f"{e}.{k}": v for e, q in elements.items() for k, v in q.items()}


def test_kalibrs_noise_density_is_allans_n_and_its_random_walk_allans_k():
    """Its wiki: samples of deviation sigma / sqrt(dt), bias steps of sigma_b sqrt(dt)."""
    sensor = read(KALIBR)
    assert sensor.rate == 200.0
    given = values(KALIBR)
    assert given["accelerometer.velocity_random_walk"] == (1.86e-3,)
    assert given["gyroscope.rate_random_walk"] == (2.66e-5,)
    sheet = write_sensor(sensor, "datasheet", NOMINAL)
    density = values(sheet)["gyroscope.noise_density"][0]
    assert density == pytest.approx(ROOT_2 * 1.87e-4, rel=1e-14)
    assert density != pytest.approx(1.87e-4, rel=0.1)


def test_a_data_sheets_density_reaches_kalibr_divided_by_root_two():
    text = "accelerometer: {noise_density: 220 µg/√Hz, acceleration_random_walk: 5 m/s/h^1.5}\n"
    text += "gyroscope: {noise_density: 0.03 °/s/√Hz, rate_random_walk: 10 °/h^1.5}\nrate: 100 Hz\n"
    given = values(write_sensor(read(text), "kalibr", NOMINAL))
    assert given["accelerometer.velocity_random_walk"][0] == pytest.approx(220e-6 * G / ROOT_2)
    assert given["gyroscope.angle_random_walk"][0] == pytest.approx(0.03 * DEG / ROOT_2)
    assert given["accelerometer.acceleration_random_walk"][0] == pytest.approx(5 / 216000)


def test_kf_gins_units_are_those_of_its_source():
    """gyr_arw *= D2R / 60, abstd *= 1e-5, gbstd *= D2R / 3600, corrtime *= 3600."""
    given = values(KF_GINS)
    assert given["gyroscope.angle_random_walk"][0] == pytest.approx(0.003 * DEG / 60)
    assert given["accelerometer.velocity_random_walk"][0] == pytest.approx(0.03 / 60)
    assert given["gyroscope.gauss_markov.deviation"][0] == pytest.approx(0.027 * DEG / 3600)
    assert given["accelerometer.gauss_markov.deviation"][0] == pytest.approx(15e-5)
    assert given["accelerometer.scale_factor_error"][0] == pytest.approx(300e-6)
    assert given["accelerometer.gauss_markov.correlation_time"] == (14400.0,)


def test_gnss_ins_sims_white_noise_is_allans_n():
    given = values(GNSS_INS_SIM)
    assert given["gyroscope.angle_random_walk"][0] == pytest.approx(0.25 * DEG / 60)
    assert given["accelerometer.velocity_random_walk"][2] == pytest.approx(0.05 / 60)
    assert given["gyroscope.gauss_markov.deviation"][0] == pytest.approx(3.5 * DEG / 3600)


def test_gnss_ins_sims_drift_as_it_is_simulated():
    """Its recursion, iterated in variance until stationary, is the oracle."""
    rate = 100.0
    as_coded = Assumptions({"b_stability": "driving"}, rate)
    variance = 0.0
    for _ in range(200_000):
        variance = (1 - 1 / rate / 100.0) ** 2 * variance + (5e-5 / rate) ** 2
    deviation = values(GNSS_INS_SIM, as_coded)["accelerometer.gauss_markov.deviation"][0]
    assert deviation == pytest.approx(math.sqrt(variance), rel=1e-6)
    # Nominally it would be 5e-5, 1.4 times as much at this rate and time.
    assert deviation == pytest.approx(5e-5 * math.sqrt(100.0 / rate / 2), rel=1e-3)
    back = write_sensor(read(GNSS_INS_SIM, None, as_coded), "gnss-ins-sim", as_coded)
    assert values(back, NOMINAL)["accelerometer.gauss_markov.deviation"][0] == pytest.approx(5e-5)


def test_matlabs_single_sided_is_allans_and_double_sided_a_data_sheets():
    given = values(MATLAB)
    assert given["gyroscope.angle_random_walk"] == (0.0125631765533906,)
    assert given["gyroscope.rate_random_walk"] == (9.38284069320333e-05,)
    assert given["gyroscope.bias_instability"] == (0.00203140909966965,)
    plain = "accelparams('NoiseDensity', [1e-3 1e-3 2e-3], 'NoiseType', \"double-sided\")"
    assert values(plain) == {"accelerometer.noise_density": (1e-3, 1e-3, 2e-3)}
    reading = read_sensor("accelparams(NoiseDensity=1e-3, TemperatureBias=2)", "f", None, NOMINAL)
    assert reading.description.elements["accelerometer"] == {"noise_density": (1e-3,)}
    assert "default, double-sided" in reading.notes[0]
    assert "TemperatureBias" in reading.notes[1]


def test_imu_utils_numbers_are_asked_about():
    with pytest.raises(InputError, match="--assume n=continuous"):
        read(IMU_UTILS, None, Assumptions())
    with pytest.raises(InputError, match="--assume w=allan_minimum"):
        read(IMU_UTILS, None, Assumptions({"n": "continuous"}))
    with pytest.raises(InputError, match="--rate"):
        read(IMU_UTILS, None, Assumptions({"n": "per_sample", "w": "ignore"}))
    with pytest.raises(InputError, match='"discrete" is none of them'):
        read(IMU_UTILS, None, Assumptions({"n": "discrete"}))


def test_imu_utils_numbers_as_answered():
    given = values(IMU_UTILS, Assumptions({"n": "continuous", "w": "allan_minimum"}))
    # ADIS16448's data sheet prints an angle random walk of 0.66 °/√h; this specimen has less.
    assert given["gyroscope.angle_random_walk"][0] == pytest.approx(0.66 * DEG / 60, rel=0.03)
    floor = math.sqrt(2 * math.log(2) / math.pi)
    assert given["accelerometer.bias_instability"][1] == pytest.approx(1.9e-3 / floor)
    given = values(IMU_UTILS, Assumptions({"n": "per_sample", "w": "random_walk"}, 400.0))
    assert given["gyroscope.angle_random_walk"][0] == pytest.approx(1.95e-4 / 20)
    assert given["gyroscope.rate_random_walk"] == (7.7e-5, 6.6e-5, 7.4e-5)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (KALIBR, "kalibr"),
        (MATLAB, "matlab"),
        (KF_GINS, "kf-gins"),
        (GNSS_INS_SIM, "gnss-ins-sim"),
        (IMU_UTILS, "imu_utils"),
        ("gyroscope: {noise_density: 1 °/s/√Hz}\n", "mcsim"),
    ],
)
def test_dialects_are_recognised(text, name):
    assert recognise(text, "file").name == name


def test_what_is_no_dialect_is_refused():
    with pytest.raises(InputError, match="--from"):
        recognise("case: planar\n", "file")
    with pytest.raises(InputError, match=r"several dialects.*mcsim, kalibr"):
        recognise(KALIBR + "accelerometer: {}\n", "file")


@pytest.mark.parametrize("there", ["mcsim", "allan", "kalibr"])
def test_kalibr_files_come_back_exactly(there):
    sensor = read(KALIBR)
    text = write_sensor(sensor, "kalibr", NOMINAL)
    away = read(write_sensor(sensor, there, NOMINAL))
    assert write_sensor(away, "kalibr", NOMINAL) == text
    assert values(text) == values(KALIBR)


@pytest.mark.parametrize(
    ("text", "home"), [(KF_GINS, "kf-gins"), (GNSS_INS_SIM, "gnss-ins-sim"), (MATLAB, "matlab")]
)
@pytest.mark.parametrize("there", ["mcsim", "allan", "datasheet"])
def test_other_files_come_back_exactly(text, home, there):
    sensor = read(text)
    away = read(write_sensor(sensor, there, NOMINAL), "mcsim")
    if home == "matlab" and there == "allan":
        # Fifteen digits, more than any noise is known to: the last one may move.
        there_and_back = values(write_sensor(away, home, NOMINAL))
        assert there_and_back.keys() == values(text).keys()
        for key, value in values(text).items():
            assert there_and_back[key] == pytest.approx(value, rel=2e-15)
        return
    assert write_sensor(away, home, NOMINAL) == write_sensor(sensor, home, NOMINAL)


@pytest.mark.slow
def test_round_trips_through_every_dialect_are_exact_to_the_last_printed_digit():
    """Random decimal figures in data-sheet units: away by way of √2 and back, digit by digit."""
    draw = random.Random(3)
    for _ in range(200):
        ug, dps, k_a, k_g = (float(f"{draw.uniform(1, 10):.{draw.randint(2, 9)}e}") for _ in "1234")
        text = (
            f"rate: 100.0 Hz\naccelerometer:\n  noise_density: {number(ug)} µg/√Hz\n"
            f"  acceleration_random_walk: {number(k_a)} µg/√s\n"
            f"gyroscope:\n  noise_density: {number(dps)} °/s/√Hz\n"
            f"  rate_random_walk: {number(k_g)} °/s/√s\n"
        )
        sensor = read(text)
        for there in ("mcsim", "allan", "kalibr", "matlab"):
            away = read(write_sensor(sensor, there, NOMINAL), None, Assumptions(rate=100.0))
            assert write_sensor(away, "datasheet", NOMINAL).endswith(text), there


def test_numbers_are_read_by_yaml_1_1():
    yaml = pytest.importorskip("yaml")
    for value in (1e-5, 1.0, 3e22, 1.87e-4, 2e-7):
        assert yaml.safe_load(number(value)) == value
    assert yaml.safe_load("1e-05") == "1e-05"  # the trap
    written = yaml.safe_load(write_sensor(read(KALIBR), "kalibr", NOMINAL))
    assert written["gyroscope_random_walk"] == 2.66e-5
    assert tidy(0.1 + 0.2) == 0.3
    assert tidy(1 / 3) == 1 / 3


def test_kalibr_needs_what_it_needs():
    white = "accelerometer: {noise_density: 1 mg/√Hz}\ngyroscope: {noise_density: 1 °/s/√Hz}\n"
    with pytest.raises(InputError, match="--rate"):
        write_sensor(read(white), "kalibr", NOMINAL)
    with pytest.raises(InputError, match="acceleration_random_walk"):
        write_sensor(read(white), "kalibr", Assumptions(rate=100.0))
    with pytest.raises(InputError, match="no gyroscope"):
        write_sensor(read("accelerometer: {noise_density: 1 mg/√Hz}\n"), "kf-gins", NOMINAL)


def test_axes_are_not_merged_in_silence():
    answers = Assumptions({"n": "continuous", "w": "random_walk"}, 200.0)
    sensor = read(IMU_UTILS, None, answers)
    with pytest.raises(InputError, match="--axis x, y, z or largest"):
        write_sensor(sensor, "kalibr", answers)
    for axis, expected in (("y", 2.3e-3), ("z", 1.8e-3), ("largest", 2.3e-3)):
        chosen = Assumptions(answers.answers, 200.0, axis)
        text = write_sensor(sensor, "kalibr", chosen)
        assert values(text)["accelerometer.velocity_random_walk"] == (expected,)


def test_what_a_dialect_cannot_hold_is_said():
    text = "accelerometer: {noise_density: 1 mg/√Hz, bandwidth: 50 Hz, bias_instability: 1 mg}\n"
    assert "not carried over: bandwidth" in write_sensor(read(text), "matlab", NOMINAL)


def test_infinite_correlation_times_are_white_noise_and_refused():
    text = GNSS_INS_SIM.replace("'gyro_b_corr': np.array([100.0, 100.0, 100.0]),", "")
    with pytest.raises(InputError, match="white noise to every sample"):
        read(text)
    text = GNSS_INS_SIM.replace("[100.0, 100.0, 100.0]", "[float('inf'), 1.0, 1.0]")
    with pytest.raises(InputError, match="white noise to every sample"):
        read(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (KALIBR.replace("1.86e-03", "'a lot'"), "file:2: accelerometer_noise_density: one number"),
        (KALIBR.replace("1.86e-03", "-1.0"), "zero or above"),
        (KALIBR.replace("update_rate", "rate"), "update_rate: is missing"),
        (KF_GINS.replace("[15.0, 15.0, 15.0]", "[15.0, 15.0]"), "three for x, y and z"),
        (KF_GINS.replace("corrtime: 4.0", "corrtime: 0"), "above zero"),
        (GNSS_INS_SIM.replace("imu_err", "imu err"), "not Python text"),
        (GNSS_INS_SIM.replace("0.25, 0.25, 0.25", "x, x, x"), "only plain numbers"),
        (MATLAB.replace("single-sided", "one-sided"), "is not single-sided"),
        (MATLAB.replace("'single-sided'", "'double-sided'"), "--assume RandomWalk=K"),
        ("accelerometer: {noise_densty: 1 mg/√Hz}\n", 'did you mean "noise_density"'),
        ("accelerometer:\n  noise_density: 1\n", "has no unit"),
    ],
)
def test_bad_files_are_explained(text, message):
    with pytest.raises(InputError) as error:
        read(text)
    assert message in str(error.value)


def rows(text, *arguments):
    conversion = convert_quantity(text, *arguments)
    return {(row.what, row.remark): row.values for row in conversion.rows}, conversion.meaning


def test_a_random_walk_in_all_units():
    """0.2 °/√h: 0.2/60 °/√s two-sided, √2 of it one-sided."""
    found, meaning = rows("0.2 deg/sqrt(hr)", None, 100.0)
    assert "two-sided" in meaning
    assert found["noise density", "one-sided"].startswith(f"{ROOT_2 * 0.2 / 60:.6g} °/s/√Hz")
    assert found["Kalibr", "rad/s/√Hz, two-sided"].endswith(f"{0.2 / 60 * DEG:.6g}")
    assert found["KF-GINS", "°/√h, two-sided"] == "arw 0.2"
    assert found["one sample at 100 Hz", "ND √(fs/2) = N √fs"].startswith("0.0333333 °/s")


def test_a_density_is_one_sided_unless_told_otherwise():
    found, meaning = rows("220 µg/√Hz")
    assert "--as velocity_random_walk" in meaning
    assert found["velocity random walk N", "two-sided, N = ND / √2"].startswith("0.0915334 m/s/√h")
    found, _ = rows("220 µg/√Hz", "velocity_random_walk")
    assert found["noise density", "one-sided"].startswith("311.127 µg/√Hz")


def test_biases_are_asked_about():
    with pytest.raises(InputError, match="--as allan_minimum"):
        convert_quantity("5 °/h")
    found, _ = rows("5 °/h", "allan_minimum")
    assert found["bias instability B", "flicker"].startswith(f"{5 / 0.66428:.4g}"[:4])
    with pytest.raises(InputError, match="can only be angle_random_walk"):
        convert_quantity("5 °/√h", "noise_density")
    for wrong, message in (("5 m", "no unit of noise"), ("-1 °/√h", "zero or above")):
        with pytest.raises(InputError, match=message):
            convert_quantity(wrong)


def test_convert_writes_files_for_other_tools(tmp_path, capsys):
    path = tmp_path / "imu.yaml"
    path.write_text(KALIBR, encoding="utf-8")
    assert exit_code(["convert", str(path), "--from", "kalibr", "--to", "mcsim"]) == 0
    own = capsys.readouterr().out
    back = tmp_path / "sensor.yaml"
    back.write_text(own, encoding="utf-8")
    assert exit_code(["convert", str(back), "--to", "kalibr"]) == 0
    assert values(capsys.readouterr().out) == values(KALIBR)


def test_convert_shows_all_dialects_and_says_which_are_not_possible(capsys):
    assert exit_code(["convert", "lsm330dl"]) == 0
    out = capsys.readouterr().out
    assert "# --to kf-gins" in out
    assert "# --to kalibr is not possible so:" in out
    assert "0.03 °/s/√Hz" in out


@pytest.mark.parametrize(
    ("dialect", "held", "others"),
    [
        ("kalibr", "gyroscope_noise_density 5.81776e-05", ("°/√h,", "gyro_arw", "MATLAB")),
        ("kf-gins", "arw 0.2", ("KF_GINS", "gyroscope_noise_density")),
        ("datasheet", "0.00471405 °/s/√Hz", ("angle random walk N", "Kalibr")),
        ("allan", "0.00333333 °/√s", ("°/s/√Hz", "Kalibr")),
        ("matlab", "NoiseDensity 8.22756e-05", ("gyro_arw",)),
    ],
)
def test_a_quantity_is_shown_in_the_dialect_asked_for(dialect, held, others, capsys):
    assert exit_code(["convert", "0.2 °/√h", "--to", dialect]) == 0
    out = capsys.readouterr().out
    assert held in out
    assert not any(other in out for other in others)
    # Control: without the option all are there.
    assert exit_code(["convert", "0.2 °/√h"]) == 0
    whole = capsys.readouterr().out
    assert held in whole
    assert "Kalibr" in whole


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["5 °/h"], "--as bias_instability"),
        (["nothing.yaml"], "no such file"),
        ([""], "name a file, a sensor or a quantity"),
        (["LSM330D"], "did you mean"),
        (["1 mg/√Hz", "--rate", "0 Hz"], "above zero"),
        (["1 mg/√Hz", "--rate", "-5 Hz"], "above zero"),
        (["-3 °/h"], '"-3 °/h": a noise figure is zero or above'),
        (["--as", "bias_instability", "-.3 °/h", "--to", "kalibr"], "zero or above"),
        (["--nonsense"], "No such option"),
        (["5 °/h", "--as", "bias_instability", "--to", "kalibr"], "kalibr has no place for it"),
        (["LSM330DL", "--assume", "n"], "write key=meaning"),
        (["MTN-1100", "--to", "kalibr", "--rate", "100 Hz"], "Allan's K"),
    ],
)
def test_convert_explains_bad_input(arguments, message, capsys):
    assert exit_code(["convert", *arguments]) == 2
    out, err = capsys.readouterr()
    assert message in err
    assert out == ""


def test_allan_deviation_of_converted_noise_by_another_library():
    """A data sheet's density, converted to N, is what allantools finds at 1 s."""
    import allantools

    rate, density = 100.0, 220e-6 * G
    samples = np.random.default_rng(5).normal(0.0, density * math.sqrt(rate / 2), 200_000)
    _, deviations, _, _ = allantools.oadev(samples, rate=rate, data_type="freq", taus=[1.0])
    text = write_sensor(
        read("accelerometer: {noise_density: 220 µg/√Hz}\n"), "allan", Assumptions()
    )
    n = values(text)["accelerometer.velocity_random_walk"][0]
    # Overlapping estimate from 2000 s: about 2 % at 1 s, so 5 sigma are 8 %.
    assert deviations[0] == pytest.approx(n, rel=0.08)
    assert deviations[0] != pytest.approx(density, rel=0.2)
