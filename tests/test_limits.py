"""Limits of sensors and models: each is said where it is reached, and nowhere else."""

import numpy as np
import pytest

import mcsim
from mcsim.engine import run_point
from mcsim.sensors.sampling import power_beyond
from mcsim.systems import problem_of
from tests import strapdown
from tests.conftest import ALL_ERRORS, problem, scenario

RANGE = "sensors.accelerometer.range"
FLICKER = {"sensors.accelerometer.bias_instability": "0.01 m/s^2"}
STOPPED = {"trajectory.shape": "straight"}


def texts(p, count=500):
    return [limit.text for limit in p.limits(3, count) if limit.text]


@pytest.mark.parametrize(
    "overrides",
    [
        {},
        ALL_ERRORS,
        {RANGE: "160 m/s^2"},
        {"sensors.accelerometer.resolution": "0.01 m/s^2"},
        {"sensors.time_jitter": "1 ms"},
        FLICKER,
    ],
)
def test_what_reaches_no_limit_says_nothing(overrides):
    assert texts(problem(overrides)) == []
    assert texts(strapdown.problem(overrides)) == []


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({RANGE: "3 m/s^2"}, "its range of 3 m/s² is reached in 500 of 500 realizations; the und"),
        ({"sensors.gyroscope.range": "5 °/s"}, "gyroscope: its range of 5 °/s is reached in 500"),
        ({"sensors.gyroscope.resolution": "100 °/s"}, "gyroscope: its resolution of 100 °/s is co"),
        ({"sensors.rate": "2 Hz", "trajectory.length": "20 m"}, "above 1 Hz, half the sampling"),
        ({"sensors.time_jitter": "100 ms", "sensors.rate": "5 Hz"}, "time_jitter: between samples"),
        ({**FLICKER, "sensors.rate": "15 Hz"}, "too short for the model of flicker"),
        ({"initial.direction_error": "90 °"}, "heading: errors wrap"),
    ],
)
def test_each_limit_is_said(overrides, words):
    for p in (problem(overrides), strapdown.problem(overrides)):
        assert any(words in text for text in texts(p)), texts(p)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"trajectory.length": "30 km", "sensors.rate": "2 Hz"}, "the level frame neither turns"),
        ({"initial.tilt_error": "60 °"}, "pitch: beyond 85° in"),
        (
            {"initial.levelling.duration": "1 s", "sensors.accelerometer.turn_on_bias": "3 m/s²"},
            "levelling: offsets of the accelerometer tilt the attitude by 17.",
        ),
    ],
)
def test_limits_in_space(overrides, words):
    found = texts(strapdown.problem(overrides))
    assert any(words in text for text in found), found


def test_realizations_beyond_a_range_are_counted():
    """An offset alone, on a straight road: saturated where it exceeds the range, 1 in 22."""
    p = problem(
        {
            "trajectory": {"shape": "straight", "length": "20 m", "speed": "20 m/s"},
            "sensors.accelerometer.noise_density": "0 m/s^2/√Hz",
            "sensors.accelerometer.miscalibration": ["0.1 m/s^2", "0 m/s^2", "0 m/s^2"],
            RANGE: "0.2 m/s^2",
        }
    )
    (limit,) = p.limits(3, 20_000)
    expected = 0.0455 * 20_000
    assert abs(limit.reached - expected) < 5 * np.sqrt(expected)
    assert not limit.certain
    assert "undisturbed" not in limit.text


def test_limits_stand_in_table_and_provenance():
    s = scenario({RANGE: "3 m/s^2", "monte_carlo.realizations": 50})
    results = mcsim.run(s)
    assert results.table["note"].str.contains("its range of 3 m/s²").all()
    (remark,) = [r for r in results.remarks if "range" in r]
    assert "50 of 50 realizations" in remark


def test_power_of_a_tone_beyond_half_the_rate():
    """Two tones of equal amplitude on either side: half of the power."""

    def signals(t, width):
        del width
        return np.stack([np.sin(20.0 * t) + np.sin(2 * np.pi * 30.0 * t), np.sin(20.0 * t)])

    half, none = power_beyond(signals, 0.0, 40.0, 4000)
    assert half == pytest.approx(0.5, abs=0.01)
    assert none < 1e-6


def test_rare_saturation_is_no_case_for_controls():
    """Possible, and hardly seen: the plain estimator serves; often seen, controls do."""
    rare = {"sensors.accelerometer.miscalibration": "0.1 m/s^2", RANGE: "4.65 m/s^2"}
    for overrides, controlled in ((rare, False), ({**rare, RANGE: "8 m/s^2"}, True)):
        p = problem(overrides)
        widths = []
        for estimator in ("plain", "control_variate"):
            values = {"monte_carlo.estimator": estimator, "monte_carlo.realizations": 1000}
            e = run_point(p, scenario(values).base.monte_carlo, 5).estimates
            widths.append((e.high - e.low)[0, 2])
        assert (widths[1] < 0.5 * widths[0]) == controlled


def test_a_budget_says_the_limits_of_its_run():
    """Gravity alone asks for more than the range; a wide one says nothing."""
    from mcsim.gum import course_of_uncertainty
    from tests.test_velocity_sensor import scenario as measured

    narrow, wide = (
        course_of_uncertainty(measured({"range": r}).base, 200).limits for r in ("0.5 g", "15 g")
    )
    assert any("its range of" in text for text in narrow)
    assert wide == ()


def test_velocity_says_its_limits():
    from tests.test_velocity import scenario as velocity

    base = velocity().base
    assert [
        limit for limit in problem_of(base, velocity().folder).limits(1, 50) if limit.text
    ] == []
    tilted = velocity(trajectory__mounting_angle="0.4 rad")
    assert any("tilt.order" in t for t in texts(problem_of(tilted.base, tilted.folder), 50))


def test_a_range_out_of_reach_is_no_limit():
    """A named sensor has steps and a range; only one within reach makes errors abrupt."""
    far = problem({"sensors.accelerometer": "MPU-9250"})
    assert np.isfinite(far.measurement.ranges).any()
    assert not any(limit.abrupt for limit in far.limits(1, 200))
    near = problem({"sensors.accelerometer": {"model": "MPU-9250", "range": "0.3 g"}})
    assert any(limit.abrupt for limit in near.limits(1, 200))
