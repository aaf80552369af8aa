"""Recorded runs to a velocity: against GTC, scipy, print, the kernel, and in a closed loop."""

import json
import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from GTC import core as gtc
from GTC import ureal
from scipy.integrate import cumulative_trapezoid

import mcsim
from benchmarks.measured_velocity import BENCHES, NAMES, Bench, coverage, measured, recorded
from mcsim import InputError, Scenario
from mcsim.calibration.scatter import SampleScatter
from mcsim.cli.main import exit_code
from mcsim.gum import step_budget
from mcsim.measured_velocity.correction_file import NAMES as QUANTITIES
from mcsim.measured_velocity.correction_file import CorrectionInput, read_correction
from mcsim.measured_velocity.group import Group, TimeBase, group_of, run_of, time_base
from mcsim.measured_velocity.measurement import measure, step_budget_of
from mcsim.measured_velocity.propagation import Inputs, draw, sums, velocities
from mcsim.measured_velocity.run_log import RecordedRuns
from mcsim.measured_velocity.segments import Length, Rule, segments
from mcsim.systems import problem_of
from mcsim.systems.velocity.raw_log import raw_log

FOLDER = Path(__file__).parent.parent / "scenarios" / "velocity"
A1 = FOLDER / "a1.yaml"


def group(raw, intervals, rests, noise=(0.0, 0.0, 0.0), rest_samples=1000, interval_error=0.0):
    """A group of given arrays: (M, n, 3), (M, n), (M, 3)."""
    m, n = np.shape(intervals)
    return Group(
        names=tuple(f"run {i}" for i in range(m)),
        time=np.append(0.0, np.mean(np.cumsum(intervals, axis=1), axis=0)),
        raw=np.asarray(raw, float),
        intervals=np.asarray(intervals, float),
        rests=np.asarray(rests, float),
        rest_samples=np.full(m, rest_samples),
        reference=None,
        scatter=SampleScatter(np.asarray(noise, float), np.ones(3), np.full(3, 1e3)),
        time_base=TimeBase(float(np.mean(intervals)), interval_error, 0.0, 1000),
        alignment="samples",
        begins=(0.0,) * m,
        lengths=(1.0,) * m,
        steps=(n,) * m,
        lost=0,
    )


def inputs(correlation=None, order=0, stamps=False, **changes):
    """Inputs with A1's calibration, and larger other uncertainties than it has."""
    c = read_correction(A1)
    if correlation is not None:
        c = replace(c, covariance=correlation * np.outer(c.deviations, c.deviations))
    known = {
        "tilt_change": 1.8e-3, "gravity": 9.81213, "gravity_error": 0.05, "interval_error": 1.6e-3,
    } | changes  # fmt: skip
    return Inputs(c, stamps=stamps, order=order, **known)


def some_group(m=3, n=5, seed=2):
    generator = np.random.default_rng(seed)
    raw = np.array([-0.07, -0.02, 0.83]) + 0.2 * generator.standard_normal((m, n, 3))
    intervals = 0.01 * (1.0 + 0.2 * generator.random((m, n)))
    rests = np.array([-0.07, -0.017, 0.84]) + 1e-3 * generator.standard_normal((m, 3))
    return group(raw, intervals, rests, (3.8e-3, 3.0e-3, 4.9e-3), rest_samples=4)


# Velocity


@pytest.mark.parametrize("order", [0, 1, 2])
def test_velocity_is_scipys_integral_of_the_horizontal_acceleration(order):
    """Output that holds over each interval, integrated by trapezoids over its corners."""
    g, known = some_group(n=40), inputs(order=order)
    row = dict(zip(QUANTITIES, known.correction.estimates, strict=True))
    lx, lz = ([row[f"l{a}{b}"] for b in "xyz"] for a in "xz")
    bias = np.array([row["bx"], row["by"], row["bz"]])
    for run, raw, rest, dt in zip(velocities(known, g), g.raw, g.rests, g.intervals, strict=True):
        theta = math.atan2((rest - bias) @ lx, (rest - bias) @ lz)
        x, z = (raw - bias) @ lx, (raw - bias) @ lz
        a = [
            x - z * theta,
            (x - z * theta) / (1.0 + theta**2),
            x * math.cos(theta) - z * math.sin(theta),
        ][order]
        t = np.append(0.0, np.cumsum(dt))
        corners = np.repeat(t, 2)[1:-1]
        v = cumulative_trapezoid(9.81213 * np.repeat(a, 2), corners, initial=0.0)
        np.testing.assert_allclose(run[1:], v[1::2], rtol=1e-12, atol=1e-14)


def test_velocity_meets_a_smooth_motion_at_first_order():
    """Momentary samples over varying intervals: the error halves with the interval."""

    def error(n):
        generator = np.random.default_rng(3)
        t = np.append(0.0, np.cumsum(1.0 + 0.4 * generator.random(n)))
        t *= 1.0 / t[-1]
        true = 2.0 * np.sin(2.0 * np.pi * t[:-1]) + t[:-1]
        known = inputs()
        known = replace(
            known, correction=replace(known.correction, estimates=np.eye(1, 9)[0] + np.eye(9)[5])
        )
        raw = np.column_stack([true / 9.81213, 0.0 * true, np.ones(n)])
        g = group(raw[None], np.diff(t)[None], [[0.0, 0.0, 1.0]])
        return abs(velocities(known, g)[0, -1] - 0.5)

    errors = [error(n) for n in (1000, 2000, 4000)]
    assert errors[0] < 1e-3
    for coarse, fine in pairwise(errors):
        assert 1.7 < coarse / fine < 2.4


# Uncertainty


def test_sums_are_gtcs_of_independent_steps():
    """Eq. (26)-(33): in every step fresh inputs of acx, acz and of both at rest."""
    g, known = some_group(), inputs()
    own = sums(known, g, velocities(known, g))
    e, u, noise = known.correction.estimates, known.correction.deviations, g.scatter.deviation

    def corrected(axis, raw, noisy):
        first = 0 if axis == "x" else 3
        return sum(
            ureal(e[first + k], u[first + k])
            * (ureal(raw[k], noisy * noise[k]) - ureal(e[6 + k], u[6 + k]))
            for k in range(3)
        )

    def step(raw, rest, dt, noisy=1.0):
        theta = gtc.atan(corrected("x", rest, noisy) / corrected("z", rest, noisy))
        theta = theta + ureal(0.0, known.tilt_change)
        a = corrected("x", raw, noisy) - corrected("z", raw, noisy) * theta
        dv = a * ureal(known.gravity, known.gravity_error) * ureal(dt, known.interval_error)
        return gtc.uncertainty(dv) ** 2

    systematic = np.zeros(3)
    for i in range(3):
        steps = list(zip(g.raw[i], [g.rests[i]] * 5, g.intervals[i], strict=True))
        expected = np.sqrt(np.cumsum([step(*s) for s in steps]))
        np.testing.assert_allclose(own.single[i, 1:], expected, rtol=1e-9)
        systematic[i] = sum(step(*s, noisy=0.0) for s in steps)
    scatter = np.std(velocities(known, g)[:, -1], ddof=1)
    assert own.mean[-1] == pytest.approx(math.sqrt(systematic.mean() + scatter**2 / 3), rel=1e-9)


CORRELATION = np.eye(9)
CORRELATION[0, 2] = CORRELATION[2, 0] = -0.6
CORRELATION[5, 8] = CORRELATION[8, 5] = 0.5


def of_gtc(g, known, correlation):
    """Uncertainty of the last velocity of run 0 and of the mean: inputs shared by all steps."""
    e, u, noise = known.correction.estimates, known.correction.deviations, g.scatter.deviation
    c = [ureal(e[k], u[k], independent=False) for k in range(9)]
    for i in range(9):
        for j in range(i):
            gtc.set_correlation(float(correlation[i, j]), c[i], c[j])
    change, gravity = ureal(0.0, known.tilt_change), ureal(known.gravity, known.gravity_error)
    runs = []
    for raw, rest, dt in zip(g.raw, g.rests, g.intervals, strict=True):
        r = [ureal(rest[k], noise[k] / math.sqrt(g.rest_samples[0])) for k in range(3)]
        rx = sum(c[k] * (r[k] - c[6 + k]) for k in range(3))
        rz = sum(c[3 + k] * (r[k] - c[6 + k]) for k in range(3))
        theta = gtc.atan(rx / rz) + change
        stamps = [ureal(0.0, known.interval_error / math.sqrt(2.0)) for _ in range(len(dt) + 1)]
        v = 0.0
        for n, interval in enumerate(dt):
            m = [ureal(raw[n, k], noise[k]) - c[6 + k] for k in range(3)]
            a = sum(c[k] * m[k] for k in range(3))
            a = a - sum(c[3 + k] * m[k] for k in range(3)) * theta
            error = stamps[n + 1] - stamps[n] if known.stamps else ureal(0.0, known.interval_error)
            v = v + a * gravity * (interval + error)
        runs.append(v)
    return gtc.uncertainty(runs[0]), gtc.uncertainty(sum(runs) / len(runs))


def calibration_alone():
    """Errors of the calibration, and of nothing else."""
    g = some_group()
    silent = replace(g.scatter, deviation=np.zeros(3))
    known = inputs(CORRELATION, tilt_change=0.0, gravity_error=0.0, interval_error=0.0)
    return replace(g, scatter=silent), known


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["intervals", "stamps", "calibration alone"])
def test_monte_carlo_is_gtcs_of_shared_inputs(kind):
    g, known = some_group(), inputs(CORRELATION, stamps=kind == "stamps")
    if kind == "calibration alone":
        g, known = calibration_alone()
    draws = 40_000
    found = draw(known, g, draws, 3)
    expected = of_gtc(g, known, CORRELATION)
    # Five standard errors of a deviation; what is not linear is less.
    tolerance = 5.0 / math.sqrt(2.0 * draws)
    assert found.single[0, -1] == pytest.approx(expected[0], rel=tolerance)
    assert found.mean[-1] == pytest.approx(expected[1], rel=tolerance)
    # 95 % of normal values, whose ends are known to about this.
    half = 0.5 * (found.high[-1] - found.low[-1])
    assert half == pytest.approx(1.96 * expected[1], rel=2.0 * tolerance)


def test_correlations_of_the_calibration_matter():
    """The control: without them GTC says something else, by more than the test above forgives."""
    g, known = calibration_alone()
    correlated, other = of_gtc(g, known, CORRELATION), of_gtc(g, known, np.eye(9))
    assert abs(correlated[1] / other[1] - 1.0) > 5.0 / math.sqrt(2.0 * 40_000)


@pytest.mark.slow
@pytest.mark.parametrize("stamps", ["stamps", "independent"])
def test_monte_carlo_is_that_of_the_velocity_case(stamps):
    """Undisturbed raw output of a scenario: the kernel's groups scatter as the draws do."""
    scenario = Scenario.from_yaml(A1, [f"sensor.time_errors={stamps}", "runs=3"])
    p = problem_of(scenario.base, scenario.folder)
    n, m = len(p.raw), p.runs
    noise = p.white
    g = group(
        np.tile(p.raw, (m, 1, 1)), np.full((m, n), p.interval), np.tile(p.inputs[9:12], (m, 1)),
        noise,
    )  # fmt: skip
    known = replace(
        inputs(stamps=stamps == "stamps"),
        gravity_error=3e-6,
        interval_error=p.time_error,
    )
    count = 10_000
    found = draw(known, g, count, 5)
    kernel = p.errors_over_time(1, 0, count).std(axis=2)
    # One rest for all runs there, here one for each: 1.8 mm/s of 27.
    for k in (50, 100, 150):
        assert found.single[0, k] == pytest.approx(kernel[0, k], rel=0.04)
        assert found.mean[k] == pytest.approx(kernel[1, k], rel=0.04)


@pytest.mark.parametrize("name", ["a1", "a2"])
def test_tables_3_and_4_follow_where_averages_are_theirs(name):
    """All 26 rows of `mcsim budget`, from runs whose averages are the table's estimates."""
    model = Scenario.from_yaml(FOLDER / f"{name}.yaml").base
    expected, point = step_budget(model), model.budget
    c = read_correction(FOLDER / f"{name}.yaml")
    raw = np.array([point.output.x, point.output.y, point.output.z])
    swing = np.array([1.0, -1.0, 0.5, -0.5])[:, None] * np.array([0.1, 0.02, 0.05])
    # The outputs at rest that acx,0 and acz,0 follow from, y being that while moving.
    lx, lz, bias = c.estimates[:3], c.estimates[3:6], c.estimates[6:]
    y = raw[1] - bias[1]
    sought = np.array([point.rest_x.estimate - lx[1] * y, point.rest_z.estimate - lz[1] * y])
    x, z = np.linalg.solve(np.array([[lx[0], lx[2]], [lz[0], lz[2]]]), sought)
    rest = bias + np.array([x, y, z])
    noise = np.array([model.sensor.noise.x, model.sensor.noise.y, model.sensor.noise.z])
    g = group(
        [raw + swing, raw - 0.5 * swing], np.full((2, 4), point.interval), [rest, rest], noise,
        interval_error=model.sensor.time_error,
    )  # fmt: skip
    known = Inputs(
        c, model.tilt.change, model.gravity.estimate, model.gravity.uncertainty,
        g.time_base.deviation, False,
    )  # fmt: skip
    found = step_budget_of(measure(known, g, 200))
    for own, row, printed in zip(found.rows, expected.rows, point.printed, strict=True):
        assert own.quantity == row.quantity
        assert own.estimate == pytest.approx(row.estimate, rel=1e-9, abs=1e-15)
        # Rows 20, 21 have u as computed, the scenario as printed with two digits.
        assert own.uncertainty == pytest.approx(row.uncertainty, rel=0.03)
        assert own.variance == pytest.approx(row.variance, rel=0.06)
        # The rows of A2 rest on estimates of one or two printed digits; `tests/test_velocity.py`
        # goes through their rounding.
        if name == "a1":
            assert own.variance == pytest.approx(printed, rel=0.12), row


def test_nonlinearity_goes_into_lxx_by_equation_34():
    c = read_correction(A1)
    m0 = np.linalg.inv([[0.98, 0.008, -0.019], [0, 1, 0], [-0.004, 0.004, 1.008]])
    expected = math.hypot(1e-3, 1000e-6 / m0[0, 0] / math.sqrt(3.0))
    assert c.with_nonlinearity(1000e-6).deviations[0] == pytest.approx(expected, rel=1e-12)
    np.testing.assert_array_equal(c.with_nonlinearity(1e-3).deviations[1:], c.deviations[1:])


# Rest and motion


def record(motion, rest=5.0, after=3.0, rate=100.0, noise=4e-3, seed=1):
    """A rest, a forward acceleration (m/s²) at its samples, and a standstill."""
    before, behind = round(rest * rate), round(after * rate)
    forward = np.concatenate([np.zeros(before), motion, np.zeros(behind)])
    raw = np.column_stack([forward / 9.81, 0.0 * forward, 1.0 + 0.0 * forward])
    raw = raw + noise * np.random.default_rng(seed).standard_normal(raw.shape)
    return RecordedRuns("run", np.arange(len(raw)) / rate, raw, None)


TRAPEZOID = np.repeat([2.0, 0.0, -2.0], [20, 110, 20])


@pytest.mark.parametrize("slow", [False, True])
def test_rest_and_motion_are_found(slow):
    """Within 0.15 s outside the motion; of a slow start no more than 0.03 s, 0.5 mm/s, is lost."""
    t = np.arange(300) / 100
    motion = 0.5 * np.sin(2.0 * np.pi * t / 3.0) if slow else TRAPEZOID
    (found,), words = segments(record(motion), Rule(), True)
    assert 500 - 15 <= found.start <= 500 + 3 * slow
    assert 500 + len(motion) - 1 - 3 * slow <= found.end <= 500 + len(motion) + 15
    assert found.first == 0
    assert "means over 0.1 s" in words


def test_a_long_rest_is_never_broken_by_noise():
    """Ten minutes at 100 Hz, and sixty seconds of other seeds: the noise alone moves nothing."""
    assert len(segments(record(TRAPEZOID, rest=600.0), Rule(), False)[0]) == 1
    for seed in range(20):
        assert len(segments(record(TRAPEZOID, rest=60.0, seed=seed), Rule(), False)[0]) == 1


def test_runs_between_rests_are_found_and_long_drives_are_said():
    one = record(TRAPEZOID)
    raw = np.concatenate([one.raw] * 4)
    several = RecordedRuns("runs", np.arange(len(raw)) / 100, raw, None)
    found, _ = segments(several, Rule(), False)
    assert [(s.start - 500) // 10 for s in found] == [n * len(one.raw) // 10 - 1 for n in range(4)]
    assert [s.first for s in found][1:] == [s.end for s in found][:-1]
    (whole,), words = segments(several, Rule(), True)
    assert (whole.start, whole.end) == (found[0].start, found[-1].end)
    assert "one run, with 3 such stretches in it" in words
    cruise = record(np.repeat([2.0, 0.0, -2.0], [20, 400, 20]))
    assert len(segments(cruise, Rule(), False)[0]) == 2
    assert len(segments(cruise, Rule(still=4.5), False)[0]) == 1


def test_stated_rest_and_duration_are_kept():
    run = record(TRAPEZOID)
    (found,), words = segments(run, Rule(Length(5.0), Length(1.5)), True)
    assert (found.start, found.end) == (500, 650)
    assert words == "rest as stated, the first 5 s; motion of 1.5 s"
    (found,), _ = segments(run, Rule(Length(500, True), Length(150, True)), True)
    assert (found.start, found.end) == (500, 650)
    (found,), words = segments(run, Rule(Length(5.0)), True)
    assert 650 <= found.end <= 665
    _, words = segments(run, Rule(Length(5.1), Length(1.5)), True)
    assert "does the motion begin before?" in words


@pytest.mark.parametrize(
    ("rule", "run", "message"),
    [
        (Rule(Length(60.0)), record(TRAPEZOID), "--rest 60 s: run lasts 9.49 s"),
        (Rule(Length(5.0), Length(9.0)), record(TRAPEZOID), "holds 4.49 s"),
        (Rule(), record(np.zeros(100)), "nothing moves"),
        (Rule(), record(np.sin(np.arange(1000)), rest=0.0), "does not begin at rest"),
        (Rule(still=30.0), record(TRAPEZOID), "must begin with such a rest"),
    ],
)
def test_records_that_fit_no_rule_are_refused(rule, run, message):
    with pytest.raises(InputError, match=message):
        segments(run, rule, True)


def test_lost_samples_keep_the_velocity():
    """A run that lost samples at constant speed is interpolated, and ends where the other does."""
    runs = []
    for lost in (0, 7):
        whole = record(TRAPEZOID, noise=0.0)
        keep = np.ones(len(whole.time), bool)
        keep[560 : 560 + lost] = False
        runs.append(RecordedRuns(f"{lost}", whole.time[keep], whole.raw[keep], None))
    cut = [run_of(r, segments(r, Rule(Length(5.0), Length(1.5)), True)[0][0], r.name) for r in runs]
    assert [run.lost for run in cut] == [0, 7]
    base = time_base([r.time for r in runs])
    assert base.deviation < 1e-12
    g = group_of(cut, base)
    assert g.alignment == "time"
    known = inputs(gravity=9.81)
    plain = replace(
        known, correction=replace(known.correction, estimates=np.eye(1, 9)[0] + np.eye(9)[5])
    )
    v = velocities(plain, g)
    np.testing.assert_allclose(v[1], v[0], atol=1e-12)
    assert v[0, 60] == pytest.approx(0.4)
    assert group_of(cut[:1], base).alignment == "samples"


def test_the_stamps_tell_their_errors():
    generator = np.random.default_rng(1)
    independent = np.cumsum(0.01 + 1.6e-3 * generator.standard_normal(20_000))
    even = np.arange(20_000) / 100 + 1.6e-3 / math.sqrt(2.0) * generator.standard_normal(20_000)
    for stamps, correlation in ((independent, 0.0), (even, -0.5)):
        base = time_base([stamps[:10_000], stamps[10_000:]])
        assert base.deviation == pytest.approx(1.6e-3, rel=0.03)
        assert base.correlation == pytest.approx(correlation, abs=0.03)
        assert base.interval == pytest.approx(0.01, rel=5e-3)


# The closed loop


def small(**changes):
    overrides = ("runs=2", "trajectory.rest=3 s", "instants=[1.5 s]", "tilt.order=exact")
    return replace(Bench("a1", overrides), **changes)


@pytest.mark.slow
def test_the_truth_lies_within_monte_carlos_interval():
    """At the end of the motion; the equations as printed, the control, hold it too seldom."""
    groups = 200
    found = coverage(small(), groups)
    end = dict(zip(NAMES, found.two[1], strict=True))
    error = math.sqrt(0.95 * 0.05 / groups)
    for name in ("MC, run", "MC, mean"):
        assert abs(end[name] - 0.95) < 4.0 * error
    assert abs(found.interval[1] - 0.95) < 4.0 * error
    one = dict(zip(NAMES, found.one[1], strict=True))
    assert abs(one["MC, mean"] - 0.683) < 4.0 * math.sqrt(0.683 * 0.317 / groups)
    assert end["Eq. (30), run"] < 0.95 - 6.0 * error


def test_a_raw_log_is_that_of_its_scenario():
    model = Scenario.from_yaml(A1, ["runs=2"]).base
    still = Scenario.from_yaml(
        A1,
        {
            "runs": 2, "tilt.change": "0 rad", "sensor.time_error": "0 s",
            "gravity.uncertainty": "0 m/s²",
            **{f"sensor.noise.{a}": "0 g" for a in "xyz"},
            **{f"calibration.{q}.uncertainty": "0" if q[0] == "l" else "0 g" for q in QUANTITIES},
        },
    ).base  # fmt: skip
    p = problem_of(still, FOLDER)
    log = {title: np.asarray(values) for title, values in raw_log(still, 1).items()}
    raw = np.column_stack([log[f"a{a} [g]"] for a in "xyz"])
    np.testing.assert_allclose(raw[1000:1150], p.raw, atol=1e-14)
    np.testing.assert_allclose(raw[:1000], np.tile(p.inputs[9:12], (1000, 1)), atol=1e-14)
    np.testing.assert_allclose(log["true velocity [m/s]"][1000:1150], p.truth[:-1], atol=1e-14)
    np.testing.assert_array_equal(log["run"], np.repeat([1, 2], 1250))
    found = measured(Bench("a1"), still, 1, 0)
    assert abs(found.runs[0, -1] - p.method_errors()[-3]) < 1e-12
    # Another group is another draw; the same is the same.
    assert raw_log(model, 1, 0)["ax [g]"][0] == raw_log(model, 1, 0)["ax [g]"][0]
    assert raw_log(model, 1, 0)["ax [g]"][0] != raw_log(model, 1, 1)["ax [g]"][0]
    assert set(BENCHES) >= {"A1, intervals err", "A2, intervals err"}
    assert len(recorded(model, 1, 0)) == 2


# Files and the command


@pytest.fixture(scope="module")
def logged():
    """Two runs of A1 as a table, seed 1."""
    return pd.DataFrame(raw_log(Scenario.from_yaml(A1, ["runs=2"]).base, 1))


@pytest.fixture
def here(tmp_path, monkeypatch, logged):
    monkeypatch.chdir(tmp_path)
    logged.to_csv("runs.csv", index=False)
    return logged


OPTIONS = {
    "motion": {"rest": "1000 samples", "duration": "150 samples"},
    "monte_carlo": {"draws": 300},
}


def test_units_and_files_make_no_difference(here):
    base = mcsim.velocity("runs.csv", A1, **OPTIONS).measurement
    other = here.drop(columns="run").rename(columns={"time [s]": "time [ms]"})
    other["time [ms]"] *= 1e3
    units = (("x", 9.80665, "m/s^2"), ("y", 1e3, "mg"), ("z", 16384.0, "16384 counts/g"))
    for axis, factor, unit in units:
        other[f"a{axis} [{unit}]"] = other.pop(f"a{axis} [g]") * factor
    for number in (1, 2):
        other[here["run"] == number].to_csv(f"run{number}.csv", index=False)
    split = mcsim.velocity(["run1.csv", "run2.csv"], A1, **OPTIONS).measurement
    np.testing.assert_allclose(split.runs, base.runs, atol=1e-9)
    assert split.drawn.mean[-1] == pytest.approx(base.drawn.mean[-1], rel=1e-6)


def test_one_file_without_a_column_of_runs(here):
    here.drop(columns="run").to_csv("one.csv", index=False)
    notes = []
    found = mcsim.velocity(
        "one.csv", A1, motion={"runs": 2}, monte_carlo={"draws": 300}, tell=notes.append
    )
    assert found.measurement.group.runs == 2
    assert found.runs["from"].tolist() == ["one.csv, motion 1", "one.csv, motion 2"]
    assert any("2 runs, aligned at the start of motion" in n for n in notes)
    with pytest.raises(InputError, match="--runs 3: 2 found"):
        mcsim.velocity("one.csv", A1, motion={"runs": 3})
    whole = mcsim.velocity("one.csv", A1, monte_carlo={"draws": 300}, tell=notes.append)
    assert whole.measurement.group.runs == 1
    assert any("one.csv is one run, with 1 such stretch" in n for n in notes)
    with pytest.raises(InputError, match="give each run its file"):
        mcsim.velocity("one.csv", A1, motion={"runs": 2, "rest": "10 s"})


def test_runs_whose_clock_starts_again_are_not_joined(here):
    """The advice is followed: the same runs come back; a wrap-around of the clock goes on."""
    base = mcsim.velocity("runs.csv", A1, **OPTIONS).measurement
    again = here["time [s]"] - here.groupby("run")["time [s]"].transform("first")
    trials = here.assign(**{"time [s]": again}).rename(columns={"run": "trial"})
    trials.to_csv("trials.csv", index=False)
    with pytest.raises(InputError, match=r'2 runs, as the column "trial".*--run-column trial$'):
        mcsim.velocity("trials.csv", A1, **OPTIONS)
    found = mcsim.velocity("trials.csv", A1, read={"run_column": "trial"}, **OPTIONS).measurement
    np.testing.assert_allclose(found.runs, base.runs, atol=1e-9)
    trials.drop(columns="trial").to_csv("bare.csv", index=False)
    line = 2 + int((here["run"] == 1).sum())
    with pytest.raises(InputError, match=rf"starts again at line {line}: .*--run-column NAME"):
        mcsim.velocity("bare.csv", A1, **OPTIONS)
    one = here[here["run"] == 1].drop(columns="run")
    wrapped = one.assign(
        **{"time [s]": (one["time [s]"] + 2.0**32 * 1e-6 - 5.0) % (2.0**32 * 1e-6)}
    )
    wrapped.to_csv("wrapped.csv", index=False)
    single = mcsim.velocity("wrapped.csv", A1, **OPTIONS).measurement
    np.testing.assert_allclose(single.runs[0], base.runs[0], atol=1e-6)


def test_metres_per_second_squared_are_divided_in_words(here):
    metres = here.rename(columns={f"a{axis} [g]": f"a{axis} [m/s^2]" for axis in "xyz"})
    for axis in "xyz":
        metres[f"a{axis} [m/s^2]"] *= 9.80665
    metres.to_csv("metres.csv", index=False)
    for file, said in (("metres.csv", 1), ("runs.csv", 0)):
        found = mcsim.velocity(file, A1, **OPTIONS)
        notes = [n for n in found.notes if "divided by standard gravity, 9.80665 m/s²" in n]
        assert len(notes) == said
        assert all(n.endswith("right if the calibration is from m/s² as well") for n in notes)


@pytest.mark.parametrize("start", [0.0, 1.7e9])
def test_regular_stamps_tell_no_errors(here, start):
    """Rounding alone is judged neither as u(Δt) nor as whose errors they are."""
    one = here[here["run"] == 1].drop(columns="run")
    one.assign(**{"time [s]": np.round(start + np.arange(len(one)) / 100, 2)}).to_csv(
        "even.csv", index=False, float_format="%.12f"
    )
    found = mcsim.velocity("even.csv", A1, **OPTIONS)
    assert found.measurement.inputs.interval_error == 0.0
    said = "\n".join(found.notes)
    assert "u(Δt) is taken as 0; give --interval-uncertainty" in said
    assert "neighbouring intervals" not in said
    known = {"interval_uncertainty": "1 ms"}
    found = mcsim.velocity("even.csv", A1, known=known, **OPTIONS)
    assert found.measurement.inputs.interval_error == 1e-3
    assert "give --time-errors" in "\n".join(found.notes)


@pytest.mark.usefixtures("here")
def test_the_gravity_that_is_stated_is_said():
    known = {"gravity": "9.81213 m/s²"}
    assert any(
        n == "g = 9.81213 m/s², u = 0 m/s², of --gravity, as no --gravity-uncertainty is given"
        for n in mcsim.velocity("runs.csv", A1, known=known, **OPTIONS).notes
    )


def test_wheels_are_a_reference(here):
    """Speed, rates of two wheels, their angles and ticks of an encoder say the same."""
    t, v = here["time [s]"], here["true velocity [m/s]"]
    turned = np.append(0.0, np.cumsum(v[:-1] * np.diff(t)))
    table = here.assign(
        **{
            "left [rad/s]": 1.1 * v / 0.2,
            "right [rad/s]": 0.9 * v / 0.2,
            "wheel [deg]": np.degrees(turned / 0.2),
            "encoder": np.round(turned / (2.0 * np.pi * 0.2) * 1e6).astype(int),
        }
    )
    table.to_csv("wheels.csv", index=False)
    wheel = {"wheel_radius": "0.2 m"}

    def reference(**options):
        return mcsim.velocity("wheels.csv", A1, reference=options, **OPTIONS).measurement.reference

    speed = reference(columns=["true velocity"])
    assert speed.max() == pytest.approx(0.4)
    np.testing.assert_allclose(reference(columns=["left", "right"], **wheel), speed, atol=1e-12)
    assert reference(columns=["left"], **wheel).max() == pytest.approx(0.44)
    for columns in (["wheel"], ["encoder in ticks"]):
        turning = reference(columns=columns, ticks_per_turn=1e6, **wheel)
        # Slopes over two intervals round the corners of the ramps.
        assert np.abs(turning - speed).max() < 0.03
        assert turning[60] == pytest.approx(0.4, abs=1e-3)
    # An own file on the same clock, at another rate; the reference's uncertainty widens nothing.
    at = np.arange(0.0, t.iloc[-1], 0.004)
    pd.DataFrame({"time [s]": at, "speed [km/h]": 3.6 * np.interp(at, t, v)}).to_csv("speed.csv")
    own = reference(columns=["speed"], files=["speed.csv"])
    np.testing.assert_allclose(own, speed, atol=0.012)


@pytest.mark.usefixtures("here")
def test_what_is_known_comes_from_options_files_or_is_said(tmp_path):
    file = tmp_path / "calibration.yaml"
    text = "".join(
        f"  {q}: {{estimate: {e}{g}, uncertainty: {u}{g}}}\n"
        for q, e, u in zip(QUANTITIES, read_correction(A1).estimates, [1e-3] * 9, strict=True)
        for g in [" g" if q[0] == "b" else ""]
    )
    file.write_text(f"calibration:\n{text}correlations: [[lxx, bx, -0.4]]\n")
    notes = []
    found = mcsim.velocity("runs.csv", file, tell=notes.append, **OPTIONS).measurement.inputs
    assert found.correction.covariance[0, 6] == pytest.approx(-0.4e-6)
    assert (found.gravity, found.tilt_change) == (9.80665, 0.0)
    assert found.gravity_error == pytest.approx(0.053 / math.sqrt(12.0))
    said = "\n".join(notes)
    assert "no --gravity: standard gravity" in said
    assert "no --tilt-change" in said
    assert "u(Δt) = 1.5" in said or "u(Δt) = 1.6" in said
    known = {
        "gravity": "9.81213 m/s²", "gravity_uncertainty": "3e-6 m/s²", "unevenness": "1 mm",
        "axle_distance": "0.573 m", "nonlinearity": "1000 ppm", "interval_uncertainty": "1 ms",
        "time_errors": "stamps", "tilt_order": "exact",
    }  # fmt: skip
    found = mcsim.velocity("runs.csv", file, known=known, **OPTIONS).measurement.inputs
    # The source: 1 mm of one axle against the other are 0.1 degrees.
    assert math.degrees(found.tilt_change) == pytest.approx(0.1, rel=1e-3)
    assert (found.gravity_error, found.interval_error) == (3e-6, 1e-3)
    assert (found.stamps, found.order) == (True, 2)
    assert isinstance(found.correction, CorrectionInput)


BAD = [
    (["--rest", "10"], "--rest: "),
    (["--rest", "0 samples"], "write a whole number"),
    (["--gravity-uncertainty", "1 m/s²"], "needs --gravity"),
    (["--unevenness", "1 mm"], "go together"),
    (["--tilt-change", "1 °", "--unevenness", "1 mm", "--axle-distance", "1 m"], "keep one"),
    (["--tilt-change", "40 °"], "small angles"),
    (["--reference", "speed"], 'no column "speed" for the reference'),
    (["--reference", "run"], "has no unit"),
    (["--reference", "run in ticks"], "ticks need --ticks-per-turn"),
    (["--reference", "ax in rad/s"], "needs --wheel-radius"),
    (["--reference", "ax in Hz"], "no unit of a speed"),
    (["--wheel-radius", "0.1 m"], "needs a column, --reference"),
    (["--run-column", "lap"], 'no column "lap" of runs'),
    (["--columns", "accel_x=ax,accel_y=ay"], "no column of accel_z"),
    (["--draws", "5"], "must lie between 200"),
    (["--runs", "3"], "--runs 3: 2 found"),
    (["--still", "-1 s"], "must be above zero"),
    (["--duration", "20 s"], "--duration 20 s"),
]


@pytest.mark.parametrize(("options", "message"), BAD, ids=lambda x: " ".join(x)[:30])
@pytest.mark.usefixtures("here")
def test_bad_options_are_explained_and_nothing_is_written(options, message, capsys):
    arguments = ["velocity", "runs.csv", "--calibration", str(A1), "--output", "out", *options]
    assert exit_code(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert "Traceback" not in err
    assert not Path("out").exists()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sensor: {}\n", "calibration: is missing"),
        ("calibration: {lxx: {estimate: 1}}\n", "lzz"),
        ("calibration: 5\n", "a block of keys"),
        (None, "correlations: \\['lxx', 'lxx', 1\\]"),
    ],
)
def test_bad_calibrations_are_explained(tmp_path, text, message):
    file = tmp_path / "c.yaml"
    plain = (
        "calibration:\n  lxx: {estimate: 1}\n  lzz: {estimate: 1}\n"
        "  bx: {estimate: 0 g}\n  bz: {estimate: 0 g}\ncorrelations: [[lxx, lxx, 1]]\n"
    )
    file.write_text(text or plain)
    with pytest.raises(InputError, match=message):
        read_correction(file)


def test_a_sensor_upside_down_is_refused(here):
    here.assign(**{"az [g]": -here["az [g]"]}).to_csv("down.csv", index=False)
    with pytest.raises(InputError, match="is z upward"):
        mcsim.velocity("down.csv", A1, **OPTIONS)


@pytest.mark.slow
def test_from_a_scenario_to_table_and_picture(tmp_path, monkeypatch, capsys):
    """`mcsim run` writes raw runs, `mcsim velocity` takes them back to their velocity."""
    monkeypatch.chdir(tmp_path)
    settings = ["--set", "outputs.runs=true", "--realizations", "50", "--no-figures", "--quiet"]
    assert exit_code(["run", str(A1), *settings, "--output", "out"]) == 0
    arguments = [
        "--calibration", str(A1), "--reference", "true velocity", "--reference-uncertainty", "1 %",
        "--draws", "500", "--output", "out",
    ]  # fmt: skip
    assert exit_code(["velocity", "out/a1/runs.csv", *arguments]) == 0
    out, err = capsys.readouterr()
    assert "The equations sum steps as if independent" in " ".join(out.split())
    assert "Against the reference the error is" in " ".join(out.split())
    assert "12 runs, aligned at the start of motion" in err
    folder = Path("out/runs-velocity")
    table = pd.read_csv(folder / "velocity.csv")
    runs = table[[f"run {i} [m/s]" for i in range(1, 13)]].to_numpy()
    np.testing.assert_allclose(table["mean [m/s]"], runs.mean(axis=1))
    np.testing.assert_allclose(table["s(v) [m/s]"], runs.std(axis=1, ddof=1))
    assert table["reference [m/s]"].max() == pytest.approx(0.4)
    end = table.iloc[-1]
    u = end["u of the mean, Monte Carlo [m/s]"]
    assert abs(end["error of the mean [m/s]"]) < 4.0 * u
    assert len(pd.read_csv(folder / "budget.csv")) == 32
    assert {p.name for p in folder.glob("*.png")} == {
        "velocity.png", "comparison.png", "shares-dv.png", "shares-acx.png",
    }  # fmt: skip
    told = json.loads((folder / "provenance.json").read_text())
    assert told["inputs"].keys() == {"runs.csv", "a1.yaml"}
    assert any("u(Δt)" in remark for remark in told["remarks"])


def test_raw_runs_of_a_sweep_are_refused():
    text = A1.read_text() + "\noutputs: {runs: true}\nsweep:\n  runs: [2, 3]\n"
    with pytest.raises(InputError, match=r"outputs\.runs: raw runs are of one point"):
        mcsim.run(Scenario.from_yaml(text))


def test_raw_runs_that_would_fill_the_disk_are_refused():
    with pytest.raises(InputError, match="raw runs would be"):
        Scenario.from_yaml(A1, ["outputs.runs=true", "sensor.rate=100000 Hz", "runs=100"])
