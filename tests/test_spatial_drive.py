"""The strapdown case's truth: how a body leans, and six channels consistent with the motion."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from mcsim.errors import InputError
from mcsim.systems.strapdown.truth import spatial_drive
from mcsim.trajectory.attitude import euler_angles, rotation_matrix
from mcsim.trajectory.lean import constant_lean, follower, oscillator
from mcsim.units import STANDARD_GRAVITY as G
from tests.strapdown import LEANING, problem, scenario

QUINTIC = {
    "trajectory": {
        "shape": "quintic",
        "length": "50 m",
        "width": "5 m",
        "speed": "20 m/s",
        "lead": "200 ms",
    }
}
SLIPPING = {
    "trajectory.deceleration": "2 m/s^2",
    "trajectory.side_slip": "4 °",
    "trajectory.side_slip_profile": "bump",
}
STIFF = {"body.roll.gradient": "0.3 °/(m/s²)", "body.roll.natural_frequency": "0 Hz"}


def drive(overrides, folder=None):
    from pathlib import Path

    return spatial_drive(scenario(overrides).base, folder or Path())


def rotations(motion) -> Rotation:
    a = motion.attitude
    return Rotation.from_euler("ZYX", np.stack([a.heading, a.pitch, a.roll], axis=1))


@pytest.mark.parametrize("damping", [0.1, 0.7, 1.0, 1.8])
def test_oscillator_solves_its_differential_equation(damping):
    """Against scipy's solver, through jumps of what drives it."""
    breaks, gain, frequency = (0.0, 0.6, 2.0), 0.02, 1.3

    def force(t):
        return np.where(t < 0.6, 3.0 * np.sin(4.0 * t) + 1.0, -2.0 + t**2)

    lean = oscillator(force, 0.5, 0.3, breaks, gain, frequency, damping)
    omega = 2 * math.pi * frequency
    state = [gain * 0.5, 0.0]
    for a, b, u in ((0.0, 0.6, force), (0.6, 2.0, force), (2.0, 6.0, lambda _: 0.3)):
        inside = np.linspace(a, b, 50)[1:-1]
        solution = solve_ivp(
            lambda t, x, u=u: [
                x[1],
                omega**2 * (gain * float(u(t)) - x[0]) - 2 * damping * omega * x[1],
            ],
            (a, b),
            state,
            t_eval=[*inside, b],
            rtol=1e-11,
            atol=1e-13,
            method="DOP853",
        )
        np.testing.assert_allclose(lean.angle(inside), solution.y[0, :-1], atol=1e-8)
        np.testing.assert_allclose(lean.rate(inside), solution.y[1, :-1], atol=1e-7)
        state = solution.y[:, -1]
    assert lean.angle(np.array([-5.0]))[0] == gain * 0.5
    far = np.array([1e4])
    assert lean.angle(far)[0] == pytest.approx(gain * 0.3, rel=1e-9)
    assert lean.rate(far)[0] == 0.0


def test_follower_is_its_gain_times_the_force():
    breaks = (0.0, 1.0, 2.0)

    def force(t):
        return np.where(t < 1.0, t**3, 1.0 + (t - 1.0) * 5.0)

    lean = follower(force, 0.0, 6.0, breaks, 0.1)
    t = np.linspace(-1, 3, 41)
    np.testing.assert_allclose(
        lean.angle(t), 0.1 * np.where(t < 0, 0, np.where(t > 2, 6, force(t))), atol=1e-12
    )
    # At a kink the rate is the mean of both sides; over a cell it keeps the angle.
    assert lean.rate(np.array([1.0]))[0] == pytest.approx(0.1 * (3.0 + 5.0) / 2, rel=1e-6)
    mean = lean.rate(np.array([1.003]), 0.01)[0]
    assert mean == pytest.approx(float(np.diff(lean.angle(np.array([0.998, 1.008])))[0]) / 0.01)


def test_a_body_that_cannot_follow_a_jump_says_so():
    with pytest.raises(InputError, match=r"jumps at 0 s.*natural_frequency"):
        drive(STIFF)
    drive({**QUINTIC, **STIFF})  # a continuous curvature is fine


@pytest.mark.parametrize("angles", [(0.2, -0.7, 2.9), (0.0, 0.0, -3.0), (-1.0, 1.2, 0.1)])
def test_euler_angles_agree_with_scipy(angles):
    roll, pitch, heading = map(np.array, angles)
    matrix = rotation_matrix(roll, pitch, heading)
    scipys = Rotation.from_euler("ZYX", angles[::-1])
    np.testing.assert_allclose(matrix, scipys.as_matrix(), atol=1e-15)
    back = euler_angles(matrix)
    np.testing.assert_allclose([back.roll, back.pitch, back.heading], angles, atol=1e-14)


def test_euler_angles_at_the_vertical_follow_the_convention():
    matrix = rotation_matrix(np.array(0.3), np.array(math.pi / 2), np.array(0.5))
    back = euler_angles(matrix)
    assert back.roll == 0.0
    np.testing.assert_allclose([back.pitch, back.heading], [math.pi / 2, 0.2], atol=1e-12)
    again = rotation_matrix(back.roll, back.pitch, back.heading)
    np.testing.assert_allclose(again, matrix, atol=1e-12)


@pytest.mark.parametrize("overrides", [{**QUINTIC, **LEANING}, {**QUINTIC, **LEANING, **SLIPPING}])
def test_channels_are_the_derivatives_of_the_motion(overrides):
    """Rates from the attitude's differences, specific force from those of the velocity."""
    d = drive(overrides)
    t, h = np.linspace(0.1, 2.3, 23), 1e-4
    signals = d.signals(t)
    before, at, after = d.motion(t - h), d.motion(t), d.motion(t + h)
    turned = (rotations(before).inv() * rotations(after)).as_rotvec() / (2 * h)
    np.testing.assert_allclose(signals[[4, 5, 2]].T, turned, atol=1e-6)
    acceleration = (after.velocity - before.velocity).T / (2 * h)
    force = rotations(at).inv().apply(acceleration + np.array([0.0, 0.0, G]))
    np.testing.assert_allclose(signals[[0, 1, 3]].T, force, atol=1e-5)
    velocity = (after.position - before.position) / (2 * h)
    np.testing.assert_allclose(at.velocity, velocity, atol=1e-5)


@pytest.mark.parametrize("sampling", ["none", "average", "fir"])
def test_ideal_channels_lead_back_to_the_truth(sampling):
    """The closed loop: what the sensors say, integrated, is the motion."""
    p = problem(
        {
            **QUINTIC,
            **LEANING,
            "trajectory.lead": "200 ms",
            "sensors.rate": "500 Hz",
            "sensors.sampling": sampling,
            "reconstruction.integration": "two_sample",
        }
    )
    along, across, height, _, roll, pitch, heading, course = np.abs(p.method_errors())
    assert max(along, across, height) < 2e-3
    assert max(roll, pitch, heading, course) < math.radians(0.01)


def test_a_slope_is_climbed():
    d = drive({**QUINTIC, "body.grade": "4 °", "body.bank": "3 °"})
    end = d.motion(np.array([d.drive.end]))
    along, across, height = end.position[:, 0]
    rise, sideways = math.tan(math.radians(4)), math.tan(math.radians(3))
    # The plane of the road: its slope across is measured along the tilted cross direction.
    assert height == pytest.approx(along * rise + across * sideways / math.cos(math.radians(4)))
    attitude = end.attitude
    assert math.degrees(attitude.pitch[0]) == pytest.approx(-4.0)
    assert math.degrees(attitude.roll[0]) == pytest.approx(3.0)


def test_a_body_leans_outwards_and_dives_under_brakes():
    left = drive({**QUINTIC, **STIFF}).motion(np.array([0.8])).attitude.roll[0]
    assert math.degrees(left) > 0.5
    braking = {
        **QUINTIC,
        "trajectory.deceleration": "3 m/s^2",
        "body.pitch.gradient": "0.2 °/(m/s²)",
        "body.pitch.damping": "70 %",
    }
    dive = drive(braking).motion(np.array([2.0])).attitude.pitch[0]
    assert math.degrees(dive) == pytest.approx(0.6, rel=0.05)


def test_a_body_leans_downhill_on_a_bank():
    """g sin(bank) presses the body like an acceleration; it stands in its steady attitude."""
    d = drive({**QUINTIC, **STIFF, "body.bank": "5 °"})
    roll = d.motion(np.array([-0.1])).attitude.roll[0]
    extra = math.radians(0.3) * G * math.sin(math.radians(5))
    assert roll == pytest.approx(math.radians(5) + extra, rel=1e-9)


def test_three_channels_of_a_rolling_vehicle_err_by_the_roll_gradient():
    """Roll K a reads as g K a more lateral acceleration: the track comes out g K D too wide."""
    gradient = math.radians(0.05)
    p = problem(
        {
            **QUINTIC,
            **STIFF,
            "body.roll.gradient": "0.05 °/(m/s²)",
            "reconstruction.algorithm": "planar",
            "reconstruction.integration": "trapezoidal",
            "sensors.rate": "500 Hz",
        }
    )
    assert p.method_errors()[1] == pytest.approx(G * gradient * 5.0, rel=0.02)


def write_rocking(folder, nose_up=False):
    """A drive along a circle whose body rocks; returns the true angles' function."""
    t = np.arange(0, 20, 0.02)
    roll, pitch = 0.05 * np.sin(1.1 * t), 0.03 * np.cos(0.7 * t)
    x, y = 60 * np.sin(12 * t / 60), 60 - 60 * np.cos(12 * t / 60)
    sign = -1.0 if nose_up else 1.0
    rows = ["t,x,y,roll,pitch"]
    rows += [
        f"{a:.6f},{b:.9f},{c:.9f},{math.degrees(d):.9f},{sign * math.degrees(e):.9f}"
        for a, b, c, d, e in zip(t, x, y, roll, pitch, strict=True)
    ]
    (folder / "drive.csv").write_text("\n".join(rows) + "\n")
    return lambda s: (0.05 * np.sin(1.1 * s), 0.03 * np.cos(0.7 * s))


RECORDED = {
    "shape": "recorded",
    "file": "drive.csv",
    "smoothing": "0.05 s",
    "columns": {
        "time": "t in s",
        "x": "x in m",
        "y": "y in m",
        "roll": "roll in °",
        "pitch": "pitch in °",
    },
}


@pytest.mark.parametrize("nose", ["nose_down", "nose_up"])
def test_recorded_attitude_is_the_truth(tmp_path, nose):
    angles = write_rocking(tmp_path, nose == "nose_up")
    overrides = {"trajectory": {**RECORDED, "pitch_positive": nose}}
    d = drive(overrides, tmp_path)
    t = np.linspace(1, 18, 60)
    attitude = d.motion(t).attitude
    roll, pitch = angles(t)
    np.testing.assert_allclose(attitude.roll, roll, atol=1e-4)
    np.testing.assert_allclose(attitude.pitch, pitch, atol=1e-4)
    h = 1e-4
    turned = (rotations(d.motion(t - h)).inv() * rotations(d.motion(t + h))).as_rotvec() / (2 * h)
    np.testing.assert_allclose(d.signals(t)[[4, 5, 2]].T, turned, atol=1e-5)
    p = problem({**overrides, "reconstruction.integration": "trapezoidal"}, tmp_path)
    assert np.abs(p.method_errors()[4:]).max() < math.radians(0.05)


def test_a_record_without_attitude_may_lean(tmp_path):
    write_rocking(tmp_path)
    columns = {k: v for k, v in RECORDED["columns"].items() if k in ("time", "x", "y")}
    d = drive({"trajectory": {**RECORDED, "columns": columns}, **LEANING}, tmp_path)
    roll = d.motion(np.array([10.0])).attitude.roll[0]
    # Bank across the initial direction, seen from a vehicle that has turned by 2 rad.
    assert abs(math.degrees(roll)) > 1.0


def test_constant_lean_never_moves():
    lean = constant_lean(0.2)
    assert lean.angle(np.array([-3.0, 0.5, 9.0])).tolist() == [0.2] * 3
    assert lean.rate(np.array([-3.0, 0.5, 9.0])).tolist() == [0.0] * 3


@pytest.mark.parametrize("frequency", ["1.5 Hz", "5 Hz", "20 Hz"])
@pytest.mark.parametrize("rate", ["100 Hz", "333 Hz", "1000 Hz"])
def test_jumps_of_the_acceleration_leave_no_roll_behind(frequency, rate):
    """Where the roll begins to bend inside a dense step, the turn is kept all the same."""
    values = {"body.roll.gradient": "1 °/(m/s²)", "body.roll.natural_frequency": frequency,
              "sensors.rate": rate, "reconstruction.integration": "two_sample"}  # fmt: skip
    errors = problem(values).method_errors()
    # Momentary rates left 3 mm at 20 Hz; what remains is the coarse rate's own.
    assert np.abs(errors[:3]).max() < (3e-4 if rate == "100 Hz" else 5e-5)
