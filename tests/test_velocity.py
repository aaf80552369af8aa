"""The velocity case: kernel against a plain twin, covariance, budget against print and GTC."""

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from GTC import core as gtc
from GTC import ureal

import mcsim
from mcsim import InputError, Scenario
from mcsim.engine import run_point
from mcsim.gum import course_of_uncertainty, step_budget
from mcsim.gum.tables import BUDGET_COLUMNS, budget_table, comparison_table
from mcsim.gum.words import comparison_words
from mcsim.papers import velocity_tables
from mcsim.results import at_the_end
from mcsim.simulation.running import adjoint_weights
from mcsim.systems import problem_of
from mcsim.systems.velocity.linear import accelerations
from mcsim.systems.velocity.truth import true_run
from tests.reference import velocity_numpy

FOLDER = Path(__file__).parent.parent / "scenarios" / "velocity"
SENSORS = ("a1", "a2")


def scenario(name="a1", **overrides):
    paths = {path.replace("__", "."): value for path, value in overrides.items()}
    return Scenario.from_yaml(FOLDER / f"{name}.yaml", paths)


def problem(name="a1", **overrides):
    s = scenario(name, **overrides)
    return problem_of(s.base, s.folder)


# Truth


def test_the_run_is_a_trapezoid():
    run = true_run(scenario().base, FOLDER)
    t = np.linspace(0.0, 1.5, 15_001)
    motion = run.motion(t)
    assert motion.velocity[0] == 0.0
    assert motion.velocity[-1] == pytest.approx(0.0, abs=1e-12)
    assert motion.velocity.max() == pytest.approx(0.4)
    np.testing.assert_allclose(np.cumsum(motion.acceleration) * 1e-4, motion.velocity, atol=2.1e-4)
    assert set(np.round(motion.acceleration, 9)) == {-2.0, -1.0, 0.0, 1.0, 2.0}
    within, weights = run.within_intervals(t[::150])
    np.testing.assert_allclose(
        np.cumsum(within.acceleration @ weights) * 0.015, motion.velocity[150::150], atol=1e-12
    )


def test_sensor_and_exact_correction_are_inverse():
    """Without errors the exact tilt correction gives the true velocity, swings included."""
    values = {"tilt__order": "exact", "trajectory__vertical": {"amplitude": "0 m/s^2"}}
    assert np.abs(problem(**values).method_errors()).max() < 1e-12
    small = problem(trajectory__mounting_angle="0.03 rad").method_errors()
    # sin(theta) - theta cos(theta) = theta^3 / 3 to leading order
    assert small[-2] == pytest.approx(9.81213 * 0.03**3 / 3 * 1.5, rel=0.01)


def test_a_pitch_swing_leaks_gravity():
    """An unseen constant pitch a makes g a t; half a period of a sinusoid makes g a 2 / omega."""
    p = problem(
        trajectory__pitch={"amplitude": "1e-4 rad", "frequency": "0.5 Hz"},
        trajectory__mounting_angle="0 rad",
        instants=["1 s"],
    )
    expected = 9.81213 * 1e-4 * 2.0 / math.pi
    assert p.method_errors()[0] == pytest.approx(expected, rel=1e-6)


def test_samples_are_means_over_their_intervals():
    """A fast swing seen by a slow sensor: half a period lasts one interval, its mean is 2/pi."""
    swing = {
        "trajectory__pitch": {"amplitude": "1e-4 rad", "frequency": "5 Hz"},
        "trajectory__mounting_angle": "0 rad",
        "sensor__rate": "10 Hz",
        "instants": ["0.1 s"],
    }
    p = problem(**swing)
    assert p.method_errors()[0] == pytest.approx(9.81213e-5 * 2.0 / math.pi, rel=1e-4)


def test_momentary_samples_lose_nothing_at_jumps():
    momentary = {"sensor__sampling": "none", "trajectory__mounting_angle": "0 rad"}
    assert np.abs(problem(**momentary).method_errors()).max() < 1e-6


def test_every_interval_has_the_stated_uncertainty_whichever_errs():
    """After one step the time base makes a u(dt), be it intervals or stamps that err."""
    quiet = {
        "tilt__change": "0 rad",
        "sensor__noise": {"x": "0 g", "y": "0 g", "z": "0 g"},
        "instants": ["10 ms"],
    }
    for kind in ("independent", "stamps"):
        p = problem(sensor__time_errors=kind, **quiet)
        share = p.linear.variances["time base"][0]
        assert math.sqrt(share) == pytest.approx(2.0 * 1.6e-3, rel=0.01)
        errors = p.simulate(3, 0, 20_000).errors[0]
        assert errors.std() == pytest.approx(math.sqrt(p.linear.second_moment[0]), rel=0.025)


# Kernel


@pytest.mark.parametrize("order", ["first", "second", "exact"])
@pytest.mark.parametrize("stamps", ["independent", "stamps"])
def test_kernel_agrees_with_the_plain_twin(order, stamps):
    p = problem("a2", tilt__order=order, sensor__time_errors=stamps, runs=3)
    groups = np.arange(130)
    expected = velocity_numpy.velocities(p, 77, groups)
    curves = p.velocities(77, 0, len(groups))
    # Normals are float32: 1e-6 of a normal's effect on a step.
    np.testing.assert_allclose(curves, expected.swapaxes(0, 1), atol=2e-6)
    errors = p.simulate(77, 0, len(groups)).errors
    at = p.steps - 1
    truth = p.truth[p.steps][:, None]
    np.testing.assert_allclose(errors[0::3], expected[0, at] - truth, atol=2e-6)
    np.testing.assert_allclose(errors[1::3], expected[:, at].mean(axis=0) - truth, atol=2e-6)
    np.testing.assert_allclose(errors[2::3], expected[:, at].std(axis=0, ddof=1), atol=2e-6)


def test_groups_do_not_depend_on_how_they_are_simulated():
    p = problem()
    whole = p.simulate(3, 0, 300, controls=True)
    parts = [p.simulate(3, first, 100, controls=True) for first in (0, 100, 200)]
    np.testing.assert_array_equal(whole.errors, np.concatenate([q.errors for q in parts], 1))
    np.testing.assert_array_equal(whole.controls, np.concatenate([q.controls for q in parts], 1))
    mc = scenario().base.monte_carlo
    one, two = (run_point(p, mc, 5, threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one.estimates.low, two.estimates.low)
    fewer = replace(p, runs=5).simulate(3, 0, 300).errors
    np.testing.assert_array_equal(fewer[0], whole.errors[0])  # the first run is the same


def test_one_run_has_no_scatter():
    results = mcsim.run(scenario(runs=1, monte_carlo__realizations=200))
    rows = results.table[results.table["error"] == "repeatability"]
    assert rows["value"].isna().all()
    assert (rows["note"] == "a single run has no scatter; raise `runs`").all()


# Linear model


@pytest.mark.slow
@pytest.mark.parametrize("name", SENSORS)
@pytest.mark.parametrize("stamps", ["independent", "stamps"])
def test_covariance_agrees_with_a_million_groups(name, stamps):
    """Within 1 %; the sampling error of a deviation is 0.07 %."""
    p = problem(name, sensor__time_errors=stamps, instants=["0.7 s", "1.5 s"])
    linear = p.linear
    sums, squares, count = np.zeros(6), np.zeros(6), 1_000_000
    for first in range(0, count, 100_000):
        errors = p.simulate(11, first, 100_000).errors - p.method_errors()[:, None]
        sums += errors.sum(axis=1)
        squares += (errors**2).sum(axis=1)
    np.testing.assert_allclose(np.sqrt(squares / count), np.sqrt(linear.second_moment), rtol=0.01)
    np.testing.assert_allclose((sums / count)[2::3], linear.mean[2::3], rtol=0.01)
    # Taking steps as independent, as Eq. (30) does, must miss it.
    summed = course_of_uncertainty(scenario(name, sensor__time_errors=stamps).base, 200)
    assert abs(summed.summed_total[-1] / np.sqrt(linear.second_moment[3]) - 1.0) > 0.1


@pytest.mark.slow
def test_controls_have_the_moments_of_the_linear_model():
    p = problem("a2", sensor__time_errors="stamps")
    controls = p.simulate(4, 0, 200_000, controls=True).controls
    rows = [0, 1, 3, 4, 6, 7]
    np.testing.assert_allclose(
        np.mean(controls**2, axis=1)[rows], p.linear.second_moment[rows], rtol=5 * math.sqrt(2e-5)
    )
    assert (controls[2::3] == 0.0).all()
    errors = p.simulate(4, 0, 1000).errors
    for row in rows:
        assert np.corrcoef(errors[row], controls[row, :1000])[0, 1] > 0.999


def test_complex_step_agrees_with_differences():
    p = problem()
    for k in range(14):
        step = 1e-6 * max(1.0, abs(p.inputs[k]))
        high, low = p.inputs.copy(), p.inputs.copy()
        high[k] += step
        low[k] -= step
        slope = (accelerations(p.raw, high, 0) - accelerations(p.raw, low, 0)) / (2 * step)
        weight = p.uncertainties[k] * p.interval * slope.sum()
        assert p.weights.group[-1, k] == pytest.approx(weight, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("order", ["first", "second", "exact"])
@pytest.mark.parametrize("stamps", ["independent", "stamps"])
def test_closed_form_weights_are_those_of_the_steps_themselves(order, stamps):
    """The frame's adjoint over a run, of all that its samples and its group draw."""
    p = problem("a2", tilt__order=order, sensor__time_errors=stamps, instants=["1.5 s"])
    (samples,), (drawn,) = adjoint_weights(p._system, p.signals)
    close = {"rtol": 1e-6, "atol": 1e-12}
    w = p.weights
    np.testing.assert_allclose(samples[1:, :3] * p.white, w.steps[:, :3], **close)
    inputs = len(p.inputs)
    # Calibration acts on the run and the tilt, which cancel in part: to differences' 1e-7 of each.
    each = p.inputs[-1] * len(p.raw) * p.interval * p.uncertainties
    gap = drawn[:inputs] * p.uncertainties - w.group[-1]
    assert np.all(np.abs(gap) < 1e-6 * np.abs(w.group[-1]) + 1e-7 * each)
    assert drawn[inputs - 1] * p.uncertainties[-1] == pytest.approx(w.group[-1, -1], rel=1e-6)
    # An interval errs by the difference of the stamps at its ends, or by itself.
    time = w.steps[:, 3]
    if stamps == "stamps":
        time = time - np.append(time[1:], 0.0)
    np.testing.assert_allclose(samples[1:, 3], time, rtol=1e-6, atol=1e-9 * np.abs(time).max())
    # An offset acts on every sample of the run, and the rest is drawn by itself.
    assert np.all(samples[0] == 0.0)
    np.testing.assert_allclose(samples[1:, :3].sum(axis=0), len(p.raw) * w.per_sample, rtol=1e-6)


# Budget


def digits(printed: str) -> float:
    """Half a unit of the last digit of a number as the tables print it."""
    mantissa, _, exponent = printed.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return 0.5 * 10.0 ** (int(exponent or 0) - decimals)


#: Estimates and uncertainties of Tables 3 and 4 as printed, signs corrected.
PRINTED = {
    "a1": """0.98 1.0e-3|0.008 2.7e-3|-0.019 2.0e-3|-0.01 3.8e-3|0.027 3.0e-3|0.833 4.9e-3
        |0.047 3.6e-3|-0.018 1.2e-3|-0.146 7.5e-3|-0.004 1.6e-2|0.004 1.8e-3|1.008 1.3e-3
        |-0.01 3.8e-3|0.027 3.0e-3|0.833 4.9e-3|0.047 3.6e-3|-0.018 1.2e-3|-0.146 7.5e-3
        |0 1.8e-3|-0.132 5.5e-3|0.985 9.3e-3|-0.074 5.5e-3|0.988 9.2e-3|-0.133 5.9e-3
        |9.81213 3.0e-6|0.01 1.6e-3""",
    "a2": """1.061 5.0e-3|-0.001 6.2e-3|-0.0011 1.0e-4|0.103 1.7e-3|-0.036 1.8e-3|0.558 2.8e-3
        |0.067 5.0e-3|-0.025 5.0e-3|-0.448 2.6e-3|-0.006 7.6e-3|-0.015 7.6e-3|0.991 5.3e-3
        |0.103 1.7e-3|-0.036 1.8e-3|0.558 2.8e-3|0.067 5.0e-3|-0.025 5.0e-3|-0.448 2.6e-3
        |0 1.8e-3|-0.007 5.6e-3|1.001 6.6e-3|0.037 5.6e-3|0.998 6.6e-3|-0.007 5.9e-3
        |9.81213 3.0e-6|0.016 4.0e-3""",
}
#: Which rows' estimates a row's sensitivity takes (numbers of rows).
TAKES = {
    1: (4, 7), 2: (5, 8), 3: (6, 9), 4: (1,), 5: (2,), 6: (3,), 7: (1,), 8: (2,), 9: (3,),
    10: (4, 7), 11: (5, 8), 12: (6, 9), 13: (10,), 14: (11,), 15: (12,), 16: (10,), 17: (11,),
    18: (12,), 19: (), 20: (20, 21), 21: (20, 21), 22: (25, 26), 23: (24, 25, 26),
    24: (23, 25, 26), 25: (22, 23, 24, 26), 26: (22, 23, 24, 25),
}  # fmt: skip


def sensitivity(number: int, e: dict[int, float]) -> float:
    """The derivative of each row, written once more from Eq. (4), (5), (20), (24)."""
    if number in (1, 2, 3, 10, 11, 12):
        raw, bias = TAKES[number]
        return e[raw] - e[bias]
    if number <= 18:
        return e[TAKES[number][0]]
    if number == 19:
        return 1.0
    if number in (20, 21):
        return e[21 if number == 20 else 20] / (e[20] ** 2 + e[21] ** 2)
    tilted = e.get(22, 0.0) - e.get(23, 0.0) * e.get(24, 0.0)
    return {
        22: lambda: e[25] * e[26],
        23: lambda: e[24] * e[25] * e[26],
        24: lambda: e[23] * e[25] * e[26],
        25: lambda: tilted * e[26],
        26: lambda: tilted * e[25],
    }[number]()


@pytest.mark.parametrize("name", SENSORS)
def test_every_printed_variance_follows_within_rounding(name):
    """All 26 rows: the printed variance lies where rounding of its inputs lets it be."""
    budget = step_budget(scenario(name).base)
    cells = [cell.split() for cell in PRINTED[name].split("|")]
    half = {i: digits(v) for i, (v, _) in enumerate(cells, start=1)}
    half[19] = 0.0
    estimate = {i: float(v) for i, (v, _) in enumerate(cells, start=1)}
    for row, (_, u) in zip(budget.rows, cells, strict=True):
        taken = TAKES[row.number]
        variances = []
        for signs in itertools.product((-1.0, 1.0), repeat=len(taken) + 1):
            moved = {k: estimate[k] + s * half[k] for k, s in zip(taken, signs, strict=False)}
            uncertainty = float(u) + signs[-1] * digits(u)
            variances.append((sensitivity(row.number, moved) * uncertainty) ** 2)
        text = f"{row.printed:.1e}"
        slack = digits(text)
        low, high = min(variances), max(variances)
        assert low - slack <= row.printed <= high + slack, row
        assert low <= row.variance * 1.0001, row
        assert row.variance <= high * 1.0001, row


@pytest.mark.parametrize("name", SENSORS)
def test_printed_signs_do_not_give_the_printed_rows(name):
    """The control: with the signs as printed, rows 1, 2, 10, 11 and 22 are off by far."""
    output = scenario(name).base.budget.output
    printed = {
        "x": f"{-output.x} g",
        "y": f"{-output.y} g",
        "z": f"{output.z if name == 'a1' else -output.z} g",
    }
    budget = step_budget(scenario(name, budget__output=printed).base)
    for number in (1, 2, 10, 11):
        row = budget.rows[number - 1]
        assert abs(row.variance / row.printed - 1.0) > 0.3, row
    assert abs(budget.estimates["acx"] - float(PRINTED[name].split("|")[21].split()[0])) > 0.01


@pytest.mark.parametrize("name", SENSORS)
def test_budget_agrees_with_gtc(name):
    """Estimates, combined uncertainties and every component against the GUM Tree Calculator."""
    model = scenario(name).base
    budget = step_budget(model)
    inputs = {row.number: ureal(row.estimate, row.uncertainty) for row in budget.rows[:21]}
    acx = sum(inputs[1 + k] * (inputs[4 + k] - inputs[7 + k]) for k in range(3))
    acz = sum(inputs[10 + k] * (inputs[13 + k] - inputs[16 + k]) for k in range(3))
    theta = gtc.atan(inputs[20] / inputs[21]) + inputs[19]
    for output, result, numbers in (
        ("acx", acx, range(1, 10)),
        ("acz", acz, range(10, 19)),
        ("theta", theta, range(19, 22)),
    ):
        assert budget.estimates[output] == pytest.approx(gtc.value(result), rel=1e-12)
        assert budget.uncertainty(output) == pytest.approx(gtc.uncertainty(result), rel=1e-12)
        for number in numbers:
            component = gtc.component(result, inputs[number])
            assert math.sqrt(budget.rows[number - 1].variance) == pytest.approx(
                abs(component), rel=1e-12
            )
    # Eq. (29) takes acx, acz and theta as independent inputs.
    last = [ureal(row.estimate, row.uncertainty) for row in budget.rows[21:]]
    step = (last[0] - last[1] * last[2]) * last[3] * last[4]
    assert budget.estimates["Dv"] == pytest.approx(gtc.value(step), rel=1e-12)
    assert budget.uncertainty("Dv") == pytest.approx(gtc.uncertainty(step), rel=1e-12)


def test_combined_uncertainties_are_the_papers():
    """u(theta) 5.9e-3 rad for both; uc after 1.5 s 0.02 and 0.04 m/s, Eq. (30) and (31)."""
    for name, printed in (("a1", 0.02), ("a2", 0.04)):
        budget = step_budget(scenario(name).base)
        assert round(budget.uncertainty("theta"), 4) == 5.9e-3
        course = course_of_uncertainty(scenario(name).base, 500)
        assert round(course.summed_total[-1], 2) == printed
        assert round(course.summed_mean[-1], 2) == printed


def test_erring_time_stamps_explain_the_scatter_of_the_runs():
    """Table 2 prints s(v) = 0.006 and 0.009 m/s; independent intervals give three times that."""
    for name, printed in (("a1", 0.006), ("a2", 0.009)):
        course = course_of_uncertainty(scenario(name).base, 2000)
        assert course.other_scatter[-1] == pytest.approx(printed, rel=0.35)
        assert course.scatter[-1] > 3.0 * printed


def test_same_calibration_in_acceleration_and_tilt_cancels():
    course = course_of_uncertainty(scenario("a2").base, 2000)
    assert course.summed["zero bias"][-1] > 0.01
    assert course.simulated["zero bias"][-1] < 1e-4
    share = abs(course.interaction[-1]) / course.total[-1] ** 2
    assert share < 0.1  # ten deviations of a variance of 2000 groups are 0.3


def test_tables_and_words():
    budget, course = step_budget(scenario().base), course_of_uncertainty(scenario().base, 500)
    table = budget_table(budget, course)
    assert tuple(table.columns) == BUDGET_COLUMNS
    assert list(table["i"][:26]) == list(range(1, 27))
    assert list(table["quantity"][26:]) == [
        "u(acx)", "u(acz)", "u(theta)", "u(Dv)", "uc(vX,N)", "uc(mean vX,N)",
    ]  # fmt: skip
    comparison = comparison_table(course)
    assert len(comparison) % 151 == 0
    total = comparison[(comparison["method"] == "Eq. (30)") & (comparison["source"] == "all")]
    assert total["uncertainty [m/s]"].iloc[-1] == course.summed_total[-1]
    words = comparison_words(course)
    assert f"{course.summed_total[-1]:.3g} m/s" in words
    assert "understates" in words


def words_of(name="a1", **overrides):
    """The comparison in words, in one line, and its numbers."""
    course = course_of_uncertainty(scenario(name, **overrides).base, 500)
    return " ".join(comparison_words(course).split()), course


def test_words_on_the_calibration_hold_at_every_instant():
    """An uncertain scale factor leaves its share of the velocity, and nothing at standstill."""
    large = {
        "calibration__lxx__uncertainty": 0.1,
        "tilt__order": "exact",
        "trajectory__mounting_angle": "0.05 rad",
    }
    words, course = words_of(**large)
    left = np.hypot(course.simulated["calibration matrix"], course.simulated["zero bias"])
    at = int(np.argmax(left))
    assert left[at] == pytest.approx(0.1 / 0.98 * 0.4, rel=5 / math.sqrt(1000))
    assert f"Together they leave {left[at]:.2g} m/s at {course.time[at]:.3g} s" in words
    assert "the velocity," in words
    assert "of it at every instant" in words
    assert "nothing after 1.5 s" in words
    stopped, _ = words_of(**large, trajectory__duration="0.3 s", trajectory__top_speed="0.2 m/s",
                          instants=["0.15 s"])  # fmt: skip
    assert "nothing after 0.3 s" in stopped
    # The first order of the tilt leaves some of it beside the velocity's share.
    assert "goes with the velocity" not in words_of()[0]


def test_by_acceleration_alone_the_calibration_is_that_of_a_known_tilt():
    p = problem()
    course = course_of_uncertainty(scenario().base, 20)
    known = p.inputs.astype(float)
    theta = math.atan(
        (known[0:3] @ (known[9:12] - known[6:9])) / (known[3:6] @ (known[9:12] - known[6:9]))
    )

    def velocity(inputs):
        lx, lz, bias, g = inputs[0:3], inputs[3:6], inputs[6:9], inputs[13]
        return p.interval * g * np.sum((p.raw - bias) @ (lx - theta * lz))

    variance = 0.0
    for k in range(9):
        moved = known.copy()
        moved[k] += 1e-6
        variance += ((velocity(moved) - velocity(known)) / 1e-6 * p.uncertainties[k]) ** 2
    assert course.by_acceleration[-1] == pytest.approx(math.sqrt(variance), rel=1e-6)


@pytest.mark.parametrize(
    ("overrides", "said", "unsaid"),
    [
        ({}, "understates tilt change", "Nothing disturbs"),
        ({"tilt__change": "0 rad"}, "takes itself back", "understates tilt change"),
        ({"sensor__time_error": "0 s"}, "s(v) = ", "whose errors cancel"),
        ({"sensor__time_error": "5 ms"}, "whose errors cancel", "Nothing"),
        ({"trajectory__rest": "0.01 s"}, "of the rest is the same in every step", "averages out"),
        ({"trajectory__rest": "10 s"}, "averages out", "of the rest is the same"),
    ],
)
def test_sentences_of_the_budget_follow_from_its_numbers(overrides, said, unsaid):
    words, _ = words_of(**overrides)
    assert said in words
    assert unsaid not in words


@pytest.mark.slow
def test_a_run_without_uncertainty_says_so(tmp_path):
    zero = {
        **{
            f"calibration__{name}__uncertainty": 0.0
            for name in ("lxx", "lxy", "lxz", "lzx", "lzy", "lzz")
        },
        **{f"calibration__{name}__uncertainty": "0 g" for name in ("bx", "by", "bz")},
        "sensor__noise": {"x": "0 g", "y": "0 g", "z": "0 g"},
        "sensor__time_error": "0 s",
        "tilt__change": "0 rad",
        "gravity__uncertainty": "0 m/s²",
        "budget__rest_x__uncertainty": "0 g",
        "budget__rest_z__uncertainty": "0 g",
    }
    words, _ = words_of(**zero)
    assert words == "Nothing disturbs this run: all uncertainties are zero."
    mcsim.budget(scenario(**zero)).write(tmp_path)
    assert (tmp_path / "comparison.png").exists()


# Scenario


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"trajectory__top_speed": "2 m/s"}, "longer than the duration"),
        ({"instants": ["2 s"]}, "lies after the run"),
        ({"instants": ["1 s", "0.5 s"]}, "0.5 s follows 1 s"),
        ({"instants": ["0.503 s"]}, "not a multiple of the sampling interval"),
        ({"trajectory__rest": "0 s"}, "hold no sample"),
        ({"calibration__lxx__estimate": float("nan")}, "calibration.lxx.estimate"),
        ({"calibration__lxx__uncertainty": float("inf")}, "calibration.lxx.uncertainty"),
        ({"sensor__noise": {"x": "0.03 m/s²", "y": "1 mg", "z": "1 mg"}}, "is an acceleration"),
        ({"calibration__lzz": {"estimate": 0.0}}, "singular"),
        ({"calibration__bx__estimate": "0.4 m/s²"}, "a sensor output is needed here"),
        ({"gravity__estimate": "1e-20 m/s²"}, "must be at least 0.01 m/s²"),
        ({"calibration__lxy__estimate": 1e300}, "must be at most 100"),
        ({"trajectory__acceleration": "1e6 m/s²"}, "must be at most 100000 m/s²"),
        ({"tilt__change": "1e5 rad"}, "must be at most 1.5 rad"),
        ({"budget__rest_z__estimate": "0 g"}, "cannot follow from 0 g"),
        ({"shaker__lowest": "0.01 Hz"}, "must hold a period of the lowest frequency, 100 s"),
        ({"shaker__lowest": "9.9 Hz"}, "by a tenth at least"),
        ({"budget__printed": [1e-9]}, "at least 26 items"),
        ({"sensor__rate": "1 Hz"}, "the nearest are 0 s and 1 s"),
        ({"figure": {"panels": [{"errors": "heading"}]}}, "has no error `heading`"),
    ],
)
def test_bad_scenarios_are_explained(overrides, message):
    with pytest.raises(InputError, match=message):
        mcsim.run(scenario(**overrides))


@pytest.mark.slow
def test_sweeps_and_tables_work_as_in_the_planar_case(tmp_path):
    s = Scenario.from_yaml(
        FOLDER / "a1.yaml",
        ["sweep.sensor.time_error=[0 ms, 1 ms]", "monte_carlo.realizations=300"],
    )
    results = mcsim.run(s, output=tmp_path, jobs=1)
    table = results.table
    assert set(table["error"]) == {"velocity", "mean_velocity", "repeatability"}
    assert set(table["statistic"]) == {
        "mean", "std", "rms", "p2.5", "p50", "p95", "p97.5", "method",
    }  # fmt: skip
    assert sorted(set(table["time [s]"])) == [0.5, 1.0, 1.5]
    assert (tmp_path / "a1" / "figure.png").stat().st_size > 10_000
    again = mcsim.run(s, jobs=2).table
    pd.testing.assert_frame_equal(table, again)


def test_every_point_has_its_own_last_instant():
    swept = {
        "sweep.trajectory.duration": ["1 s", "1.5 s"],
        "instants": None,
        "monte_carlo.realizations": 100,
    }
    table = mcsim.run(Scenario.from_yaml(FOLDER / "a1.yaml", swept)).table
    last = at_the_end(table)
    assert len(last) == len(table)  # the figure draws both
    assert list(last.groupby("trajectory.duration [s]")["time [s]"].first()) == [1.0, 1.5]
    several = mcsim.run(scenario(monte_carlo__realizations=100)).table
    assert set(at_the_end(several)["time [s]"]) == {1.5}


def test_linear_answers_agree_with_monte_carlo():
    rows = {}
    for estimator in ("linear", "plain"):
        values = {"monte_carlo__estimator": estimator, "monte_carlo__realizations": 100_000}
        table = mcsim.run(scenario("a2", **values)).table
        rows[estimator] = table[table["statistic"] != "method"]["value"].to_numpy()
        names = table[table["statistic"] != "method"]["statistic"].to_numpy()
    not_means = ~np.isin(names, ["mean", "p50"])
    np.testing.assert_allclose(rows["linear"][not_means], rows["plain"][not_means], rtol=0.02)


@pytest.mark.slow
def test_runs_are_kept_and_drawn_over_time(tmp_path):
    outputs = {"outputs": {"tracks": 5, "history": True}, "monte_carlo__realizations": 100}
    results = mcsim.run(scenario(**outputs), output=tmp_path)
    assert (tmp_path / "a1" / "tracks.png").stat().st_size > 10_000
    tracks = results.tracks
    assert list(tracks.columns) == ["realization", "time [s]", "velocity [m/s]"]
    assert sorted(set(tracks["realization"])) == [-1, 0, 1, 2, 3, 4]
    last = results.history[results.history["time [s]"] > 1.499]
    assert set(last["error"]) == {"velocity", "mean_velocity", "repeatability"}


@pytest.mark.parametrize(
    "overrides",
    [
        {"gravity__estimate": "0.01 m/s²", "trajectory__vertical": {"amplitude": "1e5 m/s²"}},
        {"gravity__estimate": "1000 m/s²", "gravity__uncertainty": "1000 m/s²"},
        {"calibration__lxz__uncertainty": 100.0, "calibration__bz__uncertainty": "1000 g"},
        {"tilt__change": "1.5 rad", "tilt__order": "second"},
        {"sensor__time_error": "1e8 s"},
    ],
)
def test_extreme_but_legal_numbers_stay_finite(overrides):
    values = {"monte_carlo__realizations": 100, **overrides}
    table = mcsim.run(scenario(**values)).table
    assert np.isfinite(table[table["statistic"] != "method"]["value"]).all()
    course = course_of_uncertainty(scenario(**values).base, 20)
    assert np.isfinite(comparison_table(course)["uncertainty [m/s]"]).all()
    assert "nan" not in comparison_words(course)


@pytest.mark.slow
def test_table_2_sets_like_beside_like(monkeypatch):
    """What was measured once stands beside the distribution of the same quantity."""
    monkeypatch.setattr(velocity_tables, "GROUPS", 400)
    rows = list(velocity_tables.rows_of_table_2("a1", "0.4 m/s"))
    by_name = {row[0]: row for row in rows}
    p = problem(sensor__time_errors="stamps")
    ends = p.velocities(7, 0, 400)[-1] - p.truth[-1]
    of_mean = by_name["error of the mean of 12 runs, time stamps err"]
    # 400 groups know the median of a normal mean to 1.25 std / 20.
    spread = 1.25 * ends.mean(axis=0).std() / 20.0
    assert of_mean[2] == pytest.approx(np.median(ends.mean(axis=0)), abs=6 * spread)
    assert of_mean[3] < of_mean[1] < of_mean[4]
    largest = by_name["largest |error| of 12 runs, time stamps err"]
    assert largest[2] > abs(of_mean[2])
    assert by_name["error of the method"][2] == pytest.approx(p.method_errors()[-3])
    assert math.isnan(by_name["error of the method"][1])
    scatter = by_name["s(v) of 12 runs, time stamps err"]
    assert scatter[3] < scatter[1] < scatter[4]  # the printed 0.006 m/s agrees
    erring = by_name["s(v) of 12 runs, intervals err"]
    assert not erring[3] < erring[1] < erring[4]  # and not with these
