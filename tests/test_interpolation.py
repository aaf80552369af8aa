"""Cubics between samples: a plain twin, a measured order, and where they gain and where not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from mcsim import InputError
from mcsim.kernels.interpolated import EARLY, LATE, integral_weights, value_weights
from mcsim.trajectory import Motion
from tests.conftest import ALL_ERRORS, NO_NOISE, problem, scenario
from tests.reference.random_numpy import constants, white_noise

CUBIC = {"reconstruction.integration": "cubic"}
INITIAL = {"initial.heading_error": "0.2 °", "initial.course_error": "0.3 °"}
MOMENTARY = {**NO_NOISE, "sensors.sampling": "none"}
RULES = ("rectangular", "trapezoidal", "cubic")


def polynomials(samples, i):
    """The cubic of the interval i, i + 1 of samples (n + 1, c): a parabola at either end."""
    first = min(max(i - 1, 0), max(len(samples) - 3, 0))
    last = max(min(i + 3, len(samples)), min(3, len(samples)))
    at = np.arange(first, last)
    return np.polyfit(at - i, samples[first:last], len(at) - 1)


def integrated(samples, interval, motion, nodes=2):
    """Plain Gauss quadrature of the polynomials: position and velocity (complex), heading."""
    place, v, psi = motion
    x, weights = np.polynomial.legendre.leggauss(nodes)
    x, weights = 0.5 * (x + 1.0), 0.5 * weights
    for i in range(len(samples) - 1):
        forward, left, turn = polynomials(samples, i).T
        angle = np.polyint(turn)
        force = np.polyval(forward, x) + 1j * np.polyval(left, x)
        gained = interval * weights * force * np.exp(1j * (psi + np.polyval(angle, x)))
        place = place + interval * (v + np.sum((1.0 - x) * gained))
        v, psi = v + np.sum(gained), psi + np.polyval(angle, 1.0)
    return place, v, psi


def twin(p, key, count, nodes=2):
    """Errors along, across, of heading and of course (4, count), with the same random numbers."""
    truth, z = p.truth, constants(key, np.arange(count))
    d = p.deviations(p.measurement, disturbed=True)
    noise = np.concatenate([z[None, 8:11], white_noise(key, np.arange(count), p.n_samples)])
    measured = p.signals[:, :3, None] + (d[:3, None] * z[:3])[None]
    measured = measured + p.sensor_errors.white[None, :, None] * noise
    psi = truth.heading[0] + d[4] * z[4] + d[5] * z[5]
    chi = truth.course[0] + d[4] * z[4] + d[6] * z[6]
    v = (truth.speed[0] + d[3] * z[3]) * np.exp(1j * chi)
    ends = []
    for r in range(count):
        start = truth.along[0] + 1j * truth.across[0], v[r], psi[r]
        place, end, heading = integrated(measured[:, :, r], p.interval, start, nodes)
        error = place - (truth.along[-1] + 1j * truth.across[-1])
        course = np.angle(end) - truth.course[-1]
        ends.append([error.real, error.imag, heading - truth.heading[-1], course])
    return np.array(ends).T


@pytest.mark.slow
def test_the_kernel_equals_its_plain_twin():
    p = problem({**ALL_ERRORS, **INITIAL, **CUBIC, "sensors.rate": "25 Hz"})
    ours = p.simulate(7, 0, 30).errors[[0, 1, 3, 4]]
    plain = twin(p, 7, 30)
    scale = plain.std(axis=1, keepdims=True)
    assert np.abs((ours - plain) / scale).max() < 2e-6  # normals are float32
    # Two nodes are enough: twenty change nothing that matters beside the interpolation.
    assert np.abs((plain - twin(p, 7, 30, nodes=20)) / scale).max() < 0.01
    other = problem({**ALL_ERRORS, **INITIAL, "sensors.rate": "25 Hz"}).simulate(7, 0, 30)
    assert np.abs((other.errors[[0, 1, 3, 4]] - plain) / scale).max() > 0.1


def smooth(rule, rate, duration=2.0):
    """A drive in the middle of a smooth motion: signals without jump or kink, known in closed form.

    Speed 20 + 2 sin 1.3 t, heading 0.4 sin(1.7 t + 0.3), no side-slip; the place by quadrature.
    """

    def speed(t):
        return 20.0 + 2.0 * np.sin(1.3 * t)

    def heading(t):
        return 0.4 * np.sin(1.7 * t + 0.3)

    def rate_of_turn(t):
        return 0.68 * np.cos(1.7 * t + 0.3)

    t = np.arange(round(duration * rate) + 1) / rate
    ends = [
        [quad(lambda x, f=f: speed(x) * f(heading(x)), 0.0, end, epsabs=1e-13)[0] for end in t]
        for f in (np.cos, np.sin)
    ]
    signals = np.stack(
        [2.6 * np.cos(1.3 * t), speed(t) * rate_of_turn(t), rate_of_turn(t) / rate], axis=1
    )
    p = problem({**MOMENTARY, "reconstruction.integration": rule, "sensors.rate": f"{rate} Hz"})
    truth = Motion(
        along=np.array(ends[0]),
        across=np.array(ends[1]),
        velocity_along=speed(t) * np.cos(heading(t)),
        velocity_across=speed(t) * np.sin(heading(t)),
        heading=heading(t),
        forward=signals[:, 0],
        left=signals[:, 1],
        yaw_rate=rate_of_turn(t),
    )
    return replace(p, signals=signals, truth=truth)


@pytest.mark.slow
@pytest.mark.parametrize(("rule", "order"), [("rectangular", 1), ("trapezoidal", 2), ("cubic", 4)])
def test_the_order_of_each_rule_on_smooth_signals(rule, order):
    rates = (10, 20, 40, 80)
    errors = np.array([smooth(rule, rate).method_errors() for rate in rates])
    for row in (2, 3, 4) if rule != "trapezoidal" else (2, 4):  # position, heading, course
        slope = -np.polyfit(np.log(rates), np.log(np.abs(errors[:, row])), 1)[0]
        assert slope == pytest.approx(order, abs=0.25), (row, errors[:, row])
    if rule == "cubic":
        assert errors[1, 2] < 1e-3 * smooth("trapezoidal", 20).method_errors()[2] * 20


@pytest.mark.slow
def test_histories_are_what_is_known_at_once_and_end_in_the_errors():
    """At every sample the last interval goes by the parabola of three samples, as at the end."""
    p = smooth("cubic", 20)
    history = p.history(0, 0, 1).errors[:, :, 0]
    np.testing.assert_allclose(history[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(history[:, -1], p.method_errors(), rtol=1e-9, atol=1e-13)
    for n in (1, 2, 3, 7, 20):
        start = p.truth.along[0] + 1j * p.truth.across[0]
        motion = start, p.truth.speed[0] * np.exp(1j * p.truth.course[0]), p.truth.heading[0]
        place, _, heading = integrated(p.signals[: n + 1, :3], p.interval, motion)
        assert history[0, n] == pytest.approx(place.real - p.truth.along[n], abs=1e-11)
        assert history[1, n] == pytest.approx(place.imag - p.truth.across[n], abs=1e-11)
        assert history[3, n] == pytest.approx(heading - p.truth.heading[n], abs=1e-13)


@pytest.mark.slow
def test_parabolas_are_exact_from_three_samples_on():
    """A straight run whose acceleration is a parabola of time; two samples know a line."""
    p = smooth("cubic", 10, 0.5)
    t = np.arange(6) * 0.1
    zeros = np.zeros(6)
    forward = 1.0 - 3.0 * t + 4.0 * t**2
    straight = Motion(
        along=5.0 * t + t**2 / 2 - t**3 / 2 + t**4 / 3,
        across=zeros,
        velocity_along=5.0 + t - 1.5 * t**2 + 4 * t**3 / 3,
        velocity_across=zeros,
        heading=zeros,
        forward=forward,
        left=zeros,
        yaw_rate=zeros,
    )
    signals = np.stack([forward, zeros, zeros], axis=1)
    along = replace(p, signals=signals, truth=straight).history(0, 0, 1).errors[0, :, 0]
    assert np.abs(along[[0, 2, 3, 4, 5]]).max() < 1e-14
    assert abs(along[1]) == pytest.approx(4.0 * 0.1**4 / 12.0)


@pytest.mark.slow
def test_the_linear_model_follows_from_the_steps():
    """Controls follow the errors, and the model's deviation is that of 4000 realizations."""
    p = problem({**ALL_ERRORS, **INITIAL, **CUBIC})
    sample = p.simulate(3, 0, 4000, controls=True)
    errors = sample.errors - p.method_errors()[:, None]
    rows = [0, 1, 3, 4]
    assert np.all(np.std((errors - sample.controls)[rows], axis=1) < 0.05 * errors[rows].std(1))
    predicted = np.sqrt(p.linear.second_moment[rows])
    np.testing.assert_allclose(errors[rows].std(axis=1), predicted, rtol=4.0 / np.sqrt(2 * 4000))


@pytest.mark.slow
def test_noise_gains_nothing():
    """What white noise makes is the same by straight lines and by cubics, to a few per cent."""
    lines = problem({"reconstruction.integration": "trapezoidal"}).linear.second_moment
    cubics = problem(CUBIC).linear.second_moment
    np.testing.assert_allclose(cubics[[0, 1, 3]], lines[[0, 1, 3]], rtol=0.03)
    held = problem().linear.second_moment  # control: holding samples is another weight per sample
    assert held[0] / lines[0] - 1.0 > 0.005


def method_error(rule, shape, rate, sampling="none", speed=20):
    track = {"shape": shape, "length": "20 m", "width": "5 m", "speed": f"{speed} m/s"}
    p = problem(
        {
            **NO_NOISE,
            "trajectory": track,
            "sensors.sampling": sampling,
            "sensors.rate": f"{rate} Hz",
            "reconstruction.integration": rule,
        }
    )
    return p.method_errors()[2]


@pytest.mark.slow
def test_where_interpolation_helps_and_where_not():
    """The paper: it "may partly compensate" the rate, "but it will never be fully eliminated"."""
    error = {
        (rule, shape): np.array([method_error(rule, shape, rate) for rate in (40, 80, 160)])
        for rule in RULES
        for shape in ("half_cosine", "quintic", "nonic")
    }
    # Straight lines for held samples: the paper's lag of v T is gone at once.
    assert np.all(error["trapezoidal", "half_cosine"] < 0.3 * error["rectangular", "half_cosine"])
    # Cubics: nothing where accelerations jump or have a kink, a lot where they are smooth.
    for shape in ("half_cosine", "quintic"):
        ratio = error["cubic", shape][1:] / error["trapezoidal", shape][1:]
        np.testing.assert_allclose(ratio, 1.0, atol=0.05)
    assert np.all(error["cubic", "nonic"] < [0.3, 0.02, 0.02] * error["trapezoidal", "nonic"])
    # Behind the decimation filter straight lines are as good as its smear allows.
    filtered = [method_error(rule, "half_cosine", 40, "fir") for rule in ("trapezoidal", "cubic")]
    assert filtered[0] < filtered[1] < method_error("rectangular", "half_cosine", 40, "fir")


def test_weights_are_those_of_polynomials():
    """Of four samples of any cubic: its value and its integral, exactly."""
    cubic = np.array([0.7, -1.1, 0.4, 2.0])
    samples = np.polyval(cubic, [-1.0, 0.0, 1.0, 2.0])
    for x in (EARLY, 0.5, LATE, 1.0):
        assert np.dot(value_weights(x), samples) == pytest.approx(np.polyval(cubic, x))
        assert np.dot(integral_weights(x), samples) == pytest.approx(
            np.polyval(np.polyint(cubic), x)
        )
    np.testing.assert_allclose(np.polynomial.legendre.leggauss(2)[0], [2 * EARLY - 1, 2 * LATE - 1])


def test_means_are_not_interpolated_and_turns_are_bounded():
    with pytest.raises(InputError, match="cubics go through momentary values"):
        scenario({**CUBIC, "sensors.sampling": "average"})
    wild = {**CUBIC, "sensors.rate": "2 Hz", "sensors.gyroscope.miscalibration": "100 °/s"}
    p = problem({**wild, "sensors.sampling": "none"})
    with pytest.raises(InputError, match=r"may turn by \d+° between two samples; raise"):
        p.system(p.measurement, disturbed=True)
