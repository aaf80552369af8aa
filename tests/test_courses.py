"""Coefficients drawn once times a known course: closed forms of non-linearity and temperature."""

import json
import math

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.signal import find_peaks

from mcsim import InputError, Scenario
from mcsim.scenario.document import parse_document
from mcsim.scenario.sensor_block import AccelerometerErrors
from mcsim.scenario.temperature import Temperature
from mcsim.scenario.validation import validate
from mcsim.sensor_terms.channel import ACCELEROMETER, Channel
from mcsim.sensors.error_model import Conditions, element_errors
from mcsim.sensors.simulated_log import SimulatedLog
from mcsim.systems import problem_of
from mcsim.units import STANDARD_GRAVITY
from tests import conftest, strapdown
from tests.conftest import NO_NOISE
from tests.test_velocity import FOLDER
from tests.test_velocity_sensor import KNOWN

RATE = 1000.0
#: A level road, without any other error; leads are part of the run.
STRAIGHT = {
    **NO_NOISE,
    "trajectory": {"shape": "straight", "length": "600 m", "speed": "20 m/s", "lead": "0 s",
                   "deceleration": "0 m/s²"},
    "sensors.sampling": "none",
    "reconstruction.integration": "trapezoidal",
}  # fmt: skip
BRAKING = {
    **STRAIGHT,
    "trajectory": {"shape": "straight", "length": "150 m", "speed": "20 m/s", "lead": "0 s",
                   "deceleration": "1.2 m/s²"},
}  # fmt: skip
#: Per kelvin, in m/s² and rad/s.
OFFSET = {"sensors.accelerometer.temperature_offset": "1e-3 m/s²/K"}
TURN = {"sensors.gyroscope.temperature_offset": "1e-4 rad/s/K"}


def parsed(block, model):
    return validate(parse_document(json.dumps(block, ensure_ascii=False)), model)


def log_of(block, signal, seed=3, temperature=None, pieces=1):
    """What one axis would write of a signal (n,)."""
    own = {ACCELEROMETER: parsed(block, AccelerometerErrors)}
    given = parsed(temperature, Temperature) if temperature else None
    errors = element_errors(
        own, RATE, [Channel(ACCELEROMETER, 0)], 1.0, conditions=Conditions(temperature=given)
    )
    log = SimulatedLog(errors, seed)
    parts = np.array_split(np.asarray(signal, float)[:, None], pieces)
    return np.concatenate([log.measure(part) for part in parts])[:, 0]


def deviation(p, error):
    """Of an error at the end, by the linear model."""
    return math.sqrt(sum(v[p.error_names.index(error)] for v in p.linear.variances.values()))


def simulated(p, error, count=4000):
    errors = p.simulate(5, 0, count).errors[p.error_names.index(error)]
    return float((errors - p.method_errors()[p.error_names.index(error)]).std())


def duration(p):
    return p.n_samples * p.interval


# Shapes


def largest_from_a_line(values, places):
    """Of all straight lines the one that values (n,) leave least: linear programming."""
    ones = np.ones_like(places)
    a = np.stack([places, ones], axis=1)
    within = np.vstack([np.column_stack([a, -ones]), np.column_stack([-a, -ones])])
    return linprog([0, 0, 1], within, np.append(values, -values), bounds=[(None, None)] * 3).fun


@pytest.mark.parametrize(("key", "power"), [("quadratic", 2), ("cubic", 3)])
def test_a_non_linearity_is_the_distance_from_the_best_straight_line(key, power):
    """In per cent of full scale, as data sheets print it; offset and slope at zero stay."""
    full = 20.0
    places = np.linspace(-full, full, 2001)
    block = {f"{key}_nonlinearity": {"deviation": "0.5 %", "full_scale": f"{full} m/s²"}}
    errors = np.array([log_of(block, places, seed) - places for seed in range(400)])
    shape = (places / full) ** power
    drawn = errors[:, -1]
    np.testing.assert_allclose(errors, np.outer(drawn, shape), atol=1e-12)
    largest = largest_from_a_line(shape, places)
    assert largest == pytest.approx(0.5 ** (power - 1), rel=1e-3)
    # 5 sigma of a deviation from 400 draws: 18 %.
    assert drawn.std() * largest == pytest.approx(0.005 * full, rel=0.18)
    # The control: the value for the distance from a line through the ends.
    through_ends = np.abs(shape - np.polyval([shape[-1] if power == 3 else 0, 1 - power % 2],
                                             places / full)).max()  # fmt: skip
    assert abs(drawn.std() * through_ends / (0.005 * full) - 1.0) > 0.3


def harmonics(values):
    """Amplitudes of the mean, the first, second and third harmonic of ten periods."""
    spectrum = np.fft.rfft(values) / len(values)
    return np.abs(spectrum[[0, 10, 20, 30]]) * [1, 2, 2, 2]


def test_the_harmonics_of_a_sinusoid_are_those_of_its_powers():
    """k a²/2 as a bias and at twice the frequency; k a³/4 at three times, 3 k a³/4 at one."""
    a, full = 12.0, 20.0
    tone = a * np.sin(2 * np.pi * np.arange(1000) * 10 / 1000)
    for key, power in (("quadratic", 2), ("cubic", 3)):
        block = {f"{key}_nonlinearity": {"deviation": "1 %", "full_scale": f"{full} m/s²"}}
        k = abs(log_of(block, np.array([1.0]))[0] - 1.0)
        found = harmonics(log_of(block, tone) - tone)
        square = [k * a**2 / 2, 0, k * a**2 / 2, 0]
        cube = [0, 0.75 * k * a**3, 0, 0.25 * k * a**3]
        np.testing.assert_allclose(found, square if power == 2 else cube, atol=1e-10)
        # The control: the other power's harmonics.
        assert np.abs(found - (cube if power == 2 else square)).max() > 0.1 * found.max()


def test_asymmetry_rectifies():
    """The scale factors differ by it, and a sinusoid of amplitude a gains the mean e a / π."""
    tone = 3.0 * np.sin(2 * np.pi * np.arange(1000) * 10 / 1000)
    block = {"scale_factor_asymmetry": "2 %"}
    up, down = log_of(block, np.array([1.0, -1.0]))
    e = up - abs(down)
    error = log_of(block, tone) - tone
    assert error.mean() == pytest.approx(e * 3.0 / math.pi, rel=1e-3)
    peaks, _ = find_peaks(np.abs(error))
    assert len(peaks) == 20
    # The control: a scale factor's error has no mean.
    scaled = log_of({"scale_factor_error": "2 %"}, tone) - tone
    assert abs(scaled.mean()) < 1e-12
    spread = [
        np.subtract(*np.abs(log_of(block, np.array([1.0, -1.0]), seed))) for seed in range(400)
    ]
    assert np.std(spread) == pytest.approx(0.02, rel=0.18)


def test_second_order_errs_in_a_bend_as_its_square():
    """Braking at a for t: k a² t²/2; the turn of a constant rate w: k w² t."""
    full, share = 20.0, 0.01
    block = {"deviation": "1 %", "full_scale": f"{full} m/s²"}
    p = conftest.problem({**BRAKING, "sensors.accelerometer.quadratic_nonlinearity": block})
    expected = 2 * share / full * 1.2**2 * duration(p) ** 2 / 2
    assert deviation(p, "along") == pytest.approx(expected, rel=2e-3)  # half a sample at the stop
    assert simulated(p, "along") == pytest.approx(expected, rel=5 / math.sqrt(2 * 4000))
    cubic = conftest.problem({**BRAKING, "sensors.accelerometer.cubic_nonlinearity": block})
    third = 4 * share / full**2 * 1.2**3 * duration(p) ** 2 / 2
    assert deviation(cubic, "along") == pytest.approx(third, rel=2e-3)


# Temperature


def test_the_course_of_a_temperature_is_the_sum_of_its_parts():
    block = {
        "difference": "5 K",
        "ramp": "2 K/min",
        "warm_up": "12 K",
        "time_constant": "3 min",
        "points": [
            {"time": "0 s", "difference": "0 K"},
            {"time": "60 s", "difference": "6 K"},
            {"time": "120 s", "difference": "-6 K"},
        ],
        "on_before": "10 s",
    }
    t = np.array([0.0, 20.0, 50.0, 80.0, 500.0])
    on = t + 10.0
    points = np.array([1.0, 3.0, 6.0, 0.0 - 6.0 * 0.5, -6.0])
    points[3] = 6.0 - 12.0 * 0.5
    expected = 5.0 + on / 30.0 + 12.0 * (1.0 - np.exp(-on / 180.0)) + points
    np.testing.assert_allclose(parsed(block, Temperature).at(t), expected, rtol=1e-12)


def course_cases():
    """Courses, and their double and single integrals from zero to t, less nothing at rest."""
    return {
        "constant": ({"difference": "20 K"}, lambda t: 10 * t**2, lambda t: 20 * t),
        "ramp": ({"ramp": "30 K/min"}, lambda t: 0.5 * t**3 / 6, lambda t: 0.25 * t**2),
        "on before": (
            {"ramp": "30 K/min", "on_before": "4 s"},
            lambda t: 0.5 * (t**3 / 6 + 2 * t**2),
            lambda t: 0.5 * (0.5 * t**2 + 4 * t),
        ),
        "warm-up": (
            {"warm_up": "15 K", "time_constant": "12 s"},
            lambda t: 15 * (t**2 / 2 - 12 * t + 144 * (1 - np.exp(-t / 12))),
            lambda t: 15 * (t - 12 * (1 - np.exp(-t / 12))),
        ),
    }


@pytest.mark.parametrize("name", course_cases())
def test_offsets_by_temperature_err_as_their_integrals(name):
    """c ΔT t²/2, c k t³/6 and so on; the heading by c ΔT t."""
    course, twice, once = course_cases()[name]
    p = conftest.problem({**STRAIGHT, **OFFSET, **TURN, "sensors.temperature": course})
    t = duration(p)
    assert t == pytest.approx(30.0)
    assert deviation(p, "along") == pytest.approx(1e-3 * twice(t), rel=1e-5)
    assert deviation(p, "heading") == pytest.approx(1e-4 * once(t), rel=1e-5)
    assert simulated(p, "along") == pytest.approx(1e-3 * twice(t), rel=5 / math.sqrt(2 * 4000))
    # The control: the other courses.
    others = [other(t) for key, (_, other, _) in course_cases().items() if key != name]
    assert min(abs(other / twice(t) - 1.0) for other in others) > 0.05


def test_a_scale_factor_by_temperature_acts_on_the_signal():
    heat = {"sensors.temperature": {"difference": "25 K"}}
    p = conftest.problem(
        {**BRAKING, **heat, "sensors.accelerometer.temperature_scale": "100 ppm/K"}
    )
    expected = 25 * 1e-4 * 1.2 * duration(p) ** 2 / 2
    assert deviation(p, "along") == pytest.approx(expected, rel=2e-3)  # half a sample at the stop
    level = conftest.problem(
        {**STRAIGHT, **heat, "sensors.accelerometer.temperature_scale": "100 ppm/K"}
    )
    assert deviation(level, "along") < 1e-9


def test_a_calibration_takes_away_the_temperature_that_it_saw():
    """A constant one goes with the bias; of a ramp, its rise since the middle of the rest stays."""
    rest = {"sensors.calibration": {"duration": "10 s"}}
    constant = {"sensors.temperature": {"difference": "20 K"}}
    p = conftest.problem({**STRAIGHT, **OFFSET, **constant, **rest})
    assert deviation(p, "along") < 1e-12
    assert np.abs(p.simulate(1, 0, 50).errors[0] - p.method_errors()[0]).max() < 1e-9
    without = conftest.problem({**STRAIGHT, **OFFSET, **constant})
    assert deviation(without, "along") > 1.0
    ramp = {"sensors.temperature": {"ramp": "30 K/min"}}
    p = conftest.problem({**STRAIGHT, **OFFSET, **ramp, **rest})
    t = duration(p)
    expected = 1e-3 * 0.5 * (t**3 / 6 + 5.0 * t**2 / 2)
    assert deviation(p, "along") == pytest.approx(expected, rel=1e-4)
    assert simulated(p, "along") == pytest.approx(expected, rel=5 / math.sqrt(2 * 4000))


def test_what_levels_sees_the_temperature_of_the_levelling():
    """The tilt takes the offset's mean at rest back; what the ramp adds since then stays."""
    values = {
        **STRAIGHT, **OFFSET,
        "trajectory": {**STRAIGHT["trajectory"], "length": "100 m"},
        "initial.levelling": {"duration": "8 s"},
    }  # fmt: skip
    constant = strapdown.problem({**values, "sensors.temperature": {"difference": "20 K"}})
    assert deviation(constant, "along") < 1e-6
    assert simulated(constant, "along", 500) < 2e-4  # second order: the tilt's square
    p = strapdown.problem({**values, "sensors.temperature": {"ramp": "30 K/min"}})
    t = duration(p)
    expected = 1e-3 * 0.5 * (t**3 / 6 + 4.0 * t**2 / 2)
    assert deviation(p, "along") == pytest.approx(expected, rel=1e-3)
    assert simulated(p, "along") == pytest.approx(expected, rel=5 / math.sqrt(2 * 4000))
    tilt = 1e-3 * 0.5 * 4.0 / STANDARD_GRAVITY
    assert simulated(p, "pitch") == pytest.approx(tilt, rel=5 / math.sqrt(2 * 4000))


def test_gravity_bends_a_characteristic_at_rest_and_goes_with_the_bias():
    """The force upwards of a level vehicle: k g² is a bias that a calibration takes away."""
    block = {"deviation": "1 %", "full_scale": "2 g"}
    values = {**STRAIGHT, "sensors.accelerometer.quadratic_nonlinearity": block}
    p = strapdown.problem(values)
    k = 0.02 / (2 * STANDARD_GRAVITY)
    expected = k * STANDARD_GRAVITY**2 * duration(p) ** 2 / 2
    assert deviation(p, "height") == pytest.approx(expected, rel=1e-6)
    rested = strapdown.problem({**values, "sensors.calibration": {"duration": "5 s"}})
    assert deviation(rested, "height") < 1e-6 * expected


def test_a_group_of_runs_warms_up_from_run_to_run():
    """Run r of T seconds after a rest of R: c k ((R/2 + r T) t + t²/2), the tilt having taken
    the rest's mean back."""
    values = {
        **KNOWN, "runs": 3, "instants": ["1.5 s"], "trajectory.rest": "4 s",
        "tilt.change": "0 rad", "tilt.order": "exact", "trajectory.mounting_angle": "0 °",
        "sensor.accelerometer": {"temperature_offset": ["1 mg/K", "0 mg/K", "0 mg/K"]},
        "sensor.noise": {"x": "0 g", "y": "0 g", "z": "0 g"},
        "sensor.temperature": {"ramp": "60 K/min"},
    }  # fmt: skip
    values |= {f"calibration.l{a}{b}.estimate": float(a == b) for a in "xz" for b in "xyz"}
    values |= {f"calibration.{name}.estimate": "0 g" for name in ("bx", "by", "bz")}
    p = problem_of(Scenario.from_yaml(FOLDER / "a1.yaml", values).base, FOLDER)
    c, t = 1e-3 * STANDARD_GRAVITY, 1.5
    runs = c * ((2.0 + 1.5 * np.arange(3)) * t + t**2 / 2)
    expected = [runs[0], runs.mean(), runs.std(ddof=1)]
    linear = np.sqrt(sum(p.linear.variances.values()))
    np.testing.assert_allclose(linear, expected, rtol=0.01)
    errors = p.simulate(4, 0, 4000).errors - p.method_errors()[:, None]
    rms = np.sqrt(np.mean(errors**2, axis=1))
    np.testing.assert_allclose(rms, expected, rtol=5 / math.sqrt(2 * 4000) + 0.01)
    # The control: runs that are all alike.
    assert runs.std() > 0.2 * runs.mean()


def test_a_log_does_not_depend_on_how_it_is_cut():
    temperature = {"ramp": "600 K/min", "warm_up": "5 K", "time_constant": "0.2 s"}
    block = {"temperature_offset": "1 mg/K", "temperature_scale": "0.1 %/K"}
    signal = np.sin(np.arange(700) / 50.0)
    whole = log_of(block, signal, temperature=temperature)
    np.testing.assert_array_equal(whole, log_of(block, signal, temperature=temperature, pieces=13))
    assert np.abs(whole - signal).max() > 0.005


# Bad input


@pytest.mark.parametrize(
    ("block", "words"),
    [
        ({"warm_up": "10 K"}, "a `warm_up` needs its `time_constant`"),
        ({"difference": "10 °C"}, "temperature difference"),
        ({"points": [{"time": "0 s", "difference": "0 K"}]}, "points"),
        (
            {
                "points": [
                    {"time": "5 s", "difference": "0 K"},
                    {"time": "5 s", "difference": "1 K"},
                ]
            },
            "must rise",
        ),
        ({"ramp": "2 K"}, "K/min"),
        ({"time_constant": "0 s"}, "time_constant"),
    ],
)
def test_what_is_no_temperature_is_refused(block, words):
    with pytest.raises(InputError, match=words):
        conftest.scenario({"sensors.temperature": block})


def test_a_kalman_filter_that_knows_no_temperature_is_refused():
    rest = {"sensors.calibration": {"duration": "10 s", "method": "kalman"}}
    with pytest.raises(InputError, match="knows no temperature that changes"):
        conftest.scenario({**rest, "sensors.temperature": {"ramp": "1 K/min"}})
    conftest.scenario({**rest, "sensors.temperature": {"difference": "1 K"}})
