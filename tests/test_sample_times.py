"""Intervals that vary, given and random, against plain twins, closed forms and orders."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import ndtri

from mcsim import InputError, Scenario
from mcsim.cli.own import run_own
from mcsim.kernels.planar import Planar
from mcsim.logs.stamps import even_instants, read_stamps
from mcsim.systems import problem_of
from tests.conftest import ALL_ERRORS, NO_NOISE, problem, scenario
from tests.reference import uneven
from tests.reference.random_numpy import constants, white_noise
from tests.strapdown import EVERYTHING, RULES
from tests.strapdown import problem as spatial_problem

ROOT = Path(__file__).parent.parent
SCENARIOS, EXAMPLES = ROOT / "scenarios", ROOT / "docs" / "examples"
MEASURED, NOMINAL = ({"reconstruction.intervals": name} for name in ("measured", "nominal"))
SMOOTH = {"trajectory.shape": "quintic", "sensors.sampling": "none"}
FORCE, TURN = [0, 1, 3], [4, 5, 2]
SPEED = 20.0


def recorded(folder, rate, spread=0.3, seed=3, duration=4.0, **more):
    """Overrides for a file of stamps whose intervals differ by ``spread``, each its own."""
    random = np.random.default_rng(seed)
    count = int(rate * duration)
    stamps = np.cumsum(1.0 + spread * random.uniform(-1.0, 1.0, count)) / rate
    file = folder / f"stamps_{rate}_{spread}_{seed}.csv"
    np.savetxt(file, stamps, "%.12f", header="time [s]", comments="")
    given = {f"sensors.time.stamps.{key}": value for key, value in more.items()}
    return {"sensors.time.stamps.file": str(file), "sensors.rate": f"{rate} Hz", **given}


def per_second(p):
    """Undisturbed signals with rates in the place of turns per interval."""
    signals = p.signals.copy()
    turns = [k for k, element in enumerate(p.sensor_errors.elements) if element == "gyroscope"]
    signals[:, turns] /= p.interval
    return signals


def believed(p):
    t = p.truth
    velocity = t.velocity_along[0] + 1j * t.velocity_across[0]
    return t.along[0] + 1j * t.across[0], velocity, t.heading[0]


# --- given instants ---------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["rectangular", "trapezoidal"])
def test_recorded_stamps_are_integrated_as_a_plain_loop_does(tmp_path, rule):
    own = recorded(tmp_path, 100)
    p = problem({**own, **MEASURED, "reconstruction.integration": rule, **NO_NOISE})
    stamps = read_stamps(tmp_path / "stamps_100_0.3_3.csv", None, "")
    np.testing.assert_allclose(p.times, stamps[: len(p.times)], atol=1e-12)
    intervals = np.append(np.nan, np.diff(p.times))
    states = uneven.planar(per_second(p), intervals, *believed(p), rule)
    place, velocity, heading = (np.array(column) for column in zip(*states, strict=True))
    ours = p.states(0, 0, 1)[:, :, 0]
    np.testing.assert_allclose(ours[0], place.real, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours[1], place.imag, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours[2] + 1j * ours[3], velocity, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours[4], heading, rtol=0, atol=1e-9)
    nominal = problem({**own, **NOMINAL, "reconstruction.integration": rule, **NO_NOISE})
    assert np.abs(nominal.states(0, 0, 1)[:2, -1, 0] - ours[:2, -1]).max() > 0.01


@pytest.mark.slow
@pytest.mark.parametrize("rule", RULES)
def test_recorded_stamps_are_integrated_in_space_as_a_plain_loop_does(tmp_path, rule):
    p = spatial_problem(
        {**EVERYTHING, **recorded(tmp_path, 100), "reconstruction.integration": rule}
    )
    signals, truth = per_second(p), p.truth
    angles = [truth.attitude.heading[0], truth.attitude.pitch[0], truth.attitude.roll[0]]
    position, velocity, attitude = uneven.strapdown(
        signals[:, FORCE],
        signals[:, TURN],
        np.append(np.nan, np.diff(p.times)),
        Rotation.from_euler("ZYX", angles),
        truth.velocity[:, 0],
        truth.position[:, 0],
        p.gravity,
        rule,
    )
    errors = p.method_errors()
    np.testing.assert_allclose(errors[:3], position - truth.position[:, -1], rtol=0, atol=1e-9)
    end = [truth.attitude.heading[-1], truth.attitude.pitch[-1], truth.attitude.roll[-1]]
    heading, pitch, roll = attitude.as_euler("ZYX") - end
    course = np.arctan2(velocity[1], velocity[0]) - truth.course[-1]
    np.testing.assert_allclose(errors[4:], [roll, pitch, heading, course], rtol=0, atol=1e-10)


@pytest.mark.slow
def test_stamps_that_are_even_change_nothing(tmp_path):
    """The kernel that reads intervals gives what the other one gives, to rounding."""
    own = recorded(tmp_path, 100, spread=0.0)
    for rule in ("rectangular", "trapezoidal"):
        given = {**ALL_ERRORS, **SMOOTH, "reconstruction.integration": rule}
        even, stamped = problem(given), problem({**given, **own})
        assert even.kernel is Planar
        assert stamped.kernel is not Planar
        np.testing.assert_allclose(
            stamped.simulate(7, 0, 200).errors, even.simulate(7, 0, 200).errors, atol=1e-9
        )


@pytest.mark.slow
@pytest.mark.parametrize(("rule", "order"), [("rectangular", 1.0), ("trapezoidal", 2.0)])
def test_a_rule_keeps_its_order_with_steps_that_vary(tmp_path, rule, order):
    """Position against rate, in root mean square over schedules: by least squares."""

    def position(rate, intervals):
        squares = []
        for seed in range(8):
            own = {**SMOOTH, **recorded(tmp_path, rate, seed=seed), **intervals}
            own["reconstruction.integration"] = rule
            squares.append(problem(own).method_errors()[2] ** 2)
        return np.sqrt(np.mean(squares))

    rates = [50, 100, 200, 400]
    errors = [position(rate, MEASURED) for rate in rates]
    slope = -np.polyfit(np.log(rates), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.15)
    # Nominal intervals walk away from the true ones by the root of their number.
    nominal = [position(rate, NOMINAL) for rate in rates]
    assert -np.polyfit(np.log(rates), np.log(nominal), 1)[0] < 0.8


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rule", "order"),
    [("rectangular", 1.0), ("forward_euler", 1.0), ("trapezoidal", 2.0), ("two_sample", 2.0)],
)
def test_a_rule_in_space_keeps_its_order_with_steps_that_vary(tmp_path, rule, order):
    def position(rate):
        squares = []
        for seed in range(10 if order > 1.0 else 4):
            own = {**EVERYTHING, **SMOOTH, **recorded(tmp_path, rate, seed=seed)}
            # A jump of the acceleration between samples would be of first order for any rule.
            own |= {"reconstruction.integration": rule, "trajectory.deceleration": "0 m/s^2"}
            squares.append(spatial_problem(own).method_errors()[3] ** 2)
        return np.sqrt(np.mean(squares))

    rates = [50, 200, 800]
    slope = -np.polyfit(np.log(rates), np.log([position(rate) for rate in rates]), 1)[0]
    assert slope == pytest.approx(order, abs=0.15)


@pytest.mark.slow
def test_a_rate_that_is_not_the_stated_one_scales_the_drive():
    """One per cent more samples than stated: the nominal drive is one per cent longer."""
    faster = {"sensors.time.rate_error": "1 %", "reconstruction.integration": "trapezoidal"}
    nominal, measured = (problem({**NO_NOISE, **faster, **way}) for way in (NOMINAL, MEASURED))
    drive = nominal.times[-1]
    assert nominal.method_errors()[2] == pytest.approx(0.01 * SPEED * drive, rel=1e-3)
    assert np.abs(measured.method_errors()).max() < 1e-4


# --- instants and stamps of each realization ---------------------------------------------


def twin(p, key, realizations, rule):
    """Errors (5, r) of a planar problem in plain numpy, from the same random numbers."""
    n, t, times = p.n_samples, p.interval, p.schedule.times
    number = np.asarray(realizations)
    z = constants(key, number)
    noise = np.concatenate([z[None, 8:11], white_noise(key, number, n)])
    deltas, lost = np.zeros((n + 1, len(number))), np.zeros((n + 1, len(number)), bool)
    if times.interval_jitter:
        deltas = times.interval_jitter * uneven.instants(key, number, n)
        deltas[0] = 0.0
    stamps, chance = uneven.arrivals(key, number, n)
    lost = chance < ndtri(times.lost)
    lost[-1] = False
    signals, truth, errors = per_second(p), p.truth, []
    slopes = np.gradient(signals, t, axis=0)
    scale = np.array([1.0, 1.0, 1.0 / t])
    for r in range(len(number)):
        measured = signals + slopes * deltas[:, r, None]
        measured = measured + scale * p.sensor_errors.white * noise[:, :, r]
        stamped = np.arange(n + 1) * t + deltas[:, r] + times.stamp_jitter * stamps[:, r]
        passed = uneven.passed(stamped, lost[:, r], t if p.schedule.nominal else None)
        passed[-1] -= deltas[-1, r]  # errors are those at the last instant
        place, velocity, heading = uneven.planar(measured, passed, *believed(p), rule)[-1]
        error = place - (truth.along[-1] + 1j * truth.across[-1])
        course = np.angle(velocity) - truth.course[-1]
        errors.append([error.real, error.imag, abs(error), heading - truth.heading[-1], course])
    return np.array(errors).T


EVERY = {
    "sensors.time.interval_jitter": "1 ms",
    "sensors.time.stamp_jitter": "0.5 ms",
    "sensors.time.lost": "5 %",
}


@pytest.mark.slow
@pytest.mark.parametrize("way", [MEASURED, NOMINAL], ids=["measured", "nominal"])
@pytest.mark.parametrize("rule", ["rectangular", "trapezoidal"])
def test_each_realization_equals_its_plain_twin(rule, way):
    p = problem({**EVERY, **way, "reconstruction.integration": rule})
    ours, plain = p.simulate(7, 0, 60).errors, twin(p, 7, range(60), rule)
    scale = plain.std(axis=1, keepdims=True)
    assert np.abs((ours - plain) / scale).max() < 5e-6  # normals are float32
    unmoved = twin(problem({**way, **EVERY, "sensors.time.lost": "0 %"}), 7, range(60), rule)
    assert np.abs((ours - unmoved) / scale).max() > 0.1


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["rectangular", "trapezoidal"])
def test_each_realization_equals_its_plain_twin_to_a_nanometre(rule):
    """Where what is random is small, float32 leaves nothing; losses are as frequent as before."""
    small = {
        "sensors.time.interval_jitter": "20 ns",
        "sensors.time.stamp_jitter": "20 ns",
        "sensors.time.lost": "5 %",
        "reconstruction.integration": rule,
    }
    p = problem({**NO_NOISE, **small})
    ours, plain = p.simulate(7, 0, 40).errors, twin(p, 7, range(40), rule)
    np.testing.assert_allclose(ours[:3], plain[:3], rtol=0, atol=1e-9)


@pytest.mark.slow
def test_results_do_not_depend_on_blocks():
    p = problem({**ALL_ERRORS, **EVERY})
    whole = p.simulate(5, 0, 300).errors
    parts = [p.simulate(5, first, 100).errors for first in (0, 100, 200)]
    np.testing.assert_array_equal(whole, np.concatenate(parts, axis=1))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("jitter", "way", "factor"),
    [
        # The last instant, which nobody measures, or the first and the last stamp.
        ("interval_jitter", NOMINAL, 1.0),
        ("stamp_jitter", MEASURED, np.sqrt(2.0)),
    ],
)
def test_what_a_jitter_moves_the_vehicle_by(jitter, way, factor):
    count = 4000
    moved = problem(
        {
            **NO_NOISE,
            **way,
            f"sensors.time.{jitter}": "1 ms",
            "reconstruction.integration": "trapezoidal",
        }
    )
    along = moved.simulate(7, 0, count).errors[0]
    expected = factor * 1e-3 * SPEED
    assert along.std() == pytest.approx(expected, rel=4.0 / np.sqrt(2 * count) + 0.005)
    other = MEASURED if way is NOMINAL else NOMINAL
    cured = problem(
        {
            **NO_NOISE,
            **other,
            f"sensors.time.{jitter}": "1 ms",
            "reconstruction.integration": "trapezoidal",
        }
    )
    assert cured.simulate(7, 0, 200).errors[0].std() < 0.01 * expected


@pytest.mark.slow
@pytest.mark.parametrize("way", [MEASURED, NOMINAL], ids=["measured", "nominal"])
def test_the_linear_model_holds_jitters(way):
    """Scatter and shares by source, against the scatter of realizations."""
    count = 4000
    for jitter, source in (
        ("interval_jitter", "sample-time jitter"),
        ("stamp_jitter", "time stamps"),
    ):
        own = {f"sensors.time.{jitter}": "1 ms", **way, "reconstruction.integration": "trapezoidal"}
        p = problem({**NO_NOISE, **own})
        predicted = np.sqrt(p.linear.variances.get(source, np.zeros(5)))[[0, 1, 3, 4]]
        found = p.simulate(3, 0, count).errors.std(axis=1)[[0, 1, 3, 4]]
        if jitter == "interval_jitter" and way is MEASURED:
            assert np.all(found < 4e-4)  # what is left is of second order
            assert np.all(predicted < found)
        else:
            np.testing.assert_allclose(found, predicted, rtol=4.0 / np.sqrt(2 * count), atol=1e-9)


@pytest.mark.slow
def test_lost_samples_shrink_nominal_time():
    """Each sample that is lost is missing at the end; measured intervals bridge it."""
    lost = {**NO_NOISE, "sensors.time.lost": "2 %", "reconstruction.integration": "trapezoidal"}
    count, p = 4000, problem({**lost, **NOMINAL})
    along = p.simulate(7, 0, count).errors[0]
    each, losses = SPEED * p.interval, 0.02 * (p.n_samples - 1)
    # The road is a little longer than its way along.
    assert along.mean() == pytest.approx(-each * losses, rel=4.0 / np.sqrt(losses * count) + 0.01)
    assert along.std() == pytest.approx(each * np.sqrt(0.98 * losses), rel=0.06)
    bridged = problem({**lost, **MEASURED}).simulate(7, 0, count).errors[0]
    assert np.abs(bridged).max() < 0.05 * each * losses


def test_a_latency_delays_what_the_drive_changes():
    """Late by L, a change of the velocity acts L late: minus L times the change, to first order."""
    slowing = {**NO_NOISE, "trajectory.deceleration": "2 m/s^2"}
    slowing["reconstruction.integration"] = "trapezoidal"
    late = problem({**slowing, "sensors.time.latency": "5 ms"})
    assert late.kernel is Planar  # the intervals are even
    change = late.truth.speed[-1] - late.truth.speed[0]
    moved = late.method_errors() - problem(slowing).method_errors()
    assert moved[0] == pytest.approx(-5e-3 * change, rel=0.02)
    assert abs(moved[1]) < 0.01 * moved[0]


@pytest.mark.slow
@pytest.mark.parametrize("rule", RULES)
def test_realizations_in_space_follow_their_linear_model(rule):
    p = spatial_problem(
        {
            **EVERYTHING,
            "sensors.time.interval_jitter": "0.5 ms",
            "sensors.time.stamp_jitter": "1 ms",
            "reconstruction.integration": rule,
            "initial.levelling.duration": "1 s",
        }
    )
    count = 4000
    errors = p.simulate(3, 0, count, controls=True)
    rows = [0, 1, 2, 4, 5, 6, 7]
    predicted = np.sqrt(p.linear.second_moment)[rows]
    found = errors.errors.std(axis=1)[rows]
    np.testing.assert_allclose(found, predicted, rtol=4.0 / np.sqrt(2 * count))
    assert np.sqrt(p.linear.variances["time stamps"][0]) == pytest.approx(0.028, rel=0.1)


@pytest.mark.slow
def test_the_history_ends_in_the_errors():
    for make in (problem, spatial_problem):
        p = make({**ALL_ERRORS, **EVERY})
        history, errors = p.history(7, 0, 20), p.simulate(7, 0, 20).errors
        np.testing.assert_allclose(history.errors[:, -1], errors, rtol=0, atol=1e-9)


# --- the velocity case, and rules and cases of one's own -----------------------------------


def velocity_problem(overrides, folder=Path()):
    file = SCENARIOS / "velocity" / "a1.yaml"
    return problem_of(Scenario.from_yaml(file, overrides=overrides).base, folder)


@pytest.mark.slow
def test_velocities_are_summed_over_recorded_intervals(tmp_path):
    """Eq. (23), (24) in plain numpy, with the corrected output of the undisturbed sensor."""
    own = recorded(tmp_path, 100, duration=3.0)
    stamps = own["sensors.time.stamps.file"]
    for way in (MEASURED, NOMINAL):
        given = {"sensor.time.stamps.file": stamps, "sensor.sampling": "none", **way}
        p = velocity_problem({**given, "tilt.order": "exact"})
        c = Scenario.from_yaml(SCENARIOS / "velocity" / "a1.yaml").base.calibration
        bias = np.array([c.bx.estimate, c.by.estimate, c.bz.estimate])
        lx = np.array([c.lxx.estimate, c.lxy.estimate, c.lxz.estimate])
        lz = np.array([c.lzx.estimate, c.lzy.estimate, c.lzz.estimate])
        rest = p.signals[0, :3] - bias
        tilt = np.arctan2(lx @ rest, lz @ rest)
        sensed = p.raw - bias
        forward = np.cos(tilt) * (sensed @ lx) - np.sin(tilt) * (sensed @ lz)
        steps = np.diff(p.schedule.instants.true) if way is MEASURED else np.full(len(p.raw), 0.01)
        count = p.steps[-1]
        velocity = 9.81213 * float(forward[:count] @ steps[:count])
        assert p.method_errors()[-3] == pytest.approx(velocity - p.truth[count], abs=1e-9)
    assert np.ptp(np.diff(p.schedule.instants.true)) > 0.004


@pytest.mark.slow
def test_a_velocity_bridges_lost_samples():
    """With all noise off a run scatters by what is lost: little where intervals are measured."""
    quiet = {
        "sensor.noise": dict.fromkeys("xyz", "0 g"),
        "sensor.time_error": "0 s",
        "sensor.sampling": "none",
        "sensor.time.lost": "5 %",
        "trajectory.top_speed": "0.4 m/s",
    }
    measured, nominal = (velocity_problem({**quiet, **way}) for way in (MEASURED, NOMINAL))
    scatter = [p.simulate(7, 0, 1000).errors[-1].mean() for p in (measured, nominal)]
    # Of the 40 samples with acceleration, half speeding up and half braking, a twentieth is lost,
    # 0.02 m/s each.
    assert scatter[1] == pytest.approx(0.02 * np.sqrt(40 * 0.05 * 0.95), rel=0.1)
    assert scatter[0] < 0.6 * scatter[1]


@pytest.mark.slow
def test_an_own_rule_gets_its_intervals(tmp_path):
    """The example as it stands, which knows nothing of intervals that vary."""
    run_own(EXAMPLES / "midpoint.py")
    own = recorded(tmp_path, 100)
    for extra in ({}, {"sensors.time.lost": "5 %"}):
        p = problem({**own, **extra, **NO_NOISE, "reconstruction.integration": "midpoint"})
        lost = uneven.arrivals(7, np.arange(8), p.n_samples)[1] < ndtri(p.schedule.times.lost)
        lost[-1] = False
        for r, errors in enumerate(p.simulate(7, 0, 8).errors.T):
            passed = uneven.passed(p.times, lost[:, r])
            place, _, heading = uneven.midpoint(per_second(p), passed, *believed(p))
            end = p.truth.along[-1] + 1j * p.truth.across[-1]
            assert errors[0] == pytest.approx((place - end).real, abs=1e-9)
            assert errors[1] == pytest.approx((place - end).imag, abs=1e-9)
            assert errors[3] == pytest.approx(heading - p.truth.heading[-1], abs=1e-10)


def test_an_own_case_gets_its_intervals():
    """The example of a case: one per cent more samples than stated; its kernel is the rule's."""
    run_own(EXAMPLES / "rail.py")
    plain = Scenario.from_yaml(EXAMPLES / "rail.yaml", overrides={"sweep": None})
    rate = plain.with_values({"sensors.time.rate_error": "1 %"})
    even, p = (problem_of(of.base, EXAMPLES) for of in (plain, rate))
    assert p.timed
    assert not even.timed
    assert p.times[-1] == pytest.approx(even.times[-1], abs=0.02)
    assert p.n_samples == pytest.approx(1.01 * even.n_samples, abs=1.0)


# --- refusals -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"sensors.time.interval_jitter": "6 ms"}, "half a sampling interval, 0.005 s"),
        ({"sensors.time.lost": "60 %"}, "must be at most 50 %"),
        (
            {"sensors.time.interval_jitter": "1 ms", "sensors.time_jitter": "1 ms"},
            "keep the second where intervals are to vary",
        ),
        (
            {"sensors.time.lost": "1 %", "sensors.sampling": "average"},
            "is lost with its sample",
        ),
        (
            {"sensors.time.stamps.file": "a.csv", "sensors.time.rate_error": "1 %"},
            "leave out `rate_error`",
        ),
    ],
)
def test_what_cannot_be_simulated_is_refused(overrides, words):
    with pytest.raises(InputError, match=words):
        scenario(overrides)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time [s]\n0\n0.01\n0.02\n", "the stamps end after 0.02 s, the drive after"),
        ("time [s]\n0\n0.01\n0.005\n0.02\n", r":4: the time runs backwards here, by 0.005 s"),
        ("time [ms]\n0\n0.01\n0.02\n", "correct the rate, or the unit of the column"),
        ("time\n0\n0.01\n0.02\n", '"time" has no unit; write for example "time in s"'),
        ("stars [s]\n0\n0.01\n0.02\n", "no column of time"),
    ],
)
def test_stamps_that_do_not_fit_are_refused(tmp_path, text, words):
    (tmp_path / "log.csv").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        problem({"sensors.time.stamps.file": "log.csv"}, tmp_path)


def test_two_samples_of_means_are_refused(tmp_path):
    own = recorded(tmp_path, 100)
    with pytest.raises(InputError, match="take means over equal intervals"):
        spatial_problem(
            {**own, "sensors.sampling": "average", "reconstruction.integration": "two_sample"}
        )


def test_even_instants_are_counted_under_late_stamps():
    """Exponential delays of arrival, and a gap: the instants are those of the sensor's clock."""
    random = np.random.default_rng(5)
    index = np.delete(np.arange(2000), [500, 501, 1200])
    arrived = 0.01 * index + random.exponential(0.001, len(index))
    true, rows = even_instants(arrived - arrived[0], "log")
    assert len(rows) == len(index)
    np.testing.assert_allclose(true, 0.01 * index, rtol=0, atol=2e-4)
