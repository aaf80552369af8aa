"""The linear model: weights against finite differences, moments against quadrature and sampling."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from mcsim.kernels.planar import Motion
from mcsim.simulation.lengths import length_quantile, mean_length
from tests.conftest import ALL_ERRORS, NO_NOISE, problem

EVERYTHING = {
    **ALL_ERRORS,
    "initial.heading_error": "0.2 °",
    "initial.course_error": "0.3 °",
    "trajectory.deceleration": "1 m/s^2",
}


def end_errors(p, change):
    """Undisturbed end errors after a change of the signals or the initial state."""
    signals, start = p.signals.copy(), np.array(p._start)
    change(signals, start)
    shifted = replace(p, signals=signals)
    shifted.__dict__["_start"] = Motion(*map(float, start))
    return shifted.method_errors()[list(p.errors.linear)]


def slope(p, change, step):
    up = end_errors(p, lambda s, x: change(s, x, step))
    down = end_errors(p, lambda s, x: change(s, x, -step))
    return (up - down) / (2 * step)


@pytest.mark.parametrize("integration", ["rectangular", "trapezoidal"])
@pytest.mark.parametrize("sampling", ["fir", "average"])
def test_weights_are_derivatives(integration, sampling):
    """Central differences of the kernel itself, for samples, offsets and the initial state."""
    p = problem(
        {
            **EVERYTHING,
            "reconstruction.integration": integration,
            "sensors.sampling": sampling,
        }
    )
    w = p.normal_weights
    h = 1e-4
    for i in (0, 1, 2, 77, p.n_samples - 1, p.n_samples):
        for channel in range(3):

            def disturb(signals, _start, step, i=i, channel=channel):
                signals[i, channel] += step

            expected = slope(p, disturb, h) * p.sensor_errors.white[channel]
            largest = np.abs(w.samples).max()
            np.testing.assert_allclose(
                w.samples[:, i, channel], expected, rtol=1e-4, atol=1e-6 * largest
            )
    for channel in range(3):

        def offset(signals, _start, step, channel=channel):
            signals[:, channel] += step

        expected = slope(p, offset, 1e-6) * p.sensor_errors.offsets[channel]
        np.testing.assert_allclose(w.offsets[:, channel], expected, rtol=1e-5, atol=1e-10)
    for column, places in zip((3, 4, 5, 6), ([2], [3, 4], [3], [4]), strict=True):

        def start_differs(_signals, start, step, places=places):
            start[places] += step

        expected = slope(p, start_differs, 1e-5)
        np.testing.assert_allclose(p.weights.constants[:, column], expected, rtol=1e-5, atol=1e-10)


@pytest.mark.parametrize("integration", ["rectangular", "trapezoidal"])
def test_controls_follow_the_errors_and_their_moments_are_exact(integration):
    """Small disturbances: controls equal errors; their moments hold within sampling error."""
    p = problem({**EVERYTHING, "reconstruction.integration": integration})
    n = 100_000
    sample = p.simulate(11, 0, n, controls=True)
    u = sample.errors - p.method_errors()[:, None]
    residual = (u - sample.controls).std(axis=1) / u.std(axis=1)
    assert (residual < 0.03).all()
    assert residual[3] < 1e-9  # the heading is exactly linear
    mean, second = p.linear.mean, p.linear.second_moment
    spread = np.sqrt(second - mean**2)
    assert np.abs((sample.controls.mean(axis=1) - mean) / spread).max() < 5 / np.sqrt(n)
    c2 = sample.controls**2
    assert np.abs((c2.mean(axis=1) - second) / c2.std(axis=1)).max() < 5 / np.sqrt(n)


def test_one_source_alone_is_its_share():
    """Simulated with a single disturbance, the deviation is that source's share."""
    p = problem(EVERYTHING)
    for source, path in (
        ("gyroscope miscalibration", "sensors.gyroscope.miscalibration"),
        ("initial speed error", "initial.speed_error"),
        ("initial direction error", "initial.direction_error"),
    ):
        same_track = {"trajectory.deceleration": EVERYTHING["trajectory.deceleration"]}
        alone = problem({**NO_NOISE, **same_track, path: EVERYTHING[path]})
        deviation = alone.simulate(3, 0, 20_000).errors.std(axis=1)
        expected = np.sqrt(p.linear.variances[source])
        np.testing.assert_allclose(
            deviation[[0, 1, 3, 4]], expected[[0, 1, 3, 4]], rtol=0.03, atol=2e-4
        )


@pytest.mark.parametrize(
    ("centre", "covariance", "expected"),
    [
        ([0, 0], [[1, 0], [0, 1]], np.sqrt(np.pi / 2)),
        ([1, 0], [[0.25, 0], [0, 0.25]], stats.rice(2, scale=0.5).mean()),
        ([0, 0], [[4, 0], [0, 0]], 2 * np.sqrt(2 / np.pi)),
        ([3, 4], [[0, 0], [0, 0]], 5.0),
        ([3, 4], [[1e-16, 0], [0, 1e-16]], 5.0),
        ([0, 0], [[0, 0], [0, 0]], 0.0),
    ],
)
def test_mean_length_of_plane_normal_vectors(centre, covariance, expected):
    """Rayleigh, Rice, half-normal and certain lengths."""
    ours = mean_length(np.array(centre, float), np.array(covariance, float))
    assert ours == pytest.approx(expected, rel=1e-12, abs=1e-15)


@pytest.mark.slow
def test_mean_length_of_a_correlated_vector():
    from scipy.integrate import dblquad

    centre, covariance = np.array([0.7, -0.4]), np.array([[0.9, 0.5], [0.5, 0.6]])
    density = stats.multivariate_normal(centre, covariance).pdf
    expected, _ = dblquad(
        lambda y, x: np.hypot(x, y) * density([x, y]), -8, 8, -8, 8, epsabs=1e-8, epsrel=1e-8
    )
    assert mean_length(centre, covariance) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("p", [0.05, 0.5, 0.95, 0.999])
def test_quantiles_of_plane_normal_vectors(p):
    """Rayleigh, Rice and half-normal lengths, and a certain one."""
    zero, unit = np.zeros(2), np.eye(2)
    assert length_quantile(zero, unit, p) == pytest.approx(stats.rayleigh.ppf(p), rel=1e-9)
    rice = stats.rice(2, scale=0.5).ppf(p)
    assert length_quantile(np.array([1.0, 0]), 0.25 * unit, p) == pytest.approx(rice, rel=1e-9)
    half = stats.halfnorm.ppf(p)
    assert length_quantile(zero, np.diag([1.0, 0.0]), p) == pytest.approx(half, rel=1e-4)
    assert length_quantile(np.array([3.0, 4.0]), 0.0 * unit, p) == 5.0
