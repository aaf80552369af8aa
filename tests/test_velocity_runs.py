"""Straight runs of the velocity case: profiles against integration, and a body that pitches."""

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import mcsim
from mcsim import InputError, Scenario
from mcsim.systems import check_point, problem_of
from mcsim.systems.velocity.profiles import PROFILES, profile_of
from mcsim.systems.velocity.truth import true_run
from mcsim.trajectory.jerk_limited import Ramp, phases

FOLDER = Path(__file__).parent.parent / "scenarios" / "velocity"
G = 9.81213
RAMPS = [(0.0, 0.0), (0.2, 0.4), (1.1, 0.4), (1.3, 0.0), (2.0, 0.0)]


def scenario(trajectory=None, **overrides):
    values = {path.replace("__", "."): value for path, value in overrides.items()}
    if trajectory is not None:
        values = {"trajectory": trajectory, "instants": None, **values}
    return Scenario.from_yaml(FOLDER / "a1.yaml", values)


def points(*pairs):
    return {
        "shape": "points",
        "points": [{"time": f"{t} s", "velocity": f"{v} m/s"} for t, v in pairs],
    }


def method(s, kind=0):
    """The method's error of the first run at every instant."""
    return problem_of(s.base, s.folder).method_errors()[kind::3]


# Profiles


S_CURVE = {"shape": "s_curve", "top_speed": "0.4 m/s", "acceleration": "2 m/s²",
           "deceleration": "1.6 m/s²", "jerk": "20 m/s³", "duration": "1.5 s"}  # fmt: skip
SLOW_STOP = {"top_speed": "0.4 m/s", "acceleration": "2 m/s²", "deceleration": "0.5 m/s²",
             "duration": "1.5 s"}  # fmt: skip
WHEELS = {"shape": "points", "points": [
    {"time": "0 s", "left": "0 m/s", "right": "0 m/s"},
    {"time": "0.3 s", "left": "0.5 m/s", "right": "0.3 m/s"},
    {"time": "1.5 s", "left": "-0.1 m/s", "right": "0 m/s"}]}  # fmt: skip


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    """Wheel speeds in km/h and m/s, at stamps of a clock that does not tick evenly."""
    file = tmp_path_factory.mktemp("wheels") / "wheels.csv"
    time = [100.0, 100.4, 100.65, 100.9, 101.7, 102.0, 103.0]
    left = [0.0, 0.0, 0.3, 0.5, 0.4, 0.0, 0.0]
    right = [0.0, 0.0, 0.34, 0.42, 0.4, 0.0, 0.0]
    rows = [f"{t},{3.6 * a},{b}" for t, a, b in zip(time, left, right, strict=True)]
    file.write_text("\n".join(["t [s],left [km/h],right", *rows]) + "\n")
    return file


def recorded(file, **changes):
    return {
        "shape": "recorded",
        "file": str(file),
        "columns": {"time": "t", "left": "left", "right": "right in m/s"},
        "start": "0.4 s",
        "duration": "1.8 s",
        **changes,
    }


@pytest.mark.parametrize("name", ["trapezoid", "s_curve", "points", "wheels", "recorded"])
def test_the_velocity_is_the_integral_of_the_acceleration(name, record):
    """By quadrature between the breaks; and the acceleration stands between its own sides."""
    blocks = {"trapezoid": SLOW_STOP, "s_curve": S_CURVE, "points": points(*RAMPS),
              "wheels": WHEELS, "recorded": recorded(record)}  # fmt: skip
    run = scenario(blocks[name]).base.trajectory
    profile = profile_of(run, Path())
    assert profile.breaks[0] == 0.0
    assert profile.breaks[-1] == pytest.approx(run.duration, abs=1e-9)
    total = 0.0
    for start, end in pairwise(profile.breaks):
        total += quad(lambda t: float(profile.acceleration(np.array(t))), start, end)[0]
        assert float(profile.velocity(np.array(end))) == pytest.approx(total, abs=1e-12)
    at = np.array(profile.breaks)
    sides = 0.5 * (profile.acceleration(at - 1e-7) + profile.acceleration(at + 1e-7))
    np.testing.assert_allclose(profile.acceleration(at), sides, atol=1e-5)


@pytest.mark.parametrize("sampling", ["average", "none"])
@pytest.mark.parametrize("name", ["trapezoid", "s_curve", "points"])
def test_every_profile_comes_back_without_errors(name, sampling):
    """Means over the intervals lose nothing; momentary samples what an Euler sum does."""
    block = {"trapezoid": SLOW_STOP, "s_curve": S_CURVE, "points": points(*RAMPS)}[name]
    errors = method(scenario(block, tilt__order="exact", sensor__sampling=sampling))
    # Linear acceleration is sampled at the beginning of each interval: half an interval's jerk.
    assert np.abs(errors).max() < (1e-12 if sampling == "average" else 2e-5)
    assert np.abs(errors).max() < 1e-6 or name == "s_curve"


def test_points_on_a_trapezoid_are_that_trapezoid():
    run = {"top_speed": "0.4 m/s", "acceleration": "2 m/s²", "duration": "1.5 s"}
    corners = points((0.0, 0.0), (0.2, 0.4), (1.3, 0.4), (1.5, 0.0))
    one, two = (problem_of(scenario(r).base, Path()) for r in (run, corners))
    np.testing.assert_allclose(one.raw, two.raw, atol=1e-14)
    np.testing.assert_allclose(one.truth, two.truth, atol=1e-14)


def test_an_s_curve_is_built_from_seven_phases():
    """Rise, hold, fall, cruise and back: v = a (hold + rise), jerk never above its bound."""
    times, values = phases(Ramp(0.4, 2.0, 20.0), 0.5, Ramp(0.4, 1.6, 20.0))
    np.testing.assert_allclose(np.diff(times), [0.1, 0.1, 0.1, 0.5, 0.08, 0.17, 0.08])
    assert np.trapezoid(values, times) == pytest.approx(0.0, abs=1e-15)
    assert np.trapezoid(values[:4], times[:4]) == pytest.approx(0.4)
    assert np.abs(np.diff(values) / np.diff(times)).max() == pytest.approx(20.0)


def test_left_and_right_wheels_make_the_mean_velocity(record):
    run = recorded(record)
    told = scenario(run)
    profile = profile_of(told.base.trajectory, told.folder)
    at = np.array([0.0, 0.25, 0.5, 1.3, 1.6, 1.8])
    np.testing.assert_allclose(profile.velocity(at), [0.0, 0.32, 0.46, 0.4, 0.0, 0.0], atol=1e-12)
    assert profile.velocity(np.array(0.125)) == pytest.approx(0.16)
    assert any("left" in note for note in profile.notes)
    results = mcsim.run(scenario(run, monte_carlo__realizations=200, sensor__rate="50 Hz"))
    assert any('"left" as left' in remark or '"left [km/h]" as left' in remark
               for remark in results.remarks)  # fmt: skip


BAD = [
    (points((0.1, 0.0), (1.0, 0.4)), "first must be a standstill at 0 s"),
    (points((0.0, 0.1), (1.0, 0.4)), "first must be a standstill at 0 s"),
    (points((0.0, 0.0), (1.0, 0.4), (1.0, 0.0)), "times must ascend"),
    ({"shape": "points", "points": [{"time": "0 s", "left": "0 m/s"},
                                    {"time": "1 s", "left": "0 m/s"}]}, "not left"),
    ({**S_CURVE, "jerk": "2 m/s³"}, "acceleration cannot be reached"),
    ({**S_CURVE, "duration": "0.5 s"}, "longer than the duration"),
    ({**SLOW_STOP, "duration": "0.9 s"}, r"top_speed / deceleration = 1 s, longer"),
    ({"shape": "sine"}, "known: trapezoid, s_curve, points, recorded"),
]  # fmt: skip


@pytest.mark.parametrize(("block", "message"), BAD)
def test_bad_profiles_are_explained(block, message):
    with pytest.raises(InputError, match=message):
        scenario(block)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"duration": "3 s"}, r"the record lasts 3 s; `start` and `duration` ask for 3.4 s"),
        ({"start": "0.8 s", "duration": "1 s"}, "begins from rest"),
        ({"start": "2 s", "duration": "1 s"}, "does not move"),
        ({"columns": {"time": "t", "left": "left", "right": "right"}}, "right.*has no unit"),
        ({"columns": {"time": "t", "velocity": "speed in m/s"}}, 'no column "speed"'),
    ],
)
def test_bad_records_are_explained(change, message, record):
    s = scenario(recorded(record, **change))
    with pytest.raises(InputError, match=message):
        check_point(s.base, s.folder)


def test_a_record_whose_clock_stands_still_names_the_line(tmp_path):
    file = tmp_path / "w.csv"
    file.write_text("t [s],v [m/s]\n0,0\n0.5,0.2\n0.5,0.3\n1,0\n")
    columns = {"time": "t", "velocity": "v"}
    s = scenario(recorded(file, columns=columns, start="0 s", duration="1 s"))
    with pytest.raises(InputError, match=r"w\.csv:4: the time stands still"):
        check_point(s.base, s.folder)


def test_every_profile_is_in_the_schema():
    text = str(mcsim.schema("scenario"))
    assert all(name in text for name in PROFILES)


# Pitch under acceleration


def pitching(gradient=0.25, frequency=3.0, damping=20, height=0.0):
    return {
        "pitch": {
            "gradient": f"{gradient} °/(m/s²)",
            "natural_frequency": f"{frequency} Hz",
            "damping": f"{damping} %",
        },
        "height": f"{height} m",
    }


def step_response(t, frequency, damping):
    """Angle and rate of the oscillator after a unit step of the steady angle (textbook)."""
    omega = 2.0 * math.pi * frequency
    turning = omega * math.sqrt(1.0 - damping**2)
    t = np.maximum(t, 0.0)
    fading = np.exp(-damping * omega * t)
    angle = 1.0 - fading * (np.cos(turning * t) + damping * omega / turning * np.sin(turning * t))
    return angle, omega**2 / turning * fading * np.sin(turning * t)


def closed_form(t, gradient, frequency, damping, height):
    """v measured less v of the wheels: g K v - g (a' + 2 zeta omega a) / omega^2 - h a'."""
    k, omega = math.radians(gradient), 2.0 * math.pi * frequency
    angle = rate = 0.0
    for at, jump in ((0.0, 2.0), (0.2, -2.0), (1.1, -2.0), (1.3, 2.0)):
        own, turning = step_response(t - at, frequency, damping)
        angle, rate = angle + k * jump * own, rate + k * jump * turning
    velocity = np.interp(t, *zip(*RAMPS, strict=True))
    leaked = G * (k * velocity - (rate + 2.0 * damping * omega * angle) / omega**2)
    return leaked - height * rate


@pytest.mark.parametrize("height", [0.0, 0.1])
def test_the_end_speed_is_negative_by_the_closed_form(height):
    """After braking the body swings back: sign, size and course, to second order of the pitch."""
    s = scenario(points(*RAMPS), body=pitching(height=height), tilt={"order": "exact"})
    p = problem_of(s.base, s.folder)
    curve = _undisturbed(p)
    t = np.arange(len(curve)) * p.interval
    expected = closed_form(t, 0.25, 3.0, 0.2, height)
    np.testing.assert_allclose(curve, expected, atol=2e-2 * np.abs(expected).max())
    after = (t >= 1.3) & (t <= 1.6)
    lowest = curve[after].min()
    assert lowest == pytest.approx(expected[after].min(), rel=0.02)
    assert lowest < (-0.009 if height else -0.003)
    # Not a drift: when the swing has faded nothing is left of it.
    assert abs(closed_form(np.array([20.0]), 0.25, 3.0, 0.2, height)[0]) < 1e-12


def _undisturbed(p):
    """Velocity less that of the wheels after every step, without sensor errors."""
    still = replace(
        p,
        uncertainties=0.0 * p.uncertainties,
        sensor_errors=p.sensor_errors.silent(),
        time_error=0.0,
    )
    return still.errors_over_time(0, 0, 1)[0, :, 0]


def test_pitch_agrees_with_an_integration_of_the_equations():
    """The body by Runge-Kutta, the specific force of Eq. (6) and (7) in full, by quadrature."""
    body = pitching(gradient=2.0, frequency=2.0, damping=30, height=0.3)
    s = scenario(S_CURVE, body=body, tilt__order="exact", instants=["0.5 s", "1.0 s", "1.5 s"])
    model, tilt = s.base, s.base.trajectory.mounting_angle
    profile = profile_of(model.trajectory, s.folder)
    k, omega = math.radians(2.0), 2.0 * math.pi * 2.0

    def rhs(t, y):
        angle, rate, _ = y
        a = float(profile.acceleration(np.array(t)))
        bend = omega**2 * (k * a - angle) - 0.6 * omega * rate
        forward = a - 0.3 * (bend * math.cos(angle) - rate**2 * math.sin(angle))
        upward = G - 0.3 * (bend * math.sin(angle) + rate**2 * math.cos(angle))
        # On the axes of the sensor, and back by the angle at rest, which is all one knows.
        x = forward * math.cos(tilt + angle) + upward * math.sin(tilt + angle)
        z = upward * math.cos(tilt + angle) - forward * math.sin(tilt + angle)
        return [rate, bend, x * math.cos(tilt) - z * math.sin(tilt)]

    state, expected = np.zeros(3), {}
    stops = sorted({*profile.breaks, 0.5, 1.0})
    for start, end in pairwise(stops):
        answer = solve_ivp(rhs, (start, end), state, rtol=1e-11, atol=1e-13)
        state = answer.y[:, -1]
        expected[round(end, 6)] = state[2] - float(profile.velocity(np.array(end)))
    found = method(s)
    # The mean acceleration of each interval at the momentary tilt: second order of the interval.
    gap = np.abs(found - [expected[t] for t in (0.5, 1.0, 1.5)]).max()
    finer = method(s.with_values({"sensor.rate": "400 Hz"}))
    assert gap < 3e-6
    assert np.abs(finer - [expected[t] for t in (0.5, 1.0, 1.5)]).max() < gap / 14.0
    assert np.abs(found).max() > 0.08
    # Momentary samples see the same to the first order of the interval.
    coarse, fine = (
        method(s.with_values({"sensor.sampling": "none", "sensor.rate": rate}))[-1]
        for rate in ("2 kHz", "4 kHz")
    )
    assert 2.0 * fine - coarse == pytest.approx(expected[1.5], abs=2e-6)
    assert abs(fine - expected[1.5]) > 1e-4


def test_the_nose_rises_under_driving_and_dips_under_braking():
    s = scenario(points(*RAMPS), body=pitching(frequency=20.0, damping=100))
    run = true_run(s.base, s.folder)
    tilt = run.motion(np.array([0.19, 0.9, 1.29, 1.9])).tilt - s.base.trajectory.mounting_angle
    np.testing.assert_allclose(tilt, np.radians([0.5, 0.0, -0.5, 0.0]), atol=1e-5)


def test_a_body_that_follows_at_once_leaks_g_k_v():
    """Without inertia the error is g K v: nothing is left when the wheels stand."""
    body = {"pitch": {"gradient": "0.25 °/(m/s²)", "natural_frequency": "0 Hz"}}
    s = scenario(S_CURVE, body=body, tilt__order="exact", instants=["0.8 s", "1.5 s"],
                 trajectory__mounting_angle="0 rad")  # fmt: skip
    found = method(s)
    assert found[0] == pytest.approx(G * math.radians(0.25) * 0.4, rel=0.02)
    assert abs(found[1]) < 5e-4 * G * math.radians(0.25)
    jumps = scenario(body=body)
    with pytest.raises(InputError, match=r"the acceleration jumps at 0 s.*s_curve"):
        check_point(jumps.base, jumps.folder)
    with pytest.raises(InputError, match="a body that follows at once swings a sensor"):
        scenario(S_CURVE, body={**body, "height": "0.1 m"})


def test_a_stiff_body_changes_no_bit():
    one, two = (problem_of(scenario(**more).base, FOLDER)
                for more in ({}, {"body": {"pitch": {"natural_frequency": "2 Hz"}}}))  # fmt: skip
    np.testing.assert_array_equal(one.raw, two.raw)
