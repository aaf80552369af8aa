"""Attitude errors that grow into position: closed forms, ODEs by scipy, and the strapdown case."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mcsim
from mcsim import InputError
from mcsim.cli.main import exit_code
from mcsim.figures.attitude_drift import draw_drifts
from mcsim.papers import attitude_drift
from mcsim.papers.attitude_sources import sources
from mcsim.simulation.attitude_drift import (
    ANGLE_RANDOM_WALK,
    EARTH_RADIUS,
    LEVELLED,
    LEVELLED_AND_TURNED,
    SCHULER,
    SCHULER_PERIOD,
    TILT,
    TURN_RATE,
    excess,
    lasts,
    on_level_ground,
    on_round_earth,
)
from mcsim.units import STANDARD_GRAVITY as G

TIMES = [1.0, 10.0, 60.0, 600.0, 3600.0, 5400.0]


@pytest.mark.parametrize("t", TIMES)
def test_level_ground_has_the_powers_of_text_books(t):
    wanted = {
        TILT: G * t**2 / 2.0,
        TURN_RATE: G * t**3 / 6.0,
        ANGLE_RANDOM_WALK: G * math.sqrt(t**5 / 20.0),
        LEVELLED: 0.0,
        LEVELLED_AND_TURNED: G * t**2 / 4.0,
    }
    for growth, value in wanted.items():
        assert growth.position(on_level_ground, t) == pytest.approx(value, rel=1e-12)


def loop(t, x):
    """The single-axis error equations: position, velocity, tilt, bias; then their covariance.

    ``x`` holds what a unit tilt makes, what a unit bias makes, and the covariance (3, 3) of
    position, velocity and tilt with white noise of unit density on the tilt's rate.
    """
    del t
    f = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -G], [0.0, 1.0 / EARTH_RADIUS, 0.0]])
    tilted, biased, p = x[:3], x[3:6], x[6:].reshape(3, 3)
    noise = np.diag([0.0, 0.0, 1.0])
    rate = np.array([0.0, 0.0, 1.0])
    return np.concatenate([f @ tilted, f @ biased + rate, (f @ p + p @ f.T + noise).ravel()])


@pytest.mark.parametrize("t", TIMES)
def test_the_round_earth_is_the_schuler_loop(t):
    start = np.zeros(15)
    start[2] = 1.0
    end = solve_ivp(loop, (0.0, t), start, method="DOP853", rtol=1e-11, atol=1e-9).y[:, -1]
    assert TILT.position(on_round_earth, t) == pytest.approx(-end[0], rel=1e-6)
    assert TURN_RATE.position(on_round_earth, t) == pytest.approx(-end[3], rel=1e-6)
    assert ANGLE_RANDOM_WALK.position(on_round_earth, t) == pytest.approx(
        math.sqrt(end[6]), rel=1e-6
    )


@pytest.mark.parametrize("t", TIMES[3:])
def test_the_round_earth_has_the_closed_forms_of_text_books(t):
    r, x = EARTH_RADIUS, SCHULER * t
    assert TILT.position(on_round_earth, t) == pytest.approx(r * (1.0 - math.cos(x)), rel=1e-9)
    assert TURN_RATE.position(on_round_earth, t) == pytest.approx(
        r * (t - math.sin(x) / SCHULER), rel=1e-9
    )
    walk = (1.5 * x - 2.0 * math.sin(x) + math.sin(2.0 * x) / 4.0) / SCHULER
    assert ANGLE_RANDOM_WALK.position(on_round_earth, t) == pytest.approx(
        r * math.sqrt(walk), rel=1e-9
    )


def around(tilt, bias, t):
    """Where a system goes on a sphere that feels gravity along its wrong vertical; no small angle.

    Its platform turns in inertial space with ``bias``; its true vertical with its place.
    """

    def moves(now, x):
        return [x[1], G * math.sin(tilt + bias * now - x[0] / EARTH_RADIUS)]

    return solve_ivp(moves, (0.0, t), [0.0, 0.0], method="DOP853", rtol=1e-11, atol=1e-9).y[0, -1]


def test_a_pendulum_round_the_earth_agrees_while_the_tilt_is_small():
    small, bias = 1e-3, 1e-7
    assert TILT.position(on_round_earth, 3000.0) * small == pytest.approx(
        around(small, 0.0, 3000.0), rel=1e-5
    )
    assert TURN_RATE.position(on_round_earth, 3000.0) * bias == pytest.approx(
        around(0.0, bias, 3000.0), rel=1e-5
    )
    large = 2.0  # control: not the linear answer any more
    assert abs(TILT.position(on_round_earth, 1500.0) * large / around(large, 0.0, 1500.0) - 1) > 0.1


def test_how_long_level_ground_lasts():
    minutes = SCHULER_PERIOD / 60.0
    assert minutes == pytest.approx(84.4, abs=0.05)
    assert excess(LEVELLED, 600.0) == 0.0
    # 1 + x²/12, 1 + x²/20 and 1 + 5x²/84 to second order
    for growth, terms in ((TILT, 12.0), (TURN_RATE, 20.0), (ANGLE_RANDOM_WALK, 16.8)):
        time = lasts(growth, 1e-3)
        assert excess(growth, time) == pytest.approx(1e-3, rel=1e-6)
        assert (SCHULER * time) ** 2 / terms == pytest.approx(1e-3, rel=1e-2)
    assert lasts(TILT, 0.05) / 60.0 == pytest.approx(10.3, abs=0.05)


@pytest.fixture(scope="module")
def entries():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(attitude_drift, "TIMES", (10.0, 600.0))
        return list(attitude_drift.drifts("20 °/h", "0.3 °/√h"))


@pytest.mark.slow
def test_the_strapdown_case_sides_with_level_ground(entries):
    """Within 1 % while the tilt is small; not with the round earth, nor with the note's a t²."""
    assert len(entries) == 2 * len(sources("20 °/h", "0.3 °/√h"))
    for e in entries:
        if e.flat == 0.0:
            assert e.simulated < 1e-6
        elif e.tilt < 0.1 and not math.isnan(e.simulated):
            assert e.simulated == pytest.approx(e.flat, rel=0.01), e.source.name
        if e.printed == e.printed:
            assert e.printed / e.simulated == pytest.approx(2.0, rel=0.02)
    bent = [e for e in entries if e.time == 600.0 and e.flat > 0.0 and e.tilt < 0.1]
    assert all(e.simulated > 1.02 * e.round_earth for e in bent if e.simulated == e.simulated)
    # A commercial gyroscope's attitude is anywhere after ten minutes, and that is said.
    wild = [e for e in entries if e.tilt > 1.0]
    assert wild
    assert all("no longer small" in e.note and e.simulated < 0.9 * e.flat for e in wild)


@pytest.mark.slow
def test_the_figure_has_all_sources(entries):
    figure = draw_drifts(entries)
    named = {text.get_text() for axes in figure.axes for text in axes.get_legend().get_texts()}
    assert named == {e.source.name for e in entries if e.flat > 0.0}
    tops = [axes.get_ylim() for axes in figure.axes]
    assert len(set(tops)) == 1


def test_density_and_random_walk_are_the_same_noise():
    walk = {s.name: s.size for s in sources(noise="0.3 °/√h")}["yours, 0.3 °/√h"]
    density = {s.name: s.size for s in sources(noise="0.00707106781187 °/s/√Hz")}
    assert density["yours, 0.00707106781187 °/s/√Hz"] == pytest.approx(walk, rel=1e-9)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"bias": "20"}, 'attitude-drift: bias: "20" has no unit'),
        ({"bias": "20 m"}, "attitude-drift: bias: "),
        ({"bias": "0 °/h"}, "must be above zero"),
        ({"noise": "0.3 °/h"}, "attitude-drift: noise: "),
    ],
)
def test_a_gyroscope_of_ones_own_needs_units(settings, message, capsys):
    with pytest.raises(InputError, match=message.replace("(", r"\(")):
        mcsim.table("attitude-drift", **settings)
    options = [f"--{name}={value}" for name, value in settings.items()]
    assert exit_code(["table", "attitude-drift", *options]) == 2
    assert message in capsys.readouterr().err
