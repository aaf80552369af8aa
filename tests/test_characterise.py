"""``mcsim characterise`` from a log to a sensor, and what it notices on the way."""

import math
import os
import subprocess
import sys
from pathlib import Path

import allantools
import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML

from mcsim import Scenario
from mcsim.characterisation.analysis import Settings, characterise
from mcsim.characterisation.fit import fit_noise
from mcsim.characterisation.sensor_file import sensor_file
from mcsim.characterisation.spectrum import (
    density_from_deviation,
    find_lines,
    spectrum_of,
    white_floor,
)
from mcsim.characterisation.verdict import number, verdict
from mcsim.cli.main import exit_code
from mcsim.errors import InputError
from mcsim.logs import Channel, Log, ReadOptions, Timing, read_log
from mcsim.scenario.sensor_file import parse_sensor_file
from mcsim.units import KINDS, parse, sample_deviation
from tests.conftest import BASE
from tests.reference.noise import gauss_markov, static_noise

RATE, N_SAMPLES = 50.0, 100_000
ACCEL = (1e-3, 3e-4, 1e-5)
GYRO = (1e-4, 2e-5, 1e-6)


def noise(seed=1, mix=ACCEL, n=N_SAMPLES, rate=RATE):
    return static_noise(*mix, rate, n, np.random.default_rng(seed))


def log_of(*samples, element="accelerometer", rate=RATE):
    channels = tuple(
        Channel(element, axis, values) for axis, values in zip("xyz", samples, strict=False)
    )
    return Log(Path("log.csv"), channels, Timing(rate, stamped=False))


def kinds(found):
    return {finding.kind for finding in found.findings}


@pytest.fixture(scope="module")
def csv(tmp_path_factory):
    """A clean log of three accelerometer axes and one gyroscope axis, in g and degrees."""
    columns = {f"accel_{a} [m/s^2]": noise(k) for k, a in enumerate("xyz")}
    columns["accel_z [m/s^2]"] = columns["accel_z [m/s^2]"] + 9.81
    columns["gyro_z (deg/s)"] = np.rad2deg(noise(9, GYRO))
    table = pd.DataFrame({"time [s]": np.arange(N_SAMPLES) / RATE} | columns)
    path = tmp_path_factory.mktemp("logs") / "static.csv"
    table.to_csv(path, index=False)
    return path


@pytest.fixture(scope="module")
def output(csv, tmp_path_factory):
    folder = tmp_path_factory.mktemp("out")
    assert exit_code(["characterise", str(csv), "--output", str(folder), "--quiet"]) == 0
    return folder


@pytest.mark.slow
def test_all_files_are_written(output):
    drawn = ("allan", "autocorrelation", "bias", "histogram", "psd")
    expected = {f"{name}.{ending}" for name in drawn for ending in ("csv", "png", "svg")}
    expected |= {"normality.csv", "provenance.json", "sensor.yaml"}
    assert {p.name for p in output.iterdir()} == expected


@pytest.mark.slow
def test_allan_table_is_allantools_of_the_log(csv, output):
    table = pd.read_csv(output / "allan.csv")
    assert list(table.columns) == ["channel", "tau_s", "adev", "ci_low", "ci_high"]
    assert list(table["channel"].unique()) == ["accel_x", "accel_y", "accel_z", "gyro_z"]
    rows = table[table["channel"] == "gyro_z"]
    samples = np.deg2rad(pd.read_csv(csv)["gyro_z (deg/s)"].to_numpy())
    tau, deviation, _, _ = allantools.oadev(
        samples, rate=RATE, data_type="freq", taus=rows["tau_s"].to_numpy()
    )
    np.testing.assert_allclose(rows["adev"].to_numpy()[: len(tau)], deviation, rtol=1e-9)
    assert np.all((rows["ci_low"] < rows["adev"]) & (rows["adev"] < rows["ci_high"]))
    assert 1.0 in set(rows["tau_s"])


def loaded(path):
    """A sensor file as written, which must be one that scenarios take."""
    text = path.read_text(encoding="utf-8")
    parse_sensor_file(text, str(path))
    return YAML(typ="safe").load(text)


@pytest.mark.slow
def test_the_sensor_file_loads_and_holds_the_truth(output):
    sensor = loaded(output / "sensor.yaml")
    accelerometer, gyroscope = sensor["accelerometer"], sensor["gyroscope"]
    n = parse(accelerometer["velocity_random_walk"], KINDS["velocity random walk"])
    assert n == pytest.approx(ACCEL[0], rel=0.02)
    b = parse(accelerometer["bias_instability"], KINDS["acceleration"])
    assert b == pytest.approx(ACCEL[1], rel=0.15)
    n = parse(gyroscope["angle_random_walk"], KINDS["angle random walk"])
    assert n == pytest.approx(GYRO[0], rel=0.03)
    axes = [
        parse(axis["velocity_random_walk"], KINDS["velocity random walk"])
        for axis in accelerometer["axes"].values()
    ]
    whole = parse(accelerometer["velocity_random_walk"], KINDS["velocity random walk"])
    assert whole == pytest.approx(math.sqrt(np.mean(np.square(axes))), rel=1e-5)
    text = (output / "sensor.yaml").read_text(encoding="utf-8")
    assert "two-sided" in text
    assert "one_sided_noise_density" in text


@pytest.mark.slow
def test_the_spectrum_holds_the_variance(csv, output):
    table = pd.read_csv(output / "psd.csv")
    rows = table[(table["channel"] == "accel_x") & (table["frequency_hz"] > 1.0)]
    # One-sided: 2 N² where the noise is white.
    assert rows["psd_one_sided"].mean() == pytest.approx(2.0 * ACCEL[0] ** 2, rel=0.05)
    samples = pd.read_csv(csv)["accel_x [m/s^2]"].to_numpy()
    assert np.std(samples) == pytest.approx(sample_deviation(math.sqrt(2) * ACCEL[0], RATE), 0.01)


@pytest.mark.slow
def test_the_summary_says_it_all(csv, tmp_path, capsys):
    arguments = ["characterise", str(csv), "--output", str(tmp_path), "--non-overlapping"]
    arguments += ["--fit-range", "0.1", "200", "--intervals", "covariance"]
    assert exit_code([*arguments, "--confidence", "3 sigma"]) == 0
    out, err = capsys.readouterr()
    assert "N (two-sided)" in out
    assert "velocity random walk well known" in out
    assert "rest cannot tell" in out
    assert "accel_x: 100,000 samples" in err
    fit = YAML(typ="safe").load((tmp_path / "sensor.yaml").read_text(encoding="utf-8"))["fit"]
    assert fit["confidence"] == pytest.approx(0.9973, abs=1e-4)
    assert fit["intervals"] == "covariance"
    assert fit["accel_x"]["cluster_times"].startswith("0.1 s to 1")
    table = pd.read_csv(tmp_path / "allan.csv")
    rows = table[table["channel"] == "accel_x"]
    samples = pd.read_csv(csv)["accel_x [m/s^2]"].to_numpy()
    _, deviation, _, _ = allantools.adev(samples, rate=RATE, data_type="freq", taus=[1.0])
    at = rows.loc[(rows["tau_s"] - 1.0).abs() < 1e-9, "adev"]
    assert at.iloc[0] == pytest.approx(deviation[0], rel=1e-9)


@pytest.mark.slow
def test_a_line_is_named_and_does_not_distort():
    t = np.arange(N_SAMPLES) / RATE
    clean = noise(3)
    # As strong as the noise itself: the deviation at 1 s is many times that of white noise.
    disturbed = clean + 4e-3 * np.sin(2 * np.pi * 0.5 * t)
    plain, found = (characterise(log_of(x)).channels[0] for x in (clean, disturbed))
    assert found.inspection.lines[0].peak == pytest.approx(0.5, abs=0.02)
    assert found.inspection.lines[0].deviation == pytest.approx(4e-3 / math.sqrt(2), rel=0.05)
    for term in "NB":
        assert found.fit[term].value == pytest.approx(plain.fit[term].value, rel=0.03)
    assert "0.5" in next(f.text for f in found.inspection.findings if f.kind == "line")
    # Control: the log as recorded shows it, and a fit to that curve is wrong.
    ratio = found.curve.deviation / plain.curve.deviation
    assert ratio.max() > 1.5
    assert abs(fit_noise(found.curve)["N"].value / plain.fit["N"].value - 1.0) > 0.05


@pytest.mark.slow
def test_white_noise_has_no_lines():
    for seed in range(20):
        assert not find_lines(spectrum_of(noise(seed), RATE))


def test_spikes_are_named_and_do_not_distort():
    clean = noise(4)
    disturbed = clean.copy()
    disturbed[np.random.default_rng(5).choice(N_SAMPLES, 30, replace=False)] += 0.5
    plain, found = (characterise(log_of(x)) for x in (clean, disturbed))
    assert kinds(found) - kinds(plain) == {"spikes"}
    after, before = found.channels[0], plain.channels[0]
    assert after.fit["N"].value == pytest.approx(before.fit["N"].value, rel=1e-3)
    assert after.fit["B"].value == pytest.approx(before.fit["B"].value, rel=0.02)
    # Control: as recorded they raise the shortest clusters.
    assert after.curve.deviation[0] > 1.3 * before.curve.deviation[0]


def test_noise_that_is_not_gaussian_is_not_taken_for_spikes():
    samples = 1e-3 * np.random.default_rng(6).standard_t(2.5, N_SAMPLES)
    found = characterise(log_of(samples))
    assert "outliers" in kinds(found)
    assert found.channels[0].inspection.samples is samples


@pytest.mark.slow
def test_quantisation_steps_are_found():
    step = 2e-3
    found = characterise(log_of(np.round(noise(7) / step) * step))
    assert found.channels[0].inspection.resolution == pytest.approx(step, rel=1e-6)
    assert parse(
        str(YAML(typ="safe").load(sensor_file(found))["accelerometer"]["resolution"]),
        KINDS["acceleration"],
    ) == pytest.approx(step, rel=1e-5)
    coarse = characterise(log_of(np.round((noise(7) + 0.01) / 0.03) * 0.03))
    assert "not to be trusted" in " ".join(f.text for f in coarse.findings)
    assert characterise(log_of(noise(7))).channels[0].inspection.resolution is None


def test_handling_is_named():
    samples = noise(8)
    samples[70_000:70_200] += 0.045 * np.sin(np.arange(200.0))
    found = characterise(log_of(samples))
    text = next(f.text for f in found.findings if f.kind == "handling")
    assert "the first 1400 s" in text
    assert any("--start and --end" in sentence for sentence in verdict(found))


@pytest.mark.parametrize(
    ("samples", "element", "message"),
    [
        (noise(1)[:999], "accelerometer", "too short"),
        (np.full(N_SAMPLES, 0.3), "gyroscope", "is constant"),
        (noise(1) + np.linspace(0, 9, N_SAMPLES), "accelerometer", "moves or is handled"),
        (noise(1) + 1.0, "gyroscope", "turns at 57"),
        (noise(1) * np.repeat([1, 1, 1, 1, 9], N_SAMPLES // 5), "gyroscope", "--end 1600"),
    ],
)
def test_logs_that_tell_nothing_are_refused(samples, element, message):
    with pytest.raises(InputError, match=message):
        characterise(log_of(samples, element=element))


def test_fits_without_points_are_refused():
    with pytest.raises(InputError, match="at least 6"):
        characterise(log_of(noise(1)), Settings(fit_range=(1.0, 1.5)))


@pytest.mark.slow
def test_a_gauss_markov_bias_stands_in_the_sensor_file(tmp_path):
    rng = np.random.default_rng(10)
    samples = gauss_markov(20.0, 0.004, RATE, 3 * N_SAMPLES, rng)
    samples += noise(11, (1e-3, 0.0, 0.0), 3 * N_SAMPLES)
    path = tmp_path / "sensor.yaml"
    found = characterise(log_of(samples))
    path.write_text(sensor_file(found), encoding="utf-8")
    block = loaded(path)["accelerometer"]
    assert "bias_instability" not in block
    deviation = parse(block["gauss_markov"]["deviation"], KINDS["acceleration"])
    assert deviation == pytest.approx(0.004, rel=0.2)
    time = parse(block["gauss_markov"]["correlation_time"], KINDS["time"])
    assert time == pytest.approx(20.0, rel=0.35)
    n = parse(block["velocity_random_walk"], KINDS["velocity random walk"])
    assert n == pytest.approx(1e-3, rel=0.01)
    fit = found.channels[0].fit
    assert fit["N"].low < 1e-3 < fit["N"].high
    assert fit["N"].high - fit["N"].low < 2e-5
    # Control: with flicker and random walk in its place the same N is off.
    straight = fit.squares[1] ** 0.5
    assert abs(straight / 1e-3 - 1.0) > 0.02
    assert number(fit, "accelerometer", "K") == "Gauss-Markov"
    told = verdict(found)
    assert any("A Gauss-Markov bias explains accel_x" in sentence for sentence in told)
    assert not any("random walk does not clearly show" in sentence for sentence in told)


@pytest.mark.slow
def test_a_ramp_is_named_kept_and_no_bias():
    samples = noise(12, (1e-3, 0.0, 0.0)) + 5e-6 * np.arange(N_SAMPLES) / RATE
    found = characterise(log_of(samples))
    text = next(finding.text for finding in found.findings if finding.kind == "ramp")
    assert "the output drifts by a ramp R of " in text
    assert float(text.split("ramp R of ")[1].split()[0]) == pytest.approx(5e-6, rel=0.1)
    assert "rate_ramp: " in sensor_file(found)
    assert sum("ramp" in sentence for sentence in verdict(found)) == 1
    # Its autocorrelation is the log's length: no bias to be tracked.
    assert found.channels[0].bias is None
    assert "bias" not in kinds(found)
    # The band is that of noise beside a ramp, which is well known.
    assert found.channels[0].high[-1] < 1.2 * found.channels[0].low[-1]
    assert "ramp" not in kinds(characterise(log_of(noise(12, (1e-3, 0.0, 0.0)))))


@pytest.mark.slow
def test_axes_of_a_sensor_file_keep_what_is_theirs(tmp_path):
    """A process of one axis is not spread over those that have none."""
    rng = np.random.default_rng(10)
    wandering = gauss_markov(20.0, 0.004, RATE, 3 * N_SAMPLES, rng)
    wandering += noise(11, (1e-3, 0.0, 0.0), 3 * N_SAMPLES)
    walking = noise(12, (1e-3, 0.0, 2e-4), 3 * N_SAMPLES)
    found = characterise(log_of(wandering, walking, walking))
    (tmp_path / "mine.yaml").write_text(sensor_file(found), encoding="utf-8")
    process = found.channels[0].fit.gauss_markov
    tree = {**BASE, "sensors": {**BASE["sensors"], "accelerometer": "mine.yaml"}}
    errors = Scenario.from_dict(tree, folder=tmp_path).base.sensors.accelerometer
    assert errors.gauss_markov.deviation == (pytest.approx(process.model.deviation), 0.0, 0.0)
    assert errors.acceleration_random_walk[0] == 0.0
    assert errors.acceleration_random_walk[1] == pytest.approx(
        found.channels[1].fit["K"].value, rel=1e-5
    )


def test_a_random_walk_says_what_it_could_be():
    found = characterise(log_of(noise(12, (1e-3, 0.0, 2e-4))))
    assert found.channels[0].fit["K"].seen
    assert any("would look the same in this log" in sentence for sentence in verdict(found))
    details = YAML(typ="safe").load(sensor_file(found))["fit"]["accel_x"]
    assert "correlation time above" in details["random_walk_or"]


def test_the_sensor_file_makes_the_fitted_curve():
    """Also where a term is uncertain: left out, the others would make another curve."""
    found = characterise(log_of(noise(17, (1e-3, 1e-4, 0.0))))
    fit = found.channels[0].fit
    assert fit["K"].value > 0.0
    assert not fit["K"].seen
    block = YAML(typ="safe").load(sensor_file(found))
    axis = block["accelerometer"]["axes"]["x"]
    assert "uncertain; below" in block["fit"]["accel_x"]["acceleration_random_walk"]
    n, b, k = (
        parse(axis[key], KINDS[kind])
        for key, kind in (
            ("velocity_random_walk", "velocity random walk"),
            ("bias_instability", "acceleration"),
            ("acceleration_random_walk", "acceleration random walk"),
        )
    )
    tau = found.channels[0].fitted.tau
    tau = tau[(tau >= fit.tau_from) & (tau <= fit.tau_to)]
    flicker = 2.0 * math.log(2.0) / math.pi * b**2
    expected = np.sqrt(n**2 / tau + flicker + k**2 * tau / 3.0)
    assert fit.deviation(tau) == pytest.approx(expected, rel=1e-3)
    # Control: without the uncertain term it is another curve.
    assert np.max(np.abs(np.sqrt(n**2 / tau + flicker) / fit.deviation(tau) - 1.0)) > 0.02


def test_noise_densities_from_deviation_and_spectrum_agree():
    """Eq. (5.1) for an ideal low-pass at half of the rate: ND = σ / √(fs / 2)."""
    samples = noise(12, (1e-3, 0.0, 0.0))
    density = density_from_deviation(float(np.std(samples)), RATE / 2.0)
    assert density == pytest.approx(math.sqrt(2.0) * 1e-3, rel=0.01)
    assert white_floor(spectrum_of(samples, RATE)) == pytest.approx(1e-3, rel=0.02)


IMU_UTILS = """\
%YAML:1.0
---
type: IMU
Gyr:
   unit: " rad/s"
   x-axis: {gyr_n: 1.4e-04, gyr_w: 5.0e-05}
   y-axis: {gyr_n: 1.5e-04, gyr_w: 5.8e-05}
   z-axis: {gyr_n: 1.6e-04, gyr_w: 6.6e-05}
Acc:
   unit: " m/s^2"
   x-axis: {acc_n: 1.9e-03, acc_w: 2.0e-04}
   y-axis: {acc_n: 2.3e-03, acc_w: 2.0e-04}
   z-axis: {acc_n: 1.8e-03, acc_w: 2.0e-04}
"""


def test_ready_parameters_become_a_sensor_as_convert_makes_it(tmp_path, capsys):
    """One reader: the same file has one answer, and that a sensor file."""
    path = tmp_path / "imu_param.yaml"
    path.write_text(IMU_UTILS, encoding="utf-8")
    out = ["--output", str(tmp_path / "out")]
    told = ["--noise-convention", "continuous", "--walk-convention", "allan-minimum"]
    assert exit_code(["characterise", str(path), *out, *told]) == 0
    assert "two-sided" in capsys.readouterr().out
    sensor = loaded(tmp_path / "out" / "sensor.yaml")
    asked = ["--assume", "n=continuous", "--assume", "w=allan_minimum", "--to", "allan"]
    assert exit_code(["convert", str(path), *asked]) == 0
    converted = YAML(typ="safe").load(capsys.readouterr().out)
    assert {key: sensor[key] for key in converted} == converted
    assert "imu_param.yaml" in sensor["source"]
    floor = math.sqrt(2.0 * math.log(2.0) / math.pi)
    b = parse(sensor["gyroscope"]["bias_instability"][0], KINDS["angular rate"])
    assert b == pytest.approx(5.0e-5 / floor, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "arguments", "message"),
    [
        (IMU_UTILS, [], "--assume n=continuous"),
        (IMU_UTILS, ["--assume", "n=per_sample", "--assume", "w=ignore"], "--rate"),
        (IMU_UTILS.replace("Acc:", "Mag:"), [], "Mag: is not known here"),
        ("gyroscope_noise_density: 1.0e-3\n", [], "accelerometer_noise_density: is missing"),
        ("case: planar\n", [], "none of the known dialects"),
        ("Gyr:\n   u", [], "is missing"),
    ],
)
def test_ready_parameters_are_refused_in_the_same_words(tmp_path, capsys, text, arguments, message):
    path = tmp_path / "imu.yaml"
    path.write_text(text, encoding="utf-8")
    folder = tmp_path / "out"
    assert exit_code(["characterise", str(path), "--output", str(folder), *arguments]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert not folder.exists()
    assert exit_code(["convert", str(path), *arguments]) == 2
    assert capsys.readouterr().err == said


def test_rates_of_ready_parameters_take_their_unit(tmp_path):
    path = tmp_path / "imu_param.yaml"
    path.write_text(IMU_UTILS, encoding="utf-8")
    arguments = ["characterise", str(path), "--assume", "n=per_sample", "--assume", "w=ignore"]
    for rate in ("400", "400 Hz", "0.4 kHz"):
        out = ["--output", str(tmp_path / rate)]
        assert exit_code([*arguments, *out, "--rate", rate]) == 0
        block = loaded(tmp_path / rate / "sensor.yaml")["gyroscope"]
        n = parse(block["angle_random_walk"][0], KINDS["angle random walk"])
        assert n == pytest.approx(1.4e-4 / 20.0)
    assert exit_code([*arguments, *out, "--rate", "-1"]) == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--rate", "60"], "time stamps say 50 Hz"),
        (["--fit-range", "5", "1"], "two ascending times"),
        (["--confidence", "7"], "has no unit"),
        (["--confidence", "4 sigma"], "up to 99.9 %; give --intervals covariance"),
        (["--start", "1990"], "too short"),
        (["--non-existing"], "No such option"),
    ],
)
def test_bad_input_is_one_message_and_nothing_written(csv, tmp_path, capsys, arguments, message):
    folder = tmp_path / "out"
    assert exit_code(["characterise", str(csv), "--output", str(folder), *arguments]) == 2
    err = capsys.readouterr().err
    assert message in err
    assert "Traceback" not in err
    assert not folder.exists()


@pytest.mark.slow
def test_channels_do_not_depend_on_one_another():
    """They are analysed at the same time, each with the same blocks."""
    samples = [noise(k, n=20_000) for k in range(3)]
    together = characterise(log_of(*samples)).channels
    for axis, result in zip(samples, together, strict=True):
        assert characterise(log_of(axis)).channels[0].fit.coefficients == result.fit.coefficients
    # Control: their logs differ, and so do their results.
    assert together[0].fit.coefficients != together[1].fit.coefficients


def test_a_doubtful_rate_is_in_the_verdict(tmp_path):
    """Seconds that hold milliseconds: 100 Hz turn into 0.1 Hz, which some log may have."""
    path = tmp_path / "log.csv"
    table = pd.DataFrame({"t [s]": np.arange(2000) * 10.0, "ax [m/s^2]": noise(1, n=2000)})
    table.to_csv(path, index=False)
    told = " ".join(verdict(characterise(read_log(path))))
    assert "The time stamps say 0.1 Hz, an unusual rate" in told
    assert "unusual" not in " ".join(verdict(characterise(read_log(path, ReadOptions(rate=0.1)))))


def test_a_log_of_one_row_is_one_message(tmp_path, capsys):
    for text in ("t [s],ax [m/s^2]\n0,1\n", "ax [m/s^2]\n1\n"):
        path = tmp_path / "log.csv"
        path.write_text(text)
        folder = tmp_path / "out"
        arguments = ["characterise", str(path), "--rate", "100", "--output", str(folder)]
        assert exit_code([*arguments, "--quiet"]) == 2
        error = capsys.readouterr().err
        assert "1 row" in error or "1 sample, 0.01 s: too short" in error
        assert len(error.strip().splitlines()) == 1
        assert not folder.exists()


def test_help_is_instant():
    """No heavy module is imported by the command's definition."""
    code = (
        "import sys; from mcsim.cli.main import exit_code; exit_code(['characterise', '--help']);"
        "heavy = {'numba', 'numpy', 'scipy', 'pandas', 'matplotlib'};"
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ
    )
    assert done.stdout.rstrip().endswith("[]")
    assert "two-sided" in done.stdout


@pytest.mark.slow
def test_slow_noise_has_no_lines_either():
    """Steep spectra: the floor must follow flicker and random walk."""
    for seed in range(20):
        assert not find_lines(spectrum_of(noise(seed, (1e-3, 3e-3, 1e-3)), RATE))


def test_lines_of_short_logs_are_found():
    samples = noise(2, n=5000) + 0.05 * np.sin(np.arange(5000) * 2 * np.pi * 3.0 / RATE)
    found = characterise(log_of(samples))
    assert found.channels[0].inspection.lines[0].peak == pytest.approx(3.0, abs=0.1)
    assert found.channels[0].fit["N"].value == pytest.approx(ACCEL[0], rel=0.1)
    assert any("short" in sentence for sentence in verdict(found))


@pytest.mark.slow
def test_a_log_without_noise_does_not_break():
    found = characterise(log_of(1e-6 * np.arange(20_000.0)))
    assert np.all(np.isfinite(found.channels[0].high))
    # Nearly all blocks of this one hold nothing; of the other every second cluster is the same.
    steps = np.zeros(20_000)
    steps[[100, 5000, 9000]] = 1e-3
    for samples in (steps, 1e-3 * (np.arange(20_000) % 2)):
        fit = characterise(log_of(samples)).channels[0].fit
        assert all(np.isfinite([c.low, c.high]).all() for c in fit.coefficients.values())


@pytest.mark.slow
def test_a_characterised_sensor_converts_to_other_dialects(output, capsys):
    arguments = ["convert", str(output / "sensor.yaml"), "--to", "matlab"]
    assert exit_code(arguments) == 0
    assert "NoiseDensity" in capsys.readouterr().out
