"""Every dialect to every other and back: what both hold is the same, what one lacks is said."""

import math
import random
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from mcsim.cli.main import exit_code
from mcsim.dialects import (
    DIALECTS,
    Assumptions,
    Description,
    read_sensor,
    readable,
    writable,
    write_sensor,
)
from mcsim.dialects.bias import FLOOR, PEAK
from mcsim.dialects.description import BIAS_WALK, DEVIATION, ELEMENTS, RANDOM_WALK, three, two_sided
from mcsim.errors import InputError
from mcsim.units import KINDS, parse

ANSWERS = Assumptions({"RandomWalk": "K", "corrtime": "gyroscope"}, 100.0, "largest")
EXAMPLE = Path(__file__).parent.parent / "docs" / "examples" / "lab_sheet.py"
#: What mcsim's own dialects are read as.
OWN = {"datasheet": "mcsim", "allan": "mcsim"}
#: What the first does not know, and the second needs.
REFUSED = {
    **dict.fromkeys([("gnss-ins-sim", "kalibr"), ("kf-gins", "kalibr")], "Allan's K"),
    **dict.fromkeys([("matlab", "gnss-ins-sim"), ("matlab", "kf-gins")], "--assume bias=peak"),
}
TIME = "gauss_markov.correlation_time"


def full_sensor():
    """Of everything that any dialect holds, alike on all axes."""
    elements = {
        element: {
            RANDOM_WALK[element]: (2e-4 * scale,),
            "bias_instability": (3e-5 * scale,),
            BIAS_WALK[element]: (4e-6 * scale,),
            DEVIATION: (5e-5 * scale,),
            TIME: (300.0,),
            "scale_factor_error": (2e-3,),
            "range": (40.0 * scale,),
            "resolution": (1e-3 * scale,),
            "bandwidth": (50.0,),
        }
        for element, scale in zip(ELEMENTS, (1.0, 0.1), strict=True)
    }
    return Description("full", 100.0, elements)


def random_sensor(draw):
    """Some of it, in one value or three, some of them zero."""
    elements = {}
    for element, quantities in full_sensor().elements.items():
        chosen = {}
        for key, (value,) in quantities.items():
            if key in (TIME, DEVIATION) or draw.random() < 0.7:
                number = [float(f"{value * draw.uniform(0.5, 2):.6g}") for _ in "xyz"]
                if key.endswith("walk") and draw.random() < 0.2:
                    number[draw.randrange(3)] = 0.0
                chosen[key] = tuple(number) if draw.random() < 0.4 else (number[0] or value,)
        if draw.random() < 0.3:
            del chosen[DEVIATION], chosen[TIME]
        elements[element] = chosen
    return Description(None, 100.0, elements)


def held(sensor):
    """Nonzero quantities per axis, white noise as N; a process of no deviation has no time."""
    found = {}
    for element, quantities in sensor.elements.items():
        plain = {key: v for key, v in quantities.items() if key != "noise_density"}
        white = two_sided(quantities, element)
        plain |= {RANDOM_WALK[element]: white} if white is not None else {}
        if not any(plain.get(DEVIATION, ())):
            plain.pop(TIME, None)
        found |= {f"{element}.{key}": three(v) for key, v in plain.items() if any(v)}
    return found


def travel(sensor, name, answers=ANSWERS):
    """The sensor written in a dialect and read again; its text too."""
    text = write_sensor(sensor, name, answers)
    return read_sensor(text, name, OWN.get(name, name), answers).description, text


def same(first, second):
    """Within what unit conversions leave of the last digits; per axis, or its largest."""
    return first == pytest.approx(second, rel=1e-13) or first == pytest.approx(
        [max(second)] * 3, rel=1e-13
    )


def check(sensor, there):
    """The sensor after the trip holds nothing that it did not; what it lost is written down."""
    before = held(sensor)
    away, text = travel(sensor, there)
    after = held(away)
    times = {key for key in after if key.endswith(TIME)}
    assert set(after) <= set(before)
    for key in set(after) - times:
        assert same(after[key], before[key]), (there, key)
    said = [line for line in text.splitlines() if "not carried over" in line]
    for key in set(before) - set(after):
        element, _, name = key.partition(".")
        assert any(f"{element}, not carried" in line and name in line for line in said), key
    return away


@pytest.mark.parametrize("home", writable())
@pytest.mark.parametrize("there", writable())
def test_every_dialect_to_every_other_and_back(home, there):
    at_home, text = travel(full_sensor(), home)
    assert check(full_sensor(), home) == at_home
    if (home, there) in REFUSED:
        with pytest.raises(InputError, match=REFUSED[home, there]):
            check(at_home, there)
        return
    away = check(at_home, there)
    if set(held(away)) == set(held(at_home)):
        back, text_back = travel(away, home)
        assert same_all(held(back), held(at_home))
        body = [line for line in text.splitlines() if "not carried over" not in line]
        assert [w for w in text_back.splitlines() if w in body]


def same_all(first, second):
    return set(first) == set(second) and all(same(first[key], second[key]) for key in first)


@pytest.mark.slow
@pytest.mark.parametrize("there", writable())
def test_random_sensors_arrive_whole_or_are_refused(there):
    draw = random.Random(8)
    arrived, reasons = 0, []
    for _ in range(60):
        sensor = random_sensor(draw)
        try:
            away = check(sensor, there)
        except InputError as error:
            # The two reasons: a white noise or K that Kalibr needs, a bias that is no process.
            reasons += ["Kalibr needs" in str(error) or "bias instability" in str(error)]
            continue
        arrived += 1
        again, _ = travel(away, there)
        assert same_all(held(again), held(away))
    assert arrived >= 10
    assert all(reasons)


def test_the_table_lists_what_can_be_read_and_written():
    assert set(readable()) | set(writable()) == set(DIALECTS)
    for name in readable():
        assert DIALECTS[name].recognises is not None
    for name in set(readable()) & set(writable()):
        text = write_sensor(full_sensor(), name, ANSWERS)
        recognised = [d.name for d in DIALECTS.values() if d.recognises and d.recognises(text)]
        assert recognised == [name]


def bias_only():
    return read_sensor(
        "accelerometer: {noise_density: 0.2 mg/√Hz, bias_instability: [0.2 mg, 0.1 mg, 0.3 mg]}\n"
        "gyroscope: {noise_density: 0.012 °/s/√Hz, bias_instability: 12 °/h}\n",
        "file",
        None,
        Assumptions(),
    ).description


@pytest.mark.parametrize("tool", ["kf-gins", "gnss-ins-sim"])
def test_a_bias_instability_is_never_written_as_zero(tool):
    with pytest.raises(InputError, match=r"--assume bias=deviation.*\n.*--assume bias=peak"):
        write_sensor(bias_only(), tool, Assumptions())
    with pytest.raises(InputError, match="--assume 'correlation_time=1 h'"):
        write_sensor(bias_only(), tool, Assumptions({"bias": "peak"}))
    for convention, scale in (("deviation", 1.0), ("peak", FLOOR / PEAK)):
        answers = Assumptions({"bias": convention, "correlation_time": "1 h"})
        away, text = travel(bias_only(), tool, answers)
        for element, quantities in bias_only().elements.items():
            expected = [scale * b for b in three(quantities["bias_instability"])]
            assert away.elements[element][DEVIATION] == pytest.approx(expected, rel=1e-12)
            assert set(away.elements[element][TIME]) == {3600.0}
        assert "B of the bias instability" in text
    left, text = travel(bias_only(), tool, Assumptions({"bias": "none"}))
    assert not any(key.endswith(DEVIATION) for key in held(left))
    assert "left out as stated" in text


def test_the_peak_of_a_gauss_markov_process():
    """Largest Allan deviation over the deviation, from the published Allan variance."""

    def variance(x):
        return 2 / x * (1 - (3 - 4 * math.exp(-x) + math.exp(-2 * x)) / (2 * x))

    best = minimize_scalar(lambda x: -variance(x), bounds=(1, 3), method="bounded")
    assert math.sqrt(-best.fun) == pytest.approx(PEAK, rel=1e-9)
    assert best.x == pytest.approx(1.89, abs=0.01)


def gnss_ins_sim_bias(deviation, correlation_time, rate, n, former, seed):
    """The recursion of its pathgen.bias_drift, of one axis; since and before February 2021."""
    noise = np.random.default_rng(seed).standard_normal(n)
    step = 1.0 / rate / correlation_time
    gain = deviation / rate if former else deviation * math.sqrt(1.0 - math.exp(-2.0 * step))
    bias = np.zeros(n)
    for k in range(1, n):
        bias[k] = (1.0 - step) * bias[k - 1] + gain * noise[k]
    return bias


def test_what_gnss_ins_sim_simulates():
    """Its own recursion: b_stability is the deviation; it was not before February 2021."""
    text = (
        "e = {'gyro_arw': [0, 0, 0], 'accel_vrw': [0, 0, 0], 'accel_b_corr': [0.5, 0.5, 0.5],\n"
        "     'accel_b_stability': [2e-3, 2e-3, 2e-3]}"
    )
    for answers, former in (({}, False), ({"b_stability": "driving"}, True)):
        assumptions = Assumptions(answers, 50.0)
        sensor = read_sensor(text, "file", None, assumptions).description
        expected = sensor.elements["accelerometer"][DEVIATION][0]
        bias = gnss_ins_sim_bias(2e-3, 0.5, 50.0, 200_000, former, 7)
        # 200,000 samples are 4000 correlation times: 1.6 % of the deviation at one sigma; dt/4Tc
        # is 1 % here.
        assert np.std(bias[500:]) == pytest.approx(expected, rel=0.05)
    assert expected == pytest.approx(2e-3 * 0.0711, rel=0.01)  # control: far from 2e-3


AXES = """\
rate: 200 Hz
accelerometer:
  velocity_random_walk: [0.1 m/s/√h, 0.2 m/s/√h, 0.3 m/s/√h]
  acceleration_random_walk: [10 m/s/h^1.5, 0 m/s/h^1.5, 5 m/s/h^1.5]
gyroscope:
  angle_random_walk: [0.2 °/√h, 0.1 °/√h, 0.1 °/√h]
  rate_random_walk: [10 °/h^1.5, 20 °/h^1.5, 30 °/h^1.5]
"""


def kalibr(text, *arguments, tmp_path):
    path = tmp_path / "sensor.yaml"
    path.write_text(text, encoding="utf-8")
    return exit_code(["convert", str(path), "--to", "kalibr", *arguments])


def test_kalibr_gets_the_axis_asked_for(tmp_path, capsys):
    """A K that is zero on one axis is that axis' business."""
    for axis, k in (("x", "10 m/s/h^1.5"), ("z", "5 m/s/h^1.5"), ("largest", "10 m/s/h^1.5")):
        assert kalibr(AXES, "--axis", axis, tmp_path=tmp_path) == 0
        text = capsys.readouterr().out
        sensor = read_sensor(text, "file", None, Assumptions()).description
        found = sensor.elements["accelerometer"]["acceleration_random_walk"]
        assert found == (pytest.approx(parse(k, KINDS["acceleration random walk"])),)
        assert sensor.rate == 200.0
    assert kalibr(AXES, "--axis", "y", tmp_path=tmp_path) == 2
    assert "it is zero on axis y, choose another one" in capsys.readouterr().err
    assert kalibr(AXES, tmp_path=tmp_path) == 2
    assert "--axis x, y, z or largest" in capsys.readouterr().err
    assert (
        kalibr(
            AXES.replace("[10 m/s/h^1.5, 0 m/s", "[0 m/s/h^1.5, 0 m/s").replace(
                "5 m/s/h", "0 m/s/h"
            ),
            "--axis",
            "x",
            tmp_path=tmp_path,
        )
        == 2
    )
    assert "this sensor gives none" in capsys.readouterr().err


def test_the_rate_is_that_of_the_file_or_of_its_elements(tmp_path, capsys):
    bare = AXES.partition("\n")[2]
    both = bare.replace("r:\n", "r:\n  rate: 200 Hz\n").replace("e:\n", "e:\n  rate: 200 Hz\n")
    assert kalibr(both, "--axis", "x", tmp_path=tmp_path) == 0
    assert "update_rate: 200.0" in capsys.readouterr().out
    differ = both.replace("200 Hz", "100 Hz", 1)
    assert kalibr(differ, "--axis", "x", tmp_path=tmp_path) == 2
    assert "--rate" in capsys.readouterr().err
    for rate in ("100 Hz", "200 Hz"):
        assert kalibr(differ, "--axis", "x", "--rate", rate, tmp_path=tmp_path) == 0
        assert f"update_rate: {rate[:3]}.0" in capsys.readouterr().out
    assert kalibr(AXES, "--axis", "x", "--rate", "100 Hz", tmp_path=tmp_path) == 2
    assert "its rate is 200 Hz, and --rate says 100 Hz" in capsys.readouterr().err


@pytest.fixture
def lab_sheet():
    """Runs a command line with the dialect of the example, and forgets it again."""

    def run(*arguments):
        try:
            return exit_code(["--with", str(EXAMPLE), *map(str, arguments)])
        finally:
            DIALECTS.remove("lab-sheet")

    return run


SHEET = "SENSOR mine\nARW 0.2  # by the oven\nVRW 0.03\n"


def test_a_dialect_of_ones_own_is_converted_there_and_back(lab_sheet, tmp_path, capsys):
    file = tmp_path / "mine.sheet"
    file.write_text(SHEET)
    assert lab_sheet("convert", file, "--to", "mcsim") == 0
    own = tmp_path / "mine.yaml"
    own.write_text(capsys.readouterr().out)
    # Allan's N of 0.2 °/√h is 0.2 π / 180 / 60 rad/√s.
    assert f"{0.2 * math.pi / 10800:.6g}"[:6] in own.read_text()
    assert lab_sheet("convert", own, "--to", "lab-sheet") == 0
    text = capsys.readouterr().out
    assert text.startswith("# sheet of the laboratory: ARW and VRW are Allan's N")
    assert "SENSOR mine" in text
    assert float(text.split("ARW ")[-1].split()[0]) == pytest.approx(0.2, rel=1e-12)
    own.write_text("gyroscope: {noise_density: 1 °/s/√Hz, bias_instability: 3 °/h}\n"
                   "accelerometer: {noise_density: 1 mg/√Hz}\n")  # fmt: skip
    assert lab_sheet("convert", own) == 0
    told = capsys.readouterr().out
    assert "# --to lab-sheet\n" in told
    assert "gyroscope, not carried over: bias_instability" in told


def test_a_dialect_of_ones_own_is_characterised(lab_sheet, tmp_path, capsys):
    file = tmp_path / "mine.sheet"
    file.write_text(SHEET)
    assert lab_sheet("characterise", file, "--output", tmp_path / "out", "--quiet") == 0
    assert "angle_random_walk: 0.2 °/√h" in (tmp_path / "out" / "sensor.yaml").read_text()
    file.write_text("ARW much\nVRW 1\n")
    assert lab_sheet("characterise", file) == 2
    assert "mine.sheet: needs a line such as `ARW 0.2`" in capsys.readouterr().err


def test_a_dialect_of_ones_own_is_offered(lab_sheet, capsys):
    assert lab_sheet("convert", "0.2 °/√h", "--to", "lab-sheet") == 0
    assert "ARW 0.2" in capsys.readouterr().out
    assert lab_sheet("convert", "--help") == 0
    assert "lab-sheet" in capsys.readouterr().out
    assert exit_code(["convert", "0.2 °/√h", "--to", "lab-sheet"]) == 2
    assert '"lab-sheet" is not one of mcsim, datasheet' in capsys.readouterr().err
