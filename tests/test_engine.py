"""Realizations of one point: counts, precision, keys, threads."""

import numpy as np
import pytest

from mcsim.engine import point_key, random_key, run_point
from tests.conftest import ALL_ERRORS, NO_NOISE, problem, scenario


def settings(**values):
    values = {"estimator": "plain", **values}
    return scenario({f"monte_carlo.{k}": v for k, v in values.items()}).base.monte_carlo


def same(a, b) -> bool:
    return all(
        np.array_equal(getattr(a.estimates, n), getattr(b.estimates, n), equal_nan=True)
        for n in ("value", "low", "high")
    )


def test_results_do_not_depend_on_threads():
    mc = settings(realizations=10_001)
    p = problem(ALL_ERRORS)
    results = [run_point(p, mc, 5, threads) for threads in (1, 2, 3)]
    assert same(results[0], results[1])
    assert same(results[0], results[2])


def test_another_key_gives_other_results():
    mc = settings(realizations=500)
    assert not same(run_point(problem(), mc, 5), run_point(problem(), mc, 6))


def test_precision_goes_on_until_the_intervals_are_narrow():
    mc = settings(realizations=None, precision="2 %")
    result = run_point(problem(), mc, 5)
    e = result.estimates
    width = (e.high[:, 2] - e.low[:, 2]) / (2 * e.value[:, 2])
    assert width.max() <= 0.02
    assert 1000 < result.realizations < 100_000
    # More is not spent than needed: half the count would not have done.
    fewer = run_point(problem(), settings(realizations=result.realizations // 3), 5).estimates
    assert ((fewer.high[:, 2] - fewer.low[:, 2]) / (2 * fewer.value[:, 2])).max() > 0.02


def test_precision_stops_at_the_stated_maximum_and_says_so():
    mc = settings(realizations=None, precision="0.1 %", max_realizations=3000)
    result = run_point(problem(), mc, 5)
    assert result.realizations == 3000
    assert "precision not reached with 3000" in result.notes["heading"]


def test_precision_of_errors_without_scatter_is_reached_at_once():
    mc = settings(realizations=None, precision="1 %")
    result = run_point(problem(NO_NOISE), mc, 5)
    assert result.realizations == 1000
    assert "nothing disturbs" in result.notes["along"]


def test_progress_counts_every_realization():
    counted = []
    run_point(problem(), settings(realizations=9000), 5, 2, counted.append)
    assert sum(counted) == 9000


def test_keys_depend_on_seed_and_coordinates_alone():
    mc = settings(seed=4)
    assert point_key(mc, ("a=1", "b=2")) == point_key(mc, ("b=2", "a=1"))
    assert point_key(mc, ("a=1",)) != point_key(mc, ("a=2",))
    assert point_key(mc, ("a=1",)) != point_key(settings(seed=5), ("a=1",))
    common = settings(common_random_numbers=True)
    assert point_key(common, ("a=1",)) == point_key(common, ("a=2",))


def test_keys_are_the_same_on_every_machine():
    """First eight bytes of BLAKE2b-64, little-endian; `b2sum -l 64` gives the same."""
    assert random_key(1, "realizations") == 0x58CF78D933475E89
    assert random_key(1, "ab") != random_key(1, "a", "b")


def test_standing_vehicle_has_no_course_and_says_why():
    p = problem({"trajectory.speed": "10 m/s", "trajectory.deceleration": "2 m/s^2"})
    result = run_point(p, settings(realizations=200), 5)
    assert np.isnan(result.estimates.value[4]).all()
    assert np.isnan(result.method[4])
    assert np.isfinite(result.estimates.value[:4]).all()
    assert "comes to rest" in result.notes["course"]


@pytest.mark.parametrize("deceleration", ["2 m/s^2", "2.5 m/s^2"])
def test_stop_exactly_on_a_sample(deceleration):
    """10 m/s at 2 or 2.5 m/s^2 stop after 5 or 4 s: the last sample is the stop itself."""
    p = problem({"trajectory.speed": "10 m/s", "trajectory.deceleration": deceleration})
    assert p.truth.speed[-1] < 1e-9
    assert p.n_samples * p.interval == pytest.approx(0.1 + 10 / float(deceleration.split()[0]))
    assert np.isfinite(p.simulate(1, 0, 50).errors[:4]).all()


def test_history_of_a_standing_vehicle_ends_without_course():
    p = problem({"trajectory.speed": "10 m/s", "trajectory.deceleration": "2 m/s^2"})
    errors = p.history(1, 0, 5).errors
    assert np.isnan(errors[4, -1]).all()
    assert np.isfinite(errors[4, :-1]).all()


HARD = {"sensors.gyroscope.miscalibration": "3 °/s"}


def relative_widths(overrides, estimator):
    p = problem(overrides)
    e = run_point(p, settings(realizations=1000, estimator=estimator), 5).estimates
    return (e.high - e.low)[:, 2] / e.value[:, 2]


def test_control_variates_narrow_the_rms_intervals():
    """500 times at base parameters, 100 times with all errors, never wider in the hard case."""
    rows = [0, 1, 2, 4]  # the heading is exactly linear: nothing is left of its interval
    for overrides, factor in (({}, 500), (ALL_ERRORS, 100), (HARD, 0.97)):
        plain = relative_widths(overrides, "plain")
        controlled = relative_widths(overrides, "control_variate")
        assert np.all(plain[rows] > factor * controlled[rows]), (plain / controlled)[rows]
        assert controlled[3] < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("overrides", [{}, ALL_ERRORS, HARD], ids=["base", "all", "hard"])
def test_coverage_of_the_controlled_intervals(overrides):
    """Against a reference of 2 million controlled realizations; binomial bound at 1e-5.

    What the linear model leaves is a product of normals, with heavy tails: at 1000
    realizations nominal 95.45 % intervals may lose up to 2.5 %.
    """
    from scipy import stats

    p = problem(overrides)
    truth = run_point(p, settings(realizations=1_000_000, estimator="control_variate"), 1, 2)
    trials = 300
    mc = settings(realizations=1000, estimator="control_variate", confidence="2 sigma")
    hits = np.zeros((5, 3))
    for key in range(trials):
        e = run_point(p, mc, 1000 + key).estimates
        margin = 1e-12 * np.abs(e.value[:, :3])
        exact = truth.estimates.value[:, :3]
        hits += (e.low[:, :3] - margin <= exact) & (exact <= e.high[:, :3] + margin)
    least = stats.binom.ppf(1e-5, trials, 0.9545 - 0.025)
    assert np.all(hits >= least), hits / trials


def test_estimators_agree():
    """On the same realizations, within the plain estimator's own interval."""
    p = problem(ALL_ERRORS)
    plain = run_point(p, settings(realizations=20_000), 5).estimates
    controlled = run_point(
        p, settings(realizations=20_000, estimator="control_variate"), 5
    ).estimates
    assert np.all(plain.low[:, :3] <= controlled.value[:, :3])
    assert np.all(controlled.value[:, :3] <= plain.high[:, :3])


def test_wrapped_headings_are_not_mistaken_for_linear_ones():
    """With turns of whole circles the linear model knows nothing, and must not be followed."""
    overrides = {"initial.direction_error": "200 °"}
    p = problem(overrides)
    e = run_point(p, settings(realizations=20_000, estimator="control_variate"), 5).estimates
    assert np.degrees(e.value[3, 2]) < 180.0
    plain = run_point(p, settings(realizations=20_000), 5).estimates
    assert plain.low[3, 2] <= e.value[3, 2] <= plain.high[3, 2]


def test_few_realizations_use_the_plain_estimator():
    mine = [
        run_point(problem(), settings(realizations=50, estimator=name), 5)
        for name in ("plain", "control_variate")
    ]
    assert same(*mine)


def test_thousands_do_what_takes_millions():
    """precision 0.1 % with all errors: the plain estimator would need millions."""
    mc = settings(realizations=None, precision="0.1 %", estimator="control_variate")
    result = run_point(problem(ALL_ERRORS), mc, 5)
    assert result.realizations <= 4000
