"""Gravity over latitude and height, against the closed form of the level ellipsoid."""

import math

import pytest

import mcsim
from mcsim.gravity import normal_gravity

STRAPDOWN = {
    "case": "strapdown",
    "trajectory": {"shape": "straight", "length": "10 m", "speed": "10 m/s"},
    "sensors": {
        "rate": "100 Hz",
        "accelerometer": {"noise_density": "1e-3 m/s^2/√Hz"},
        "gyroscope": {"noise_density": "0.01 °/s/√Hz"},
    },
    "initial": {"tilt_error": "1 °"},
    "monte_carlo": {"realizations": 200},
}


def somigliana(latitude):
    """Normal gravity (m/s²) on the ellipsoid GRS 80 (Moritz, Geodetic Reference System 1980)."""
    sine = math.sin(latitude) ** 2
    return 9.7803267715 * (1.0 + 0.001931851353 * sine) / math.sqrt(1.0 - 0.00669438002290 * sine)


@pytest.mark.parametrize("degrees", [-90, -45, 0, 30, 52, 89])
def test_agrees_with_the_level_ellipsoid(degrees):
    latitude = math.radians(degrees)
    assert abs(normal_gravity(latitude) - somigliana(latitude)) < 2e-6
    # The control: a sphere is five thousand times as far off at the pole.
    assert degrees == 0 or abs(9.780327 - somigliana(latitude)) > 1e-2


def test_agrees_with_the_velocity_papers_station():
    """Józefosław, 52.097° N, 110 m: 9.81213 m/s² are printed; anomalies are some 1e-4."""
    assert abs(normal_gravity(math.radians(52.097), 110.0) - 9.81213) < 2e-4
    assert abs(normal_gravity(math.radians(52.097), 1110.0) - 9.81213) > 2e-3


def scenario(**body):
    return mcsim.Scenario.from_dict({**STRAPDOWN, "body": body})


def test_a_scenario_takes_it_at_its_latitude():
    here = mcsim.run(scenario(latitude="60 °", height="200 m")).table
    written = mcsim.run(scenario(gravity=f"{normal_gravity(math.pi / 3, 200.0)!r} m/s^2")).table
    assert here["value"].equals(written["value"])
    assert not here["value"].equals(mcsim.run(scenario()).table["value"])


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ({"latitude": "60 °", "gravity": "9.8 m/s^2"}, "either `gravity` or `latitude`"),
        ({"height": "100 m"}, "write `latitude"),
        ({"latitude": "91 °"}, "90"),
    ],
)
def test_what_contradicts_is_refused(body, told):
    with pytest.raises(mcsim.InputError, match=told):
        scenario(**body)
