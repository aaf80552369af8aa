"""Whatever a scenario says: it never crashes, and physics and statistics keep their rules."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mcsim
from mcsim import InputError, Scenario
from mcsim.systems import problem_of
from tests.conftest import BASE_YAML, scenario
from tests.strapdown import scenario as spatial_scenario

CALM = settings(max_examples=40, suppress_health_check=list(HealthCheck))


def amount(low, high):
    # What is too small for any use is refused: see ``test_units``.
    return st.floats(low, high).map(lambda x: float(f"{x:.6g}") if abs(x) > 1e-25 else 0.0)


shapes = st.one_of(
    st.fixed_dictionaries(
        {
            "shape": st.sampled_from(["half_cosine", "quintic"]),
            "length": amount(5, 200).map("{} m".format),
            "width": amount(-10, 10).map("{} m".format),
        }
    ),
    st.fixed_dictionaries(
        {"shape": st.just("straight"), "length": amount(5, 100).map("{} m".format)}
    ),
    st.fixed_dictionaries(
        {
            "shape": st.just("double_lane_change"),
            "length": amount(10, 60).map("{} m".format),
            "width": amount(-5, 5).map("{} m".format),
            "gap": amount(0, 20).map("{} m".format),
            "profile": st.sampled_from(["half_cosine", "quintic"]),
        }
    ),
    st.fixed_dictionaries(
        {
            "shape": st.just("curve"),
            "radius": amount(10, 100).map("{} m".format),
            "angle": amount(40, 300).map("{} deg".format),
            "clothoid": amount(0, 5).map("{} m".format),
        }
    ),
)
motions = st.fixed_dictionaries(
    {
        "speed": amount(1, 50).map("{} m/s".format),
        "deceleration": amount(-2, 10).map("{} m/s^2".format),
        "lead": amount(0, 300).map("{} ms".format),
        "side_slip": amount(-20, 20).map("{} deg".format),
        "side_slip_profile": st.sampled_from(["constant", "bump"]),
    }
)
rest = st.fixed_dictionaries(
    {
        "sensors.rate": amount(20, 1500).map("{} Hz".format),
        "sensors.sampling": st.sampled_from(["fir", "iir", "none", "average"]),
        "sensors.accelerometer.noise_density": amount(0, 1).map("{} m/s²/√Hz".format),
        "sensors.accelerometer.miscalibration": amount(0, 1).map("{} m/s²".format),
        "sensors.gyroscope.noise_density": amount(0, 10).map("{} °/s/√Hz".format),
        "sensors.gyroscope.miscalibration": amount(0, 50).map("{} °/s".format),
        "initial.speed_error": amount(0, 5).map("{} m/s".format),
        "initial.direction_error": amount(0, 20).map("{} °".format),
        "initial.heading_error": amount(0, 20).map("{} °".format),
        "reconstruction.integration": st.sampled_from(["rectangular", "trapezoidal"]),
        "monte_carlo.realizations": st.integers(1, 70),
        "monte_carlo.resamples": st.just(100),
    }
)


@pytest.mark.slow
@CALM
@given(shape=shapes, motion=motions, values=rest)
def test_random_scenarios_never_crash_and_keep_the_rules(shape, motion, values):
    s = scenario({"trajectory": {**shape, **motion}, **values})
    try:
        table = mcsim.run(s).table
    except InputError:
        return  # a refusal is an answer
    keeps_the_rules(table)


def keeps_the_rules(table):
    """Finite numbers, RMS from mean and deviation, angles wrapped, intervals around values."""
    for name, rows in table.groupby("error"):
        v = rows.set_index("statistic")["value"]
        if v.isna().all():
            assert name == "course"
            continue
        assert np.isfinite(v).all()
        assert math.isclose(v["rms"] ** 2, v["mean"] ** 2 + v["std"] ** 2, rel_tol=1e-9)
        if rows["unit"].iloc[0] == "deg":
            assert (v.abs() <= 180.0 + 1e-9).all()
    bounded = table[table["ci_low"].notna()]
    assert (bounded["ci_low"] <= bounded["value"]).all()
    assert (bounded["value"] <= bounded["ci_high"]).all()


bodies = st.fixed_dictionaries(
    {
        "body.bank": amount(-40, 40).map("{} °".format),
        "body.grade": amount(-40, 40).map("{} °".format),
        "body.roll.gradient": amount(0, 3).map("{} °/(m/s²)".format),
        "body.roll.natural_frequency": st.sampled_from(["0 Hz", "0.05 Hz", "1.5 Hz", "50 Hz"]),
        "body.roll.damping": amount(5, 200).map("{} %".format),
        "body.pitch.gradient": amount(0, 3).map("{} °/(m/s²)".format),
        "body.pitch.natural_frequency": amount(0.05, 20).map("{} Hz".format),
        "initial.tilt_error": amount(0, 90).map("{} °".format),
        "initial.roll_error": amount(0, 200).map("{} °".format),
        "initial.levelling": st.sampled_from([None, {"duration": "1 ms"}, {"duration": "10 s"}]),
        "reconstruction.algorithm": st.sampled_from(["strapdown", "strapdown", "planar"]),
        "reconstruction.integration": st.sampled_from(
            ["rectangular", "forward_euler", "trapezoidal", "two_sample"]
        ),
    }
)


@pytest.mark.slow
@CALM
@given(shape=shapes, motion=motions, values=rest, body=bodies)
def test_random_strapdown_scenarios_never_crash_and_keep_the_rules(shape, motion, values, body):
    overrides = {"trajectory": {**shape, **motion}, **values, **body}
    try:
        table = mcsim.run(spatial_scenario(overrides)).table
    except InputError:
        return  # a refusal is an answer
    keeps_the_rules(table)


@pytest.mark.slow
@CALM
@given(shape=shapes, speed=amount(5, 30), seed=st.integers(0, 2**64 - 1))
def test_doubling_all_noise_doubles_the_deviations_of_linear_errors(shape, speed, seed):
    """With the same random numbers; noise small enough for the errors to be linear."""
    track = {**shape, "speed": f"{speed} m/s"}
    deviations = []
    for factor in (1.0, 2.0):
        p = problem_of(
            scenario(
                {
                    "trajectory": track,
                    "sensors.accelerometer.noise_density": f"{factor * 1e-5} m/s²/√Hz",
                    "sensors.gyroscope.noise_density": f"{factor * 1e-4} °/s/√Hz",
                }
            ).base,
            None,
        )
        deviations.append(p.simulate(seed, 0, 64).errors.std(axis=1)[[0, 1, 3, 4]])
    np.testing.assert_allclose(deviations[1] / deviations[0], 2.0, rtol=1e-3)


@CALM
@given(st.text(max_size=200))
def test_random_text_is_refused_with_a_message(text):
    try:
        Scenario.from_yaml(text + "\n")
    except InputError as error:
        assert str(error)


lines = BASE_YAML.splitlines()


@pytest.mark.slow
@settings(max_examples=150)
@given(
    line=st.integers(0, len(lines) - 1),
    start=st.integers(0, 60),
    length=st.integers(0, 12),
    junk=st.text("{}[]:,#&*!|>'\"%@`-? \t01.eEmMµ°√/²nNaf\n", max_size=6),
)
def test_damaged_scenarios_are_read_or_refused_but_never_crash(line, start, length, junk):
    damaged = list(lines)
    damaged[line] = lines[line][:start] + junk + lines[line][start + length :]
    try:
        _ = Scenario.from_yaml("\n".join(damaged) + "\n").points
    except InputError as error:
        assert str(error)
