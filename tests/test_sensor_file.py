"""Sensor files: what the tools write can be read, in every case; what is wrong has its place."""

import numpy as np
import pytest

from mcsim import InputError, Scenario
from mcsim.characterisation.analysis import characterise
from mcsim.characterisation.sensor_file import sensor_file
from mcsim.cli.main import exit_code
from mcsim.logs import Channel, Log, Timing
from mcsim.scenario.sensor_file import file_element, parse_sensor_file
from mcsim.units import KINDS, parse
from mcsim.vibration.scenario import read_vibration
from tests.conftest import scenario
from tests.test_velocity_sensor import scenario as velocity_scenario

G = 9.80665
EVERY = """\
name: "mine"
rate: 100 Hz
accelerometer:
  noise_density: [300 µg/√Hz, 200 µg/√Hz, 100 µg/√Hz]
  turn_on_bias: [1 mg, 2 mg, 3 mg]
  gauss_markov: {deviation: [1 mg, 2 mg, 3 mg], correlation_time: 10 s}
  spikes: {rate: 0.1 Hz, amplitude: 1 g}
  range: 4 g
  scale_factor_error: 300 ppm
gyroscope:
  angle_random_walk: [0.1 °/√h, 0.2 °/√h, 0.3 °/√h]
  g_sensitivity: 0.1 °/s/g
"""
VIBRATION = """\
case: vibration
sensor: mine.yaml
rate: 100 Hz
duration: 10 s
excitation: {shape: sweep, first: 1 Hz, last: 10 Hz, amplitude: 1 m/s²}
"""


def written(folder, text, name="mine.yaml"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def in_every_case(path):
    """The accelerometer's block in a planar, a velocity and a vibration scenario."""
    planar = scenario({"sensors.accelerometer": str(path)}).base.sensors.accelerometer
    velocity = velocity_scenario(str(path), sensor__noise=None).base.sensor.accelerometer
    case = written(path.parent, VIBRATION.replace("mine.yaml", str(path)), "case.yaml")
    return planar, velocity, read_vibration(case).sensor


def test_lists_per_axis_are_read_in_every_case(tmp_path):
    path = written(tmp_path, EVERY)
    for block in in_every_case(path):
        assert block.noise_density == tuple(n * 1e-6 * G for n in (300.0, 200.0, 100.0))
        assert block.gauss_markov.deviation == pytest.approx((1e-3 * G, 2e-3 * G, 3e-3 * G))
        assert block.gauss_markov.correlation_time == (10.0,)
        assert block.range == (4 * G,)
    gyroscope = scenario({"sensors.gyroscope": str(path)}).base.sensors.gyroscope
    assert len(gyroscope.angle_random_walk) == 3


@pytest.mark.parametrize(
    ("block", "range_"), [("MPU-9250", 16 * G), ("{model: mpu-9250, range: 3 g}", 3 * G)]
)
def test_a_file_may_name_a_built_in_sensor(tmp_path, block, range_):
    path = written(tmp_path, f"accelerometer: {block}\n")
    by_name = scenario({"sensors.accelerometer": "MPU-9250"}).base.sensors.accelerometer
    for taken in in_every_case(path):
        assert taken.noise_density == by_name.noise_density
        assert taken.bandwidth == by_name.bandwidth
        assert taken.range == (pytest.approx(range_),)
        assert taken.model == str(path)


def test_the_scenarios_own_keys_come_before_the_files(tmp_path):
    path = written(tmp_path, "accelerometer: {model: MPU-9250, velocity_random_walk: 1 m/s/√h}\n")
    block = {"model": str(path), "bandwidth": "5 Hz"}
    taken = scenario({"sensors.accelerometer": block}).base.sensors.accelerometer
    assert taken.noise_density is None
    assert taken.velocity_random_walk == (pytest.approx(1 / 60),)
    assert taken.bandwidth == (5.0,)


@pytest.mark.parametrize("target", ["mcsim", "datasheet", "allan"])
def test_what_convert_writes_is_read(tmp_path, capsys, target):
    path = written(tmp_path, EVERY)
    assert exit_code(["convert", str(path), "--to", target]) == 0
    back = written(tmp_path, capsys.readouterr().out, "back.yaml")
    block, again = (
        scenario({"sensors.accelerometer": str(p)}).base.sensors.accelerometer for p in (path, back)
    )
    density = again.noise_density or np.sqrt(2.0) * np.array(again.velocity_random_walk)
    np.testing.assert_allclose(density, block.noise_density, rtol=1e-12)
    np.testing.assert_allclose(again.gauss_markov.deviation, block.gauss_markov.deviation)
    assert again.scale_factor_error == pytest.approx(block.scale_factor_error)


@pytest.mark.slow
def test_what_characterise_writes_is_read_by_axis(tmp_path, capsys):
    rng = np.random.default_rng(1)
    channels = tuple(
        Channel("accelerometer", axis, scale * rng.standard_normal(20_000))
        for axis, scale in zip("xyz", (0.01, 0.02, 0.03), strict=True)
    )
    log = Log(tmp_path / "log.csv", channels, Timing(100.0, stamped=False))
    path = written(tmp_path, sensor_file(characterise(log)))
    quantities = file_element(path, "accelerometer")
    assert "rate" not in quantities
    n = [parse(text, KINDS["velocity random walk"]) for text in quantities["velocity_random_walk"]]
    # One sample at rate fs has the variance N² fs.
    np.testing.assert_allclose(n, np.array([0.01, 0.02, 0.03]) / 10.0, rtol=0.02)
    for block in in_every_case(path):
        assert block.velocity_random_walk == tuple(n)
    assert exit_code(["convert", str(path), "--to", "mcsim"]) == 0
    assert "velocity_random_walk: [" in capsys.readouterr().out


def test_ready_parameters_with_a_rate_convert(tmp_path, capsys):
    text = "gyroscope_noise_density: 1.0e-3\ngyroscope_random_walk: 1.0e-4\nupdate_rate: 200\n"
    text += "accelerometer_noise_density: 1.0e-2\naccelerometer_random_walk: 1.0e-3\n"
    path = written(tmp_path, text, "imu.yaml")
    out = tmp_path / "out"
    assert exit_code(["characterise", str(path), "--output", str(out)]) == 0
    assert "rate: 200.0 Hz" in (out / "sensor.yaml").read_text(encoding="utf-8")
    capsys.readouterr()
    assert exit_code(["convert", str(out / "sensor.yaml"), "--to", "mcsim"]) == 0
    assert "angle_random_walk: 0.001 rad/√s" in capsys.readouterr().out


def test_axes_that_do_not_all_have_a_value_take_the_one_for_all(tmp_path):
    text = (
        "accelerometer: {noise_density: 2 µg/√Hz, "
        "axes: {x: {noise_density: 1 µg/√Hz}, y: {noise_density: 1 µg/√Hz}}}\n"
    )
    quantities = file_element(written(tmp_path, text), "accelerometer")
    assert quantities == {"noise_density": "2 µg/√Hz"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "mine.yaml: is empty; a sensor file has an `accelerometer:`"),
        ("a: 1", 'mine.yaml:1: a: unknown key "a"'),
        ("name: a", "mine.yaml:1: scenario: describes no sensor"),
        ("[1]", "no `key: value` lines"),
        ("a: [", "mine.yaml:2: "),
        ("accelerometer: {noise_density: 3}", "noise_density: .3. has no unit"),
        (
            "accelerometer:\n  noise_density: 300 µg/√Hz\n  resolutoin: 1 mg",
            'mine.yaml:3: accelerometer.resolutoin: unknown key .*did you mean "resolution"',
        ),
        (
            "accelerometer:\n  noise_density: -300 µg/√Hz",
            "mine.yaml:2: accelerometer.noise_density: .* must be at least 0 µg/√Hz",
        ),
        (
            "accelerometer: {turn_on_bias: [1 mg, -2 mg, 3 mg]}",
            'accelerometer.turn_on_bias.1: "-2 mg" must be at least 0 mg',
        ),
        ("accelerometer: {turn_on_bias: [1 mg, 2 mg]}", "one value, or three"),
        ("gyroscope: {axes: {x: {angle_random_walk: 3 m}}}", r"axes\.x\.angle_random_walk"),
        ("gyroscope: {axes: 3}", "gyroscope.axes: a block of"),
        ("gyroscope: {axes: {q: {angle_random_walk: 3 °/√h}}}", 'unknown key "q"'),
        ("gyroscope: {axes: {x: {angle_random_walk: 3 °/√h}}}", "is written for x only"),
        ("accelerometer: {axes: {x: {model: BNO055}}}", "`model` counts for all axes"),
        ("accelerometer: {axes: {x: {turn_on_bias: [1 mg, 1 mg, 1 mg]}}}", "one value here"),
        ("accelerometer: other.yaml", "cannot name another one"),
        ("accelerometer: MPU-9255", 'did you mean "MPU-9250"'),
    ],
)
def test_bad_sensor_files_are_explained(tmp_path, text, message):
    path = written(tmp_path, text + "\n")
    with pytest.raises(InputError, match=message):
        parse_sensor_file(path.read_text(encoding="utf-8"), path.name)
    # A scenario says so too, with its own place before the file's.
    with pytest.raises(InputError, match=rf"sensors\.accelerometer: .*{message}"):
        scenario({"sensors.accelerometer": str(path)})


def test_absent_files_and_elements_are_named(tmp_path):
    path = written(tmp_path, "gyroscope: LSM330DL\n")
    for given, message in (
        (str(path), "has no accelerometer"),
        (str(tmp_path / "none.yaml"), "no such file"),
        ("/etc/passwd", "the name of a sensor file ends in .yaml"),
        (str(tmp_path), "the name of a sensor file ends in .yaml"),
    ):
        with pytest.raises(InputError, match=message):
            scenario({"sensors.accelerometer": given})


def test_a_changed_file_is_read_anew(tmp_path):
    path = written(tmp_path, "accelerometer: {turn_on_bias: 1 mg}\n")
    assert file_element(path, "accelerometer") == {"turn_on_bias": "1 mg"}
    written(tmp_path, "accelerometer: {turn_on_bias: 2 mg}\n")
    assert file_element(path, "accelerometer") == {"turn_on_bias": "2 mg"}


def test_a_scenario_beside_its_file(tmp_path):
    written(tmp_path, EVERY)
    tree = dict(scenario().document.tree)
    tree["sensors"] = {**tree["sensors"], "accelerometer": "mine.yaml"}
    assert Scenario.from_dict(tree, folder=tmp_path).base.files == ("mine.yaml",)


def test_a_vibration_scenario_finds_the_file_beside_it(tmp_path, monkeypatch):
    written(tmp_path, EVERY)
    path = written(tmp_path, VIBRATION, "case.yaml")
    assert read_vibration(path).sensor.turn_on_bias[2] == pytest.approx(3e-3 * G)
    # What an option names is looked for where the command is given.
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    with pytest.raises(InputError, match=r"--sensor: sensor: mine\.yaml: no such file"):
        read_vibration(path, "mine.yaml")
