"""Sobol nets for what a realization draws once: normal, independent between nets, narrower."""

import math

import numpy as np
import pytest
from scipy import stats

import mcsim
from mcsim.engine import run_point
from mcsim.simulation.nets import net_normals
from mcsim.statistics import Collector, Reference, estimate
from tests.conftest import ALL_ERRORS, problem, scenario

OFFSETS = {**ALL_ERRORS, "trajectory.length": "20 m"}


def settings(**values):
    return scenario({f"monte_carlo.{k}": v for k, v in values.items()}).base.monte_carlo


def test_points_are_normal_and_independent_between_nets():
    z = net_normals(7, 0, 4096 * 8, 8, 12).astype(float)
    standard_error = 1.0 / math.sqrt(z.shape[1])
    assert np.abs(z.mean(axis=1)).max() < 5 * standard_error
    assert stats.kstest(z[3], "norm").pvalue > 1e-3
    # Realizations of a net depend on each other: the nets' means tell the sampling error.
    products = (z[:, None] * z[None]).reshape(12, 12, -1, 8).mean(axis=-1)
    error = products.std(axis=-1) / math.sqrt(products.shape[-1])
    assert (np.abs(products.mean(axis=-1) - np.eye(12)) < 5 * error).all()
    means = z.reshape(12, -1, 8).mean(axis=2)
    assert np.abs(np.mean(means[:, 1:] * means[:, :-1])) < 5 * means.var() / math.sqrt(means.size)
    # Within a net they repel each other: means of nets scatter less than those of samples.
    assert means.std() < 0.6 / math.sqrt(8)


def test_realizations_do_not_depend_on_how_they_are_drawn():
    whole = net_normals(5, 0, 256, 16, 12)
    parts = [net_normals(5, first, 64, 16, 12) for first in range(0, 256, 64)]
    np.testing.assert_array_equal(whole, np.concatenate(parts, axis=1))
    assert (whole != net_normals(6, 0, 256, 16, 12)).all(axis=1).any()
    p, mc = problem(ALL_ERRORS), settings(realizations=10_000, offsets="sobol")
    one, two = run_point(p, mc, 1, threads=1), run_point(p, mc, 1, threads=2)
    np.testing.assert_array_equal(one.estimates.low, two.estimates.low)


def test_nets_and_chance_agree_and_nets_are_narrower():
    rows = []
    for offsets in ("random", "sobol"):
        values = {"monte_carlo.offsets": offsets, "monte_carlo.estimator": "plain"}
        s = scenario({**OFFSETS, **values, "monte_carlo.realizations": 16_000})
        table = mcsim.run(s).table
        rows.append(table[table["statistic"] == "rms"])
    chance, nets = rows
    widths = [(r["ci_high"] - r["ci_low"]).to_numpy() for r in rows]
    assert (widths[1] < widths[0] / 3).all()
    assert (nets["value"].to_numpy() > chance["ci_low"].to_numpy()).all()
    assert (nets["value"].to_numpy() < chance["ci_high"].to_numpy()).all()


def hits(shrink: float) -> np.ndarray:
    """How often 95 % intervals of 200 small runs hold what a large run knows."""
    p = problem(OFFSETS)
    truth = run_point(p, settings(realizations=200_000), 99).estimates.value[:, :3]
    mc = settings(realizations=1024, offsets="sobol", estimator="plain", confidence="95 %")
    count = np.zeros_like(truth)
    for key in range(200):
        e = run_point(p, mc, key).estimates
        value, low, high = e.value[:, :3], e.low[:, :3], e.high[:, :3]
        count += (value - shrink * (value - low) <= truth) & (
            truth <= value + shrink * (high - value)
        )
    return count / 200


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say():
    """Binomial deviation of one rate is 0.015; fifteen are looked at, and are correlated."""
    rates = hits(1.0)
    assert rates.min() > 0.90
    assert 0.93 < rates.mean() < 0.975
    assert hits(0.5).mean() < 0.75  # half as wide must fail


def test_where_errors_jump_random_points_serve_and_it_is_said():
    """Wraps, or a range in reach: in a net such realizations come together or not at all."""
    said = {}
    for name, overrides in (
        ("wraps", {"initial.direction_error": "52 °"}),
        ("range", {"sensors.accelerometer.range": "3 m/s^2"}),
        ("smooth", {}),
    ):
        p = problem({**OFFSETS, **overrides})
        random, nets = (
            run_point(p, settings(realizations=600, offsets=o), 3) for o in ("random", "sobol")
        )
        said[name] = any("Sobol points serve errors that are smooth" in t for t in nets.limits)
        same = np.array_equal(random.estimates.value, nets.estimates.value)
        assert said[name] == same
    assert said == {"wraps": True, "range": True, "smooth": False}


def test_percentiles_of_nets_know_how_nets_scatter():
    """Nets whose realizations are all alike: as few independent ones as there are nets."""
    alike = np.repeat(np.random.default_rng(1).standard_normal((1, 64)), 16, axis=1)
    widths = []
    for nets in (False, True):
        c = Collector(alike.shape[1], Reference(np.zeros(1)), nets)
        c.add(0, alike, np.empty((1, 0)))
        e = estimate(c, 2.0, 200, 1)
        widths.append((e.high - e.low)[0, 3])
    assert widths[1] > 2.5 * widths[0]
