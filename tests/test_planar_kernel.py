"""The planar kernel against a plain twin, closed forms and its own invariances."""

import math

import numpy as np
import pytest

from mcsim.engine import run_point
from tests.conftest import ALL_ERRORS, NO_NOISE, problem, scenario
from tests.reference.planar_numpy import end_errors, reconstruct

TRAPEZOIDAL = {"reconstruction.integration": "trapezoidal"}
STRAIGHT = {
    "trajectory": {"shape": "straight", "length": "40 m", "speed": "10 m/s", "lead": "0 s"},
    "sensors.sampling": "none",
}


@pytest.mark.parametrize("integration", ["rectangular", "trapezoidal"])
@pytest.mark.parametrize("sampling", ["fir", "average"])
def test_kernel_equals_the_plain_twin(integration, sampling):
    """Same random numbers, exact functions: float32 normals are all that differs."""
    p = problem(
        {
            **ALL_ERRORS,
            "initial.heading_error": "0.2 °",
            "initial.course_error": "0.3 °",
            "reconstruction.integration": integration,
            "sensors.sampling": sampling,
        }
    )
    ours = p.simulate(99, 1000, 150).errors
    twin = end_errors(p, 99, np.arange(1000, 1150), integration == "trapezoidal")
    scale = twin.std(axis=1, keepdims=True)
    assert np.abs((ours - twin) / scale).max() < 2e-6


@pytest.mark.parametrize("integration", ["rectangular", "trapezoidal"])
def test_fast_rotation_agrees_with_exact_sine_and_cosine(integration):
    """Undisturbed, the kernel and the twin differ by rounding alone (1e-9 m asked)."""
    p = problem({**NO_NOISE, "reconstruction.integration": integration})
    ours = p.method_errors()
    twin = end_errors(p, 0, np.arange(1), integration == "trapezoidal")[:, 0]
    assert np.abs(ours - twin).max() < 1e-12


@pytest.mark.parametrize("integration", ["rectangular", "trapezoidal"])
def test_large_turns_use_exact_functions(integration):
    """100 °/s of miscalibration at 2 Hz turn by more than the polynomials can hold."""
    p = problem(
        {
            "sensors.rate": "2 Hz",
            "sensors.sampling": "none",
            "sensors.gyroscope.miscalibration": "100 °/s",
            "reconstruction.integration": integration,
        }
    )
    ours = p.simulate(3, 0, 100).errors
    twin = end_errors(p, 3, np.arange(100), integration == "trapezoidal")
    assert np.abs(ours - twin).max() < 1e-4  # metres; normals in float32, turns of radians


@pytest.mark.parametrize("integration", ["rectangular", "trapezoidal"])
def test_histories_follow_the_twin_and_end_in_the_errors(integration):
    p = problem({**ALL_ERRORS, "reconstruction.integration": integration})
    history = p.history(5, 10, 70)
    twin = reconstruct(p, 5, np.arange(10, 80), integration == "trapezoidal")
    assert np.abs(history.tracks[0] - twin["position"].real).max() < 1e-6
    assert np.abs(history.tracks[1] - twin["position"].imag).max() < 1e-6
    np.testing.assert_allclose(
        history.errors[:, -1], p.simulate(5, 10, 70).errors, rtol=1e-9, atol=1e-12
    )


def test_channels_are_uncorrelated():
    """Along, across and heading errors of a straight run come from one channel each.

    A shared sign bit between channels passes moment tests and fails here.
    """
    p = problem({**STRAIGHT, "sensors.gyroscope.noise_density": "1e-9 °/s/√Hz"})
    errors = p.simulate(8, 0, 200_000).errors[[0, 1, 3]]
    correlation = np.corrcoef(errors)[np.triu_indices(3, 1)]
    assert np.abs(correlation).max() < 5 / math.sqrt(200_000)
    squares = np.corrcoef(errors**2)[np.triu_indices(3, 1)]
    assert np.abs(squares).max() < 5 / math.sqrt(200_000)


COUNT = 100_000
#: Five standard errors of a standard deviation estimated from COUNT normals.
TOLERANCE = 5 / math.sqrt(2 * COUNT)


def test_white_acceleration_noise_on_a_straight_run():
    """sigma_p^2 = sigma_a^2 T^2 * sum k^2 T^2, k = 1 ... n: the closed form of Eq. (2)-(3)."""
    p = problem({**STRAIGHT, "sensors.gyroscope.noise_density": "0 °/s/√Hz"})
    n, t = p.n_samples, p.interval
    assert n == 400
    sigma_a = 2.2e-3 * math.sqrt(100 / 2)
    expected = sigma_a * t**2 * math.sqrt(sum(k**2 for k in range(1, n + 1)))
    measured = p.simulate(2, 0, COUNT).errors.std(axis=1)
    assert measured[0] == pytest.approx(expected, rel=TOLERANCE)
    assert measured[1] == pytest.approx(expected, rel=TOLERANCE)
    # Control: noise read as a two-sided density would be larger by sqrt(2).
    assert measured[0] != pytest.approx(math.sqrt(2) * expected, rel=TOLERANCE)


def test_heading_is_a_random_walk():
    p = problem(STRAIGHT)
    expected = math.radians(3e-2) * math.sqrt(100 / 2) * p.interval * math.sqrt(p.n_samples)
    assert p.simulate(3, 0, COUNT).errors[3].std() == pytest.approx(expected, rel=TOLERANCE)


def test_constant_offset_grows_with_the_square_of_time():
    """b t^2 / 2; the rectangular rule gives b T^2 n (n + 1) / 2."""
    p = problem({**STRAIGHT, **NO_NOISE, "sensors.accelerometer.miscalibration": "0.01 m/s^2"})
    n, t = p.n_samples, p.interval
    measured = p.simulate(4, 0, COUNT).errors.std(axis=1)
    assert measured[0] == pytest.approx(0.01 * t**2 * n * (n + 1) / 2, rel=TOLERANCE)
    trapezoidal = problem(
        {
            **STRAIGHT,
            **NO_NOISE,
            **TRAPEZOIDAL,
            "sensors.accelerometer.miscalibration": "0.01 m/s^2",
        }
    )
    assert trapezoidal.simulate(4, 0, COUNT).errors[1].std() == pytest.approx(
        0.01 * (n * t) ** 2 / 2, rel=TOLERANCE
    )


def test_initial_errors_on_a_straight_run():
    """Speed shifts along by t; a small direction error shifts across by v t."""
    p = problem(
        {
            **STRAIGHT,
            **NO_NOISE,
            "initial.speed_error": "0.1 m/s",
            "initial.direction_error": "0.01 °",
        }
    )
    time = p.n_samples * p.interval
    along, across, _, heading, course = p.simulate(6, 0, COUNT).errors
    assert along.std() == pytest.approx(0.1 * time, rel=TOLERANCE)
    assert across.std() == pytest.approx(math.radians(0.01) * 10 * time, rel=2 * TOLERANCE)
    # Direction turns heading and course together.
    np.testing.assert_allclose(heading, course, atol=1e-12)


def test_heading_and_course_errors_act_alone():
    heading_only = problem({**STRAIGHT, **NO_NOISE, "initial.heading_error": "1 °"})
    along, across, _, heading, course = heading_only.simulate(1, 0, 1000).errors
    assert np.abs([along, across, course]).max() < 1e-9
    assert heading.std() == pytest.approx(math.radians(1), rel=5 / math.sqrt(2000))
    course_only = problem({**STRAIGHT, **NO_NOISE, "initial.course_error": "1 °"})
    _, _, _, heading, course = course_only.simulate(1, 0, 1000).errors
    assert np.abs(heading).max() < 1e-12
    assert course.std() == pytest.approx(math.radians(1), rel=5 / math.sqrt(2000))


@pytest.mark.parametrize(
    ("overrides", "along", "across", "heading", "course"),
    [
        # Standard deviations of an independent simulation with 100,000 realizations.
        ({}, 0.00417, 0.00402, 0.0349, 0.00733),
        (ALL_ERRORS, 0.0467, 0.1016, 0.291, 0.127),
        (
            {**ALL_ERRORS, "trajectory.length": "100 m", "trajectory.speed": "10 m/s"},
            0.535,
            0.553,
            1.029,
            0.596,
        ),
    ],
    ids=["base", "all errors", "all errors, long and slow"],
)
def test_deviations_of_an_independent_simulation(overrides, along, across, heading, course):
    s = scenario({**overrides, "monte_carlo.realizations": COUNT})
    result = run_point(problem(overrides), s.base.monte_carlo, 2024, threads=2)
    std = result.estimates.value[:, 1]
    assert std[0] == pytest.approx(along, rel=0.01)
    assert std[1] == pytest.approx(across, rel=0.01)
    assert math.degrees(std[3]) == pytest.approx(heading, rel=0.01)
    assert math.degrees(std[4]) == pytest.approx(course, rel=0.01)


def order_of_convergence(integration: str) -> float:
    """Slope of the position's method error over the sampling interval, smooth track."""
    intervals, errors = [], []
    for rate in (25, 50, 100, 200, 400):
        p = problem(
            {
                "trajectory": {
                    "shape": "quintic",
                    "length": "50 m",
                    "width": "5 m",
                    "speed": "20 m/s",
                    "lead": "200 ms",
                },
                "sensors.rate": f"{rate} Hz",
                "sensors.sampling": "none",
                "reconstruction.integration": integration,
            }
        )
        history = p.history(0, 0, 1)
        # The middle of the manoeuvre: at its end the errors of a symmetric track cancel.
        undisturbed = problem_without_noise(p)
        middle = round(1.2 * rate)
        track = undisturbed.history(0, 0, 1).errors[:2, middle, 0]
        intervals.append(1 / rate)
        errors.append(np.hypot(*track))
        assert history.time[middle] == pytest.approx(1.2)
    return np.polyfit(np.log(intervals), np.log(errors), 1)[0]


def problem_without_noise(p):
    from dataclasses import replace

    errors = replace(p.sensor_errors, white=np.zeros(3), constants={})
    return replace(p, sensor_errors=errors, initial_deviations=np.zeros(12))


def test_trapezoidal_rule_is_of_second_order():
    assert order_of_convergence("trapezoidal") == pytest.approx(2.0, abs=0.1)


def test_rectangular_rule_is_of_first_order():
    assert order_of_convergence("rectangular") == pytest.approx(1.0, abs=0.1)
