"""Logs of a sensor that is not healthy, or not at rest: each is named, and healthy ones are not."""

import numpy as np
import pytest

from mcsim.characterisation.health import CHECKS, Record
from mcsim.characterisation.health.oscillation import find_oscillations
from mcsim.characterisation.health.warm_up import check_warm_up, find_warm_up
from mcsim.errors import InputError
from tests.reference.noise import gauss_markov, static_noise

RATE, N_SAMPLES, WHITE = 20.0, 24_000, 2e-3
DEVIATION = WHITE * np.sqrt(RATE)
TIME = np.arange(N_SAMPLES) / RATE


def noise(seed, b=0.0, k=0.0):
    return static_noise(WHITE, b, k, RATE, N_SAMPLES, np.random.default_rng(seed))


def record_of(samples, step=None):
    return Record("accel_x", samples, RATE, step, "acceleration", "m/s²", "log.csv")


def found_in(samples, step=None):
    """Kinds of findings; a refusal counts as its first word after the name."""
    try:
        return {f.kind: f.text for check in CHECKS for f in check(record_of(samples, step))}
    except InputError as error:
        return {"refused": str(error)}


def rounded(samples, step):
    return np.round(samples / step) * step


def stuck(begin, end, step=0.0):
    samples = rounded(noise(1), step) if step else noise(1)
    samples[begin:end] = samples[begin]
    return samples


@pytest.mark.parametrize(
    ("samples", "step", "told", "way"),
    [
        (stuck(16_000, N_SAMPLES), None, "from 800 s to the end, 33 %", "--end 800 "),
        (stuck(0, 9_000), None, "from 0 s to 450 s", "--start 450 "),
        (stuck(6_000, 9_000), None, "from 300 s to 450 s", "--start 450 "),
        (stuck(6_000, N_SAMPLES, 0.5 * DEVIATION), 0.5 * DEVIATION, "to the end", "--end 300 "),
    ],
)
def test_stuck_output_is_refused_with_a_way_out(samples, step, told, way):
    text = found_in(samples, step)["refused"]
    assert "is stuck at" in text
    assert told in text
    assert way in text
    # The way works.
    option, at = way.split()
    cut = int(float(at) * RATE)
    rest = samples[:cut] if option == "--end" else samples[cut:]
    assert "refused" not in found_in(rest, step)


def test_a_short_stuck_run_is_named_and_stays():
    assert "stuck" in found_in(stuck(5000, 5060))


@pytest.mark.parametrize("held", [2, 4, 1.33])
def test_held_values_are_named(held):
    at = (np.arange(N_SAMPLES) / held).astype(int)
    for step in (0.0, 0.1 * DEVIATION):
        samples = rounded(noise(2), step)[at] if step else noise(2)[at]
        assert "fewer than" in found_in(samples, step or None)["held"]


@pytest.mark.parametrize("limits", [(-np.inf, 0.0), (-1.0, np.inf), (-1.5, 1.5), (-np.inf, 1.7)])
@pytest.mark.parametrize("step", [0.0, 0.1, 0.5])
def test_saturated_output_is_refused(limits, step):
    samples = np.clip(noise(3), *(np.array(limits) * DEVIATION))
    if step:
        samples = rounded(samples, step * DEVIATION)
    assert "saturates" in found_in(samples, step * DEVIATION or None)["refused"]


def test_a_rail_that_is_hardly_reached_is_named():
    samples = np.minimum(noise(3), 2.9 * DEVIATION)
    assert "none above" in found_in(samples)["saturates"]


@pytest.mark.parametrize(
    ("level", "told"),
    [
        (np.where(TIME > 600.0, 2.0, 1.0), "by a factor of 2"),
        (np.where(TIME > 400.0, 1.3, 1.0), "--end 400"),
        (np.where(TIME < 800.0, 1.3, 1.0), "--start 8"),
        (np.exp(0.4 * np.sin(TIME / 60.0)), "wanders between"),
    ],
)
def test_a_noise_level_that_changes_is_named(level, told):
    text = found_in(noise(4) * level)["level"]
    assert told in text.replace("399.", "400.").replace("79", "8")


@pytest.mark.slow
def test_healthy_output_is_not_blamed():
    """Also quantised, flickering and wandering; benchmarks/interval_coverage.txt has 200 logs."""
    rng = np.random.default_rng(5)
    for seed in range(40):
        samples = noise(seed, rng.choice([0.0, 1e-3]), rng.choice([0.0, 1e-4]))
        if seed % 4 == 0:
            samples += gauss_markov(30.0, 3e-3, RATE, N_SAMPLES, rng)
        step = rng.choice([0.0, 0.1, 0.5, 1.0, 2.0, 3.0]) * DEVIATION
        if step:
            samples = rounded(samples + rng.uniform(0.0, step), step)
        assert not found_in(samples, step or None)
        assert find_warm_up(samples, RATE) is None
        assert not find_oscillations(samples, RATE)[0]


@pytest.mark.parametrize(("size", "time"), [(0.02, 100.0), (-0.02, 120.0), (0.05, 50.0)])
def test_a_warm_up_is_found_and_its_way_out_works(size, time):
    samples = noise(6) + size * np.exp(-TIME / time)
    warm_up, findings = check_warm_up(record_of(samples))
    assert warm_up.size == pytest.approx(size, rel=0.2)
    assert warm_up.time == pytest.approx(time, rel=0.2)
    text = findings[0].text
    assert "warm-up" in text
    start = int(text.split("--start ")[1].split()[0])
    assert find_warm_up(samples[int(start * RATE) :], RATE) is None


def test_a_ramp_is_no_warm_up():
    assert find_warm_up(noise(7) + 2e-5 * TIME, RATE) is None


@pytest.mark.parametrize("period", [20.0, 60.0, 150.0])
def test_a_slow_oscillation_is_found(period):
    samples = noise(8) + 5e-3 * np.sin(2.0 * np.pi * TIME / period)
    lines = find_oscillations(samples, RATE)[0]
    assert 1.0 / lines[0].peak == pytest.approx(period, rel=0.15)
