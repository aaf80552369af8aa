"""Tracks against closed forms, and against their own derivatives."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson, quad
from scipy.special import ellipeinc, fresnel

from mcsim.errors import InputError
from mcsim.tracks import drive_of
from mcsim.trajectory import CurveManoeuvre
from mcsim.trajectory.curves import ClothoidCurve
from tests.conftest import scenario

SHAPES = {
    "straight": {"shape": "straight", "length": "30 m", "speed": "10 m/s"},
    "half_cosine": {"shape": "half_cosine", "length": "50 m", "width": "5 m", "speed": "20 m/s"},
    "decelerating": {
        "shape": "half_cosine",
        "length": "50 m",
        "width": "-5 m",
        "speed": "20 m/s",
        "deceleration": "3 m/s^2",
    },
    "accelerating": {
        "shape": "quintic",
        "length": "50 m",
        "width": "5 m",
        "speed": "10 m/s",
        "deceleration": "-2 m/s^2",
    },
    "stopping": {
        "shape": "quintic",
        "length": "50 m",
        "width": "5 m",
        "speed": "10 m/s",
        "deceleration": "2 m/s^2",
    },
    "double": {
        "shape": "double_lane_change",
        "length": "30 m",
        "width": "3.5 m",
        "gap": "10 m",
        "speed": "15 m/s",
    },
    "curve": {
        "shape": "curve",
        "radius": "40 m",
        "angle": "120 deg",
        "clothoid": "15 m",
        "speed": "12 m/s",
    },
    "waypoints": {
        "shape": "waypoints",
        "points": [["3 m", "1 m"], ["20 m", "8 m"], ["40 m", "5 m"], ["60 m", "20 m"]],
        "speed": "8 m/s",
    },
    "slipping": {
        "shape": "half_cosine",
        "length": "50 m",
        "width": "5 m",
        "speed": "20 m/s",
        "side_slip": "10 deg",
        "side_slip_profile": "bump",
    },
}


def drive(shape: dict):
    return drive_of(scenario({"trajectory": shape}).base.trajectory, Path())


@pytest.mark.parametrize("name", SHAPES)
def test_motion_is_consistent_with_its_own_derivatives(name):
    """Velocity is the derivative of position, acceleration of velocity, yaw rate of heading."""
    d = drive(SHAPES[name])
    t = np.linspace(0.0, d.manoeuvre.duration, 1001)[1:-1]
    t = t[np.min(np.abs(t[:, None] - np.array([*d.manoeuvre.jumps, -1.0])), axis=1) > 1e-3]
    h = 1e-4
    before, here, after = d.motion(t - h), d.motion(t), d.motion(t + h)

    def slope(name):
        return (getattr(after, name) - getattr(before, name)) / (2 * h)

    scale = np.max(here.speed)
    np.testing.assert_allclose(slope("along"), here.velocity_along, atol=1e-6 * scale)
    np.testing.assert_allclose(slope("across"), here.velocity_across, atol=1e-6 * scale)
    c, s = np.cos(here.heading), np.sin(here.heading)
    np.testing.assert_allclose(
        slope("velocity_along"), c * here.forward - s * here.left, atol=2e-5 * scale
    )
    np.testing.assert_allclose(
        slope("velocity_across"), s * here.forward + c * here.left, atol=2e-5 * scale
    )
    np.testing.assert_allclose(slope("heading"), here.yaw_rate, atol=2e-5)


@pytest.mark.parametrize("name", SHAPES)
def test_drives_begin_at_the_origin_along_the_road(name):
    motion = drive(SHAPES[name]).motion(np.array([0.0]))
    assert abs(motion.along[0]) < 1e-12
    assert abs(motion.across[0]) < 1e-12
    assert abs(motion.course[0]) < 1e-12


def test_half_cosine_length_is_an_elliptic_integral():
    """s(l) = (L / pi) E(pi l / L | -(pi D / 2 L)^2), scipy's incomplete integral."""
    curve = drive(SHAPES["half_cosine"]).manoeuvre.curve
    m = -((math.pi * 5 / (2 * 50)) ** 2)
    assert curve.length == pytest.approx(50 / math.pi * ellipeinc(math.pi, m), rel=1e-14)
    s = np.linspace(0, curve.length, 777)
    points = curve.at(s)
    np.testing.assert_allclose(
        50 / math.pi * ellipeinc(math.pi * points.along / 50, m), s, atol=1e-11
    )
    np.testing.assert_allclose(
        points.across, 2.5 * (1 - np.cos(math.pi * points.along / 50)), atol=1e-12
    )


def test_quintic_ends_without_slope_or_curvature():
    curve = drive(SHAPES["accelerating"]).manoeuvre.curve
    ends = curve.at(np.array([0.0, curve.length]))
    assert np.abs(ends.curvature).max() < 1e-9
    assert np.abs(ends.course).max() < 1e-9
    assert ends.across[1] == pytest.approx(5.0)


def test_clothoid_is_a_fresnel_integral():
    length, radius = 15.0, 40.0
    curve = ClothoidCurve(radius, 2.0, length)
    s = np.linspace(0, length, 50)
    scale = math.sqrt(math.pi * radius * length)
    sine, cosine = fresnel(s / scale)
    points = curve.at(s)
    np.testing.assert_allclose(points.along, scale * cosine, atol=1e-12)
    np.testing.assert_allclose(points.across, scale * sine, atol=1e-12)
    end = curve.at(np.array([curve.length]))
    assert end.course[0] == pytest.approx(2.0, abs=1e-14)


@pytest.mark.parametrize("clothoid", [5e-324, 1e-300, 1e-12])
def test_a_vanishing_clothoid_leaves_the_arc(clothoid):
    curve, arc = (ClothoidCurve(10.0, 0.7, c) for c in (clothoid, 0.0))
    s = np.linspace(0.1, 6.9, 30)
    for ours, without in zip(vars(curve.at(s)).values(), vars(arc.at(s)).values(), strict=True):
        np.testing.assert_allclose(ours, without, atol=1e-10)


def test_circle_without_clothoids_closes():
    curve = ClothoidCurve(10.0, 2 * math.pi, 0.0)
    end = curve.at(np.array([curve.length]))
    assert np.hypot(end.along, end.across)[0] < 1e-12


def test_waypoints_are_met():
    d = drive(SHAPES["waypoints"])
    given = np.array([[3, 1], [20, 8], [40, 5], [60, 20]], float) - [3, 1]
    s = np.linspace(0, d.manoeuvre.curve.length, 200_001)
    points = d.manoeuvre.curve.at(s)
    track = points.along + 1j * points.across
    # The road frame is turned: distances from the origin and between points remain.
    for x, y in given:
        assert np.abs(np.abs(track) - math.hypot(x, y)).min() < 1e-3
    end = track[-1]
    assert abs(end) == pytest.approx(math.hypot(*given[-1]), abs=1e-9)


@pytest.mark.parametrize("deceleration", ["2 m/s^2", "5 m/s^2"])
def test_a_vehicle_that_stops_inside_has_no_lead_out(deceleration):
    d = drive({**SHAPES["stopping"], "deceleration": deceleration})
    a = float(deceleration.split()[0])
    assert d.manoeuvre.stops
    assert d.end == pytest.approx(10 / a)
    end = d.motion(np.array([d.end]))
    assert end.speed[0] < 1e-12
    # It has covered v0^2 / 2a of the track.
    travelled, _ = quad(lambda t: 10 - a * t, 0, d.end)
    s = d.manoeuvre.curve.at(np.array([travelled]))
    assert end.along[0] == pytest.approx(s.along[0])


def test_stopping_exactly_at_the_end_counts_as_stopping():
    curve = drive(SHAPES["half_cosine"]).manoeuvre.curve
    exact = CurveManoeuvre(curve, 20.0, 400.0 / (2 * curve.length))
    assert exact.stops
    beyond = CurveManoeuvre(curve, 20.0, 400.0 / (2 * curve.length) * (1 - 1e-6))
    assert not beyond.stops


def test_leads_go_straight_at_the_speed_of_that_moment():
    d = drive({**SHAPES["decelerating"], "lead": "500 ms"})
    t = np.array([-0.5, -0.25, d.end - 0.2, d.end])
    motion = d.motion(t)
    assert motion.along[0] == pytest.approx(-0.5 * 20)
    assert np.all(d.signals(t[[0, 1, 3]]) == 0.0)
    travelled = np.hypot(*np.diff([motion.along[2:], motion.across[2:]]))[0]
    assert travelled == pytest.approx(0.2 * motion.speed[3])
    assert motion.speed[3] < 20


def test_a_sample_on_a_jump_takes_the_mean_of_both_sides():
    d = drive(SHAPES["decelerating"])
    at_start, inside = d.signals(np.array([0.0, 1e-6])).T
    np.testing.assert_allclose(at_start, inside / 2, rtol=1e-4)
    assert inside[0] == pytest.approx(-3.0)


def test_inner_jumps_are_halved_too():
    """Half-cosine lane changes with a gap: the curvature jumps four times."""
    d = drive({**SHAPES["double"], "profile": "half_cosine"})
    assert len(d.manoeuvre.jumps) == 2
    for jump in d.manoeuvre.jumps:
        before, at, after = d.signals(jump + np.array([-1e-5, 0.0, 1e-5]))[1]
        assert at == pytest.approx((before + after) / 2, rel=1e-4)
        assert abs(before - after) > 1.0


def test_side_slip_turns_the_vehicle_not_its_path():
    plain, slipping = drive(SHAPES["half_cosine"]), drive(SHAPES["slipping"])
    t = np.linspace(0, plain.end, 100)
    a, b = plain.motion(t), slipping.motion(t)
    np.testing.assert_allclose(a.along, b.along, atol=1e-12)
    np.testing.assert_allclose(a.course, b.course, atol=1e-12)
    slip = b.course - b.heading
    assert slip.max() == pytest.approx(math.radians(10), rel=1e-3)
    assert abs(slip[0]) < 1e-12


def test_heading_integrates_from_the_yaw_rate():
    d = drive(SHAPES["slipping"])
    t = np.linspace(0, d.manoeuvre.duration, 20_001)
    motion = d.motion(t)
    turned = cumulative_simpson(motion.yaw_rate[1:-1], x=t[1:-1], initial=0)
    np.testing.assert_allclose(turned, motion.heading[1:-1] - motion.heading[1], atol=1e-6)


def test_coinciding_waypoints_are_refused():
    with pytest.raises(InputError, match="points 0 and 1 coincide"):
        drive({"shape": "waypoints", "points": [["0 m", "0 m"]] * 2, "speed": "1 m/s"})


@pytest.mark.parametrize("xs", [(0, 10, 0), (0, 10, 0, 10)])
def test_waypoints_that_turn_back_are_refused(xs):
    points = [[f"{x} m", "0 m"] for x in xs]
    with pytest.raises(InputError, match="turns back on itself near point"):
        drive({"shape": "waypoints", "points": points, "speed": "1 m/s"})
