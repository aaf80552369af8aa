"""The four ways of sampling against scipy and closed forms."""

import numpy as np
import pytest
from scipy.signal import decimate, firwin

from mcsim.sensors.sampling import low_pass, oversampling, sample
from tests.conftest import problem


def sine(t, _width=0.0):
    return np.stack([np.sin(2 * np.pi * 3.0 * t), np.cos(2 * np.pi * 1.5 * t)])


@pytest.mark.parametrize(
    ("rate", "factor"),
    [(100, 10), (20, 50), (1000, 1), (1344, 1), (600, 2), (333, 3), (400, 3), (700, 2)],
)
def test_dense_step_is_the_nearest_to_a_millisecond(rate, factor):
    assert oversampling(rate) == factor


@pytest.mark.parametrize("method", ["fir", "iir"])
@pytest.mark.parametrize("rate", [50.0, 100.0, 250.0])
def test_filters_equal_scipys_decimate(method, rate):
    """In the middle of a long record, where decimate's own edges are far away."""
    count = 400
    ours = sample(sine, 0.0, rate, count, method)
    factor = oversampling(rate)
    dense = sine(np.arange(-300 * factor, (count + 300) * factor + 1) / (rate * factor))
    theirs = decimate(dense, factor, ftype=method, zero_phase=True)[:, 300 : 300 + count + 1]
    if method == "iir":
        # scipy leaves the ripple of the even-order filter in the pass-band; we normalise it.
        theirs = theirs * 10 ** (2 * 0.05 / 20)
    np.testing.assert_allclose(ours, theirs, atol=1e-9)


def test_taps_are_scipys():
    taps = low_pass(80, 8)
    np.testing.assert_allclose(taps, firwin(161, 1 / 8), atol=1e-15)


def test_momentary_values_are_the_signal():
    ours = sample(sine, 0.3, 100.0, 50, "none")
    np.testing.assert_array_equal(ours, sine(0.3 + np.arange(51) / 100.0))


def test_average_is_the_mean_over_the_interval_before():
    ours = sample(sine, 0.0, 100.0, 50, "average")
    t = np.arange(51) / 100.0
    w = 2 * np.pi * 3.0
    exact = -(np.cos(w * t) - np.cos(w * (t - 0.01))) / w / 0.01
    np.testing.assert_allclose(ours[0], exact, atol=5e-5)


@pytest.mark.parametrize("method", ["fir", "iir", "none", "average"])
@pytest.mark.parametrize("rate", [37.0, 100.0, 1000.0])
def test_a_constant_stays_itself(method, rate):
    ours = sample(lambda t, _: np.full((1, len(t)), 2.5), 0.0, rate, 30, method)
    # The IIR filter's ends see its truncated past: a few parts in a million.
    np.testing.assert_allclose(ours, 2.5, rtol=1e-9 if method != "iir" else 1e-5)


@pytest.mark.parametrize("rate", ["50 Hz", "100 Hz", "200 Hz"])
def test_the_sampling_rate_never_changes_the_track(rate):
    """At 50 Hz the filter reaches 200 ms; the reconstruction still covers the stated leads."""
    p = problem({"sensors.rate": rate})
    assert p.truth.along[0] == pytest.approx(-2.0)
    duration = p.n_samples * p.interval
    assert 2.71 - 0.02 < duration < 2.73


def test_a_jump_between_dense_points_keeps_its_integral():
    """The yaw rate jumps at both ends; what the filter passes still turns by nothing in sum.

    Without the mean over the cell that holds the jump, the heading would be off by up to
    half a millisecond times the jump: 0.05 degrees here.
    """
    for rate in ("50 Hz", "100 Hz", "200 Hz", "400 Hz", "1000 Hz"):
        p = problem(
            {
                "trajectory": {
                    "shape": "half_cosine",
                    "length": "20 m",
                    "width": "10 m",
                    "speed": "20 m/s",
                },
                "sensors.rate": rate,
            }
        )
        assert abs(np.degrees(p.method_errors()[3])) < 0.003


@pytest.mark.parametrize("rate", [20.0, 100.0, 333.0, 1000.0])
@pytest.mark.parametrize("jump", [0.0, 0.1, 0.25, 0.2712])
def test_an_average_gives_a_jump_to_the_interval_that_holds_it(rate, jump):
    """Means of a step are known, also where it falls on a sample or between dense points."""

    def step(t, width):
        half = max(0.5 * width, 1e-7)
        return np.clip(0.5 + (t - jump) / (2.0 * half), 0.0, 1.0)[None]

    count = round(0.5 * rate)
    ends = np.arange(count + 1) / rate
    expected = np.clip((ends - jump) * rate, 0.0, 1.0)
    np.testing.assert_allclose(sample(step, 0.0, rate, count, "average")[0], expected, atol=1e-9)
