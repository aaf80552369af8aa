"""The strapdown kernel against scipy's rotations, closed forms and the planar kernel."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mcsim.kernels.quaternion import attitude, euler_angles
from mcsim.units import STANDARD_GRAVITY as G
from tests.conftest import ALL_ERRORS, NO_NOISE
from tests.conftest import problem as planar_problem
from tests.reference.strapdown_scipy import end_errors, integrate, reconstruct
from tests.strapdown import (
    EVERYTHING,
    LEANING,
    RULES,
    SPATIAL_CHANNELS,
    constants_of,
    problem,
    run_kernel,
    with_errors,
)

FLAT_OUT = {
    "trajectory": {"shape": "straight", "length": "40 m", "speed": "10 m/s", "lead": "0 s"},
    "sensors.sampling": "none",
}
COUNT = 100_000
#: Five standard errors of a standard deviation estimated from COUNT normals.
TOLERANCE = 5 / math.sqrt(2 * COUNT)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("sampling", ["fir", "average"])
def test_kernel_equals_the_plain_twin(rule, sampling):
    """Same random numbers, exact functions: float32 normals are all that differs."""
    p = problem(
        {
            **EVERYTHING,
            "reconstruction.integration": rule,
            "sensors.sampling": sampling,
            "initial.levelling": {"duration": "1 s"} if sampling == "average" else None,
        }
    )
    ours = p.simulate(99, 1000, 130).errors[:, 120:128]
    twin = end_errors(p, 99, range(1120, 1128), rule)
    scale = p.simulate(99, 0, 1000).errors.std(axis=1, keepdims=True)
    assert np.abs((ours - twin) / scale).max() < 2e-6


@pytest.mark.parametrize("rule", RULES)
def test_polynomial_rotations_agree_with_scipy(rule):
    """Undisturbed, the kernel and the twin differ by rounding alone (1e-9 m asked)."""
    p = problem({**NO_NOISE, **LEANING, "reconstruction.integration": rule})
    ours = p.method_errors()
    twin = end_errors(p, 0, [0], rule)[:, 0]
    assert np.abs(ours - twin).max() < 1e-11


@pytest.mark.parametrize("rule", RULES)
def test_large_rotations_use_exact_functions(rule):
    """100 °/s of miscalibration at 2 Hz turn by more than the polynomials can hold."""
    p = problem(
        {
            "sensors.rate": "2 Hz",
            "sensors.sampling": "none",
            "sensors.gyroscope.miscalibration": "100 °/s",
            "reconstruction.integration": rule,
        }
    )
    ours = p.simulate(3, 0, 20).errors
    twin = end_errors(p, 3, range(20), rule)
    assert np.abs(ours - twin).max() < 1e-4  # metres; normals in float32, turns of radians


@pytest.mark.parametrize("rule", RULES)
def test_histories_follow_the_twin_and_end_in_the_errors(rule):
    p = problem({**EVERYTHING, "reconstruction.integration": rule})
    history = p.history(5, 10, 70)
    twin = reconstruct(p, 5, 13, rule)
    assert np.abs(history.tracks[:, :, 3] - twin.position[:, :2].T).max() < 1e-6
    height = history.errors[2, :, 3] + p.truth.position[2]
    assert np.abs(height - twin.position[:, 2]).max() < 1e-6
    np.testing.assert_allclose(
        history.errors[:, -1], p.simulate(5, 10, 70).errors, rtol=1e-9, atol=1e-12
    )


# ---- the planar case -------------------------------------------------------------------


@pytest.mark.parametrize("rule", ["rectangular", "trapezoidal"])
@pytest.mark.parametrize("sampling", ["fir", "average"])
def test_a_stiff_vehicle_on_a_level_road_is_the_planar_case(rule, sampling):
    """Same random numbers, no disturbance of the three further channels: equal to rounding."""
    overrides = {
        **ALL_ERRORS,
        "initial.heading_error": "0.2 °",
        "initial.course_error": "0.3 °",
        "reconstruction.integration": rule,
        "sensors.sampling": sampling,
    }
    p, q = problem(overrides), planar_problem(overrides)
    np.testing.assert_array_equal(p.signals[:, :3], q.signals)
    white, deviations = p.sensor_errors.white.copy(), constants_of(p)
    white[SPATIAL_CHANNELS] = 0.0
    deviations[12:] = 0.0
    ours = with_errors(p, white, deviations).simulate(7, 0, 500).errors
    theirs = q.simulate(7, 0, 500).errors
    assert np.abs(ours[[0, 1, 3, 6, 7]] - theirs).max() < 1e-11
    assert np.abs(ours[[2, 4, 5]]).max() < 1e-12


def test_without_gyroscope_noise_whole_scenarios_agree_in_the_plane():
    """The vertical accelerometer's own errors stay in the height."""
    overrides = {
        **ALL_ERRORS,
        "sensors.gyroscope.noise_density": "0 °/s/√Hz",
        "sensors.gyroscope.miscalibration": "0 °/s",
    }
    ours = problem(overrides).simulate(7, 0, 500).errors
    theirs = planar_problem(overrides).simulate(7, 0, 500).errors
    assert np.abs(ours[[0, 1, 6, 7]] - theirs[[0, 1, 3, 4]]).max() < 1e-11
    assert ours[2].std() > 0.01


# ---- closed forms ----------------------------------------------------------------------


def at_rest(n: int, force=(0.0, 0.0, G)) -> np.ndarray:
    signals = np.zeros((n + 1, 6))
    signals[:, [0, 1, 3]] = force
    return signals


def start(roll=0.0, pitch=0.0, heading=0.0) -> np.ndarray:
    initial = np.zeros(9)
    initial[5:8] = roll, pitch, heading
    return initial


@pytest.mark.parametrize("degrees", [0.1, 1.0, 5.0])
def test_tilted_attitude_takes_gravity_for_acceleration(degrees):
    """g sin(eps), g sin(eps) t and g sin(eps) t^2 / 2; no Schuler motion in a level frame."""
    tilt, t, n = math.radians(degrees), 0.01, 6000
    a, time = G * math.sin(tilt), n * t
    states = run_kernel(at_rest(n), start(roll=-tilt), t, "trapezoidal")
    assert states[4, -1] == pytest.approx(a * time, rel=1e-12)
    assert states[1, -1] == pytest.approx(0.5 * a * time**2, rel=1e-12)
    assert states[2, -1] == pytest.approx(-0.5 * G * (1 - math.cos(tilt)) * time**2, rel=1e-6)
    # The note's recursion: T^2 a n (n - 1) / 2; the planar paper's: T^2 a n (n + 1) / 2.
    euler = run_kernel(at_rest(n), start(roll=-tilt), t, "forward_euler")
    assert euler[1, -1] == pytest.approx(t**2 * a * n * (n - 1) / 2, rel=1e-12)
    rectangular = run_kernel(at_rest(n), start(roll=-tilt), t, "rectangular")
    assert rectangular[1, -1] == pytest.approx(t**2 * a * n * (n + 1) / 2, rel=1e-12)


def test_nose_down_error_pushes_backwards_and_roll_error_to_the_left():
    """Signs of ISO 8855: an attitude taken too far nose down reads gravity as push forwards."""
    forwards = run_kernel(at_rest(100), start(pitch=0.01), 0.01, "rectangular")[0, -1]
    sideways = run_kernel(at_rest(100), start(roll=0.01), 0.01, "rectangular")[1, -1]
    assert forwards > 0.04
    assert sideways < -0.04


@pytest.mark.parametrize("rule", RULES)
def test_a_vehicle_at_rest_on_a_slope_stays_at_rest(rule):
    """An hour at 20 Hz on a slope of 20 ° by 10 °, standing across it."""
    angles = np.radians([70.0, -10.0, 20.0])
    attitude = Rotation.from_euler("ZYX", angles)
    signals = at_rest(72_000, attitude.inv().apply([0.0, 0.0, G]))
    states = run_kernel(signals, start(*angles[::-1]), 0.05, rule)
    # Rounding of g, 1e-15 m/s^2, sums to nanometres.
    assert np.abs(states[:3, -1]).max() < 1e-7
    np.testing.assert_allclose(states[6:, -1], angles[::-1], rtol=1e-12)


def coning(cone: float, frequency: float, t: float, n: int) -> np.ndarray:
    """Exact turns over each interval of a body whose axis moves on a cone.

    The attitude is the rotation by ``cone`` about (cos wt, sin wt, 0); the body rate has
    w sin(cone) across and -2 w sin^2(cone / 2) along the axis of the cone.
    """
    w = 2 * math.pi * frequency
    phase = w * t * np.arange(-1, n + 1)
    signals = at_rest(n)
    signals[:, 4] = math.sin(cone) * np.diff(np.cos(phase))
    signals[:, 5] = math.sin(cone) * np.diff(np.sin(phase))
    signals[:, 2] = -2 * w * t * math.sin(cone / 2) ** 2
    return signals


def test_coning_drifts_as_the_closed_forms_say():
    """Summed turns miss w a^2 / 2 (1 - sin wT / wT) per second; two samples all but its rest.

    The correction makes good (a^2 / 3T) sin^2(wT / 2) sin(wT) of it (Miller 1983, Savage 1998).
    """
    cone, frequency, t = math.radians(1.0), 5.0, 0.01
    n = 2000
    w, time = 2 * math.pi * frequency, n * t
    missed = 0.5 * w * cone**2 * (1 - math.sin(w * t) / (w * t))
    corrected = cone**2 / (3 * t) * math.sin(w * t / 2) ** 2 * math.sin(w * t)
    signals, initial = coning(cone, frequency, t, n), start(roll=cone)
    plain = run_kernel(signals, initial, t, "trapezoidal", share=0.0)[8, -1]
    two = run_kernel(signals, initial, t, "two_sample", share=0.0)[8, -1]
    # To the next order of the cone angle, whose square is 3e-4.
    assert abs(plain) == pytest.approx(missed * time, rel=1e-3)
    assert abs(two) == pytest.approx(abs(missed - corrected) * time, rel=1e-2)
    assert abs(two) < 0.05 * abs(plain)


def test_white_noise_of_the_vertical_accelerometer():
    """sigma_p^2 = sigma_a^2 T^2 * sum k^2 T^2, k = 1 ... n, in the height alone."""
    p = problem({**FLAT_OUT, "sensors.gyroscope.noise_density": "0 °/s/√Hz"})
    n, t = p.n_samples, p.interval
    expected = 2.2e-3 * math.sqrt(100 / 2) * t**2 * math.sqrt(sum(k**2 for k in range(1, n + 1)))
    measured = p.simulate(2, 0, COUNT).errors.std(axis=1)
    assert measured[2] == pytest.approx(expected, rel=TOLERANCE)
    assert measured[2] != pytest.approx(math.sqrt(2) * expected, rel=TOLERANCE)


def test_roll_rate_noise_leaks_gravity():
    """Angle random walk N in roll: position variance g^2 N^2 t^5 / 20 across (and along)."""
    p = problem({**FLAT_OUT, "sensors.accelerometer.noise_density": "0 m/s^2/√Hz"})
    time, walk = p.n_samples * p.interval, math.radians(3e-2) / math.sqrt(2)
    expected = G * walk * math.sqrt(time**5 / 20)
    errors = p.simulate(3, 0, COUNT).errors.std(axis=1)
    # The sum over n = 400 samples exceeds the integral by 5 / 2n of the variance.
    assert errors[0] == pytest.approx(expected, rel=TOLERANCE + 5 / 4 / p.n_samples)
    roll = walk * math.sqrt(time)
    assert errors[4] == pytest.approx(roll, rel=TOLERANCE)
    assert errors[5] == pytest.approx(roll, rel=TOLERANCE)
    assert errors[6] == pytest.approx(roll, rel=TOLERANCE)


def test_levelling_tilts_by_the_offset_and_cancels_it():
    """On a straight level road the tilt b / g takes back what the offset b pushes.

    The vertical offset, which nothing levels, keeps its b t^2 / 2.
    """
    overrides = {
        **FLAT_OUT,
        **NO_NOISE,
        "sensors.accelerometer.miscalibration": "0.1 m/s^2",
        "reconstruction.integration": "trapezoidal",
    }
    p = problem({**overrides, "initial.levelling": {"duration": "10 s"}})
    levelled = p.simulate(4, 0, 2000).errors
    known = problem(overrides).simulate(4, 0, 2000).errors
    time = p.n_samples * p.interval
    assert levelled[4].std() == pytest.approx(0.1 / G, rel=5 / math.sqrt(4000))
    assert known[0].std() == pytest.approx(0.1 * time**2 / 2, rel=5 / math.sqrt(4000))
    assert np.abs(levelled[:2]).max() < 0.03 * known[0].std() * 3  # second order in b / g
    np.testing.assert_allclose(levelled[2], known[2], atol=0.03 * known[2].std() * 3)


def test_levelling_noise_falls_with_the_root_of_the_rest():
    quiet = {**FLAT_OUT, "sensors.gyroscope.noise_density": "0 °/s/√Hz"}
    sigma = 2.2e-3 * math.sqrt(100 / 2)
    for seconds in (1, 100):
        p = problem({**quiet, "initial.levelling": {"duration": f"{seconds} s"}})
        roll = p.simulate(4, 0, COUNT).errors[4].std()
        assert roll == pytest.approx(sigma / math.sqrt(100 * seconds) / G, rel=TOLERANCE)


def test_channels_are_uncorrelated():
    """Six errors of a straight run, gyroscopes too quiet to leak: one channel each.

    A shared sign bit between channels passes moment tests and fails here.
    """
    p = problem({**FLAT_OUT, "sensors.gyroscope.noise_density": "1e-9 °/s/√Hz"})
    errors = p.simulate(8, 0, 200_000).errors[[0, 1, 2, 4, 5, 6]]
    correlation = np.corrcoef(errors)[np.triu_indices(6, 1)]
    assert np.abs(correlation).max() < 5 / math.sqrt(200_000)
    squares = np.corrcoef(errors**2)[np.triu_indices(6, 1)]
    assert np.abs(squares).max() < 5 / math.sqrt(200_000)


# ---- gimbal lock -----------------------------------------------------------------------


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_pitching_over_the_vertical_is_survived(rule, sign):
    """A body at rest turns head over heels: the attitude knows, Euler angles are a convention."""
    n, t = 200, 0.01
    turn = sign * math.radians(180.0) / n
    true = Rotation.from_euler("ZYX", [[0.4, 0.0, 0.3]]) * Rotation.from_rotvec(
        np.outer(np.arange(n + 1), [0.0, turn, 0.0])
    )
    signals = np.zeros((n + 1, 6))
    signals[:, [0, 1, 3]] = true.inv().apply([0.0, 0.0, G])
    signals[:, 5] = turn
    initial = start(roll=0.3, heading=0.4)
    states = run_kernel(signals, initial, t, rule)
    assert np.isfinite(states).all()
    twin = integrate(
        signals[:, [0, 1, 3]],
        signals[:, [4, 5, 2]],
        true[0],
        np.zeros(3),
        np.zeros(3),
        G,
        t,
        rule,
    )
    np.testing.assert_allclose(states[:3].T, twin.position, atol=1e-11)
    ours = Rotation.from_euler("ZYX", states[[8, 7, 6]].T)
    assert (ours.inv() * twin.attitude).magnitude().max() < 1e-9


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_euler_angles_at_the_vertical_have_no_roll(sign):
    """Pitch ±90°: roll and heading are one rotation, which goes to the heading."""
    states = run_kernel(
        at_rest(1, (-sign * G, 0.0, 0.0)),
        start(roll=0.3, pitch=sign * math.pi / 2, heading=0.5),
        0.01,
        "rectangular",
    )
    assert states[6, 0] == 0.0
    assert states[7, 0] == pytest.approx(sign * math.pi / 2, abs=1e-9)
    assert states[8, 0] == pytest.approx(0.5 - sign * 0.3, abs=1e-9)


@pytest.mark.parametrize("angles", [(0.2, -0.7, 2.9), (0.0, 0.0, -3.0), (-1.0, 1.2, 0.1)])
def test_attitudes_from_and_to_angles_agree_with_scipy(angles):
    """What rules of a user's own begin and end with."""
    q = attitude(*angles)
    w, x, y, z = q
    scipys = Rotation.from_euler("ZYX", angles[::-1])
    np.testing.assert_allclose(
        Rotation.from_quat([x, y, z, w]).as_matrix(), scipys.as_matrix(), atol=1e-15
    )
    np.testing.assert_allclose(euler_angles(*q), angles, atol=1e-14)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_angles_at_the_vertical_have_no_roll(sign):
    found = euler_angles(*attitude(0.3, sign * math.pi / 2, 0.5))
    assert found[0] == 0.0
    np.testing.assert_allclose(found[1:], [sign * math.pi / 2, 0.5 - sign * 0.3], atol=1e-12)


# ---- convergence -----------------------------------------------------------------------


def order_of_convergence(rule: str) -> float:
    """Slope of the position's method error over the interval: a smooth, leaning lane change."""
    intervals, errors = [], []
    for rate in (50, 100, 200, 400, 800):
        p = problem(
            {
                **NO_NOISE,
                **LEANING,
                "trajectory": {
                    "shape": "quintic",
                    "length": "50 m",
                    "width": "5 m",
                    "speed": "20 m/s",
                    "lead": "200 ms",
                },
                "sensors.rate": f"{rate} Hz",
                "sensors.sampling": "none",
                "reconstruction.integration": rule,
            }
        )
        # The middle of the manoeuvre: at its end the errors of a symmetric track cancel.
        middle = round(1.2 * rate)
        errors.append(np.linalg.norm(p.history(0, 0, 1).errors[:3, middle, 0]))
        intervals.append(1 / rate)
    return np.polyfit(np.log(intervals), np.log(errors), 1)[0]


@pytest.mark.parametrize(
    ("rule", "order"),
    [("rectangular", 1), ("forward_euler", 1), ("trapezoidal", 2), ("two_sample", 2)],
)
def test_order_of_convergence(rule, order):
    assert order_of_convergence(rule) == pytest.approx(order, abs=0.1)


def test_sculling_is_corrected():
    """Rolling in phase with swaying pushes upwards; two samples see it within the interval."""
    t, n, frequency = 0.01, 1000, 8.0
    w, angle, sway = 2 * math.pi * frequency, math.radians(2.0), 5.0
    fine = 50
    time = t / fine * np.arange(-fine, n * fine + 1)
    roll = angle * np.cos(w * time)
    true = np.zeros((len(time), 3))
    true[:, 1], true[:, 2] = sway * np.cos(w * time), G
    force = Rotation.from_euler("X", roll[:, None]).inv().apply(true)
    integral = np.zeros_like(force)
    integral[1:] = np.cumsum(0.5 * (force[1:] + force[:-1]), axis=0)
    signals = np.zeros((n + 1, 6))
    signals[:, [0, 1, 3]] = np.diff(integral[::fine], axis=0) / fine
    signals[:, 4] = np.diff(roll[::fine])
    heights = [
        abs(run_kernel(signals, start(roll=angle), t, rule, share=0.0)[2, -1])
        for rule in ("trapezoidal", "two_sample")
    ]
    assert heights[0] > 0.05
    assert heights[1] < 0.1 * heights[0]
