"""Repeated runs: order statistics of Table 2, the mean against the worst run, what averages out."""

import math

import numpy as np
import pandas as pd
import pytest
from scipy import integrate, stats

from mcsim.papers import repeated_runs, repetition, velocity_tables
from mcsim.papers.repetition import (
    AVERAGES_OUT,
    deviations,
    end_errors,
    reductions_of,
    reductions_of_normals,
    repeated,
    sensor_problem,
    share_with_interval,
    without_shared,
)

RUNS, GROUPS = 12, 4000


def largest_of_normals(sigma, runs=RUNS):
    """Expected largest |N(0, sigma)| of so many: the integral of 1 - (2 Phi - 1)^M."""
    return sigma * integrate.quad(lambda x: 1.0 - (2.0 * stats.norm.cdf(x) - 1.0) ** runs, 0, 12)[0]


# Order statistics


@pytest.mark.parametrize("name", ["a1", "a2"])
def test_the_largest_of_twelve_is_that_of_normals(name):
    """Each run's own errors alone: mean and quantiles of the largest follow in closed form."""
    p, key = sensor_problem(name, "time stamps err")
    p = without_shared(p)
    _, sigma = deviations(p)
    errors = end_errors(p, key, GROUPS) - float(p.method_errors()[0])
    assert errors.shape == (RUNS, GROUPS)
    largest = np.abs(errors).max(axis=0)
    within = 5.0 * largest.std() / math.sqrt(GROUPS)
    assert largest.mean() == pytest.approx(largest_of_normals(sigma), abs=within)
    assert abs(largest.mean() - largest_of_normals(sigma, 11)) > within  # the control
    for share in (0.025, 0.5, 0.975):
        # (2 Phi(x) - 1)^12 = p
        expected = sigma * stats.norm.ppf(0.5 * (1.0 + share ** (1.0 / RUNS)))
        below = np.mean(largest < expected)
        assert below == pytest.approx(share, abs=5.0 * math.sqrt(share * (1 - share) / GROUPS))


@pytest.mark.slow
def test_table_2_is_that_of_a_shared_and_twelve_own_normals(monkeypatch):
    """Largest error, |error of the mean| and s(v) with all sources, from two deviations alone."""
    monkeypatch.setattr(velocity_tables, "GROUPS", GROUPS)
    rows = {row.quantity: row for row in velocity_tables.rows_of_table_2("a1", "0.4 m/s")}
    p, _ = sensor_problem("a1", "time stamps err")
    shared, own = deviations(p)
    draw = np.random.default_rng(8)
    many = 200_000
    errors = own * draw.standard_normal((RUNS, many)) + shared * draw.standard_normal(many)
    errors += float(p.method_errors()[0])
    normal = {
        "largest |error|": np.abs(errors).max(axis=0),
        "|error of the mean|": np.abs(errors.mean(axis=0)),
        "s(v)": errors.std(axis=0, ddof=1),
    }
    for quantity, values in normal.items():
        row = rows[f"{quantity} of 12 runs, time stamps err"]
        within = 5.0 * values.std() / math.sqrt(GROUPS)
        assert row.expected == pytest.approx(values.mean(), abs=within)
        share = np.mean(values < row.printed)
        assert row.below == pytest.approx(
            100.0 * share, abs=500.0 * math.sqrt(share * (1.0 - share) / GROUPS)
        )
    # |N(mu, s)| has a mean in closed form (folded normal).
    mean, u = float(p.method_errors()[0]), math.hypot(shared, own / math.sqrt(RUNS))
    folded = stats.foldnorm(abs(mean) / u, scale=u)
    row = rows["|error of the mean| of 12 runs, time stamps err"]
    assert row.expected == pytest.approx(folded.mean(), abs=5.0 * folded.std() / math.sqrt(GROUPS))


def test_no_twelve_values_lie_further_out_than_the_bound():
    """Eleven equal values and one other reach the bound; random ones do not pass it."""
    one = np.append(np.zeros(RUNS - 1), 1.0)
    reach = (RUNS - 1) / math.sqrt(RUNS)
    assert one.max() - one.mean() == pytest.approx(reach * one.std(ddof=1))
    values = np.random.default_rng(1).standard_t(2, (RUNS, 20_000))
    out = np.abs(values - values.mean(axis=0)).max(axis=0)
    assert np.all(out <= reach * values.std(axis=0, ddof=1) * (1 + 1e-12))
    a1, a2 = (velocity_tables._TABLE_2[name] for name in ("a1", "a2"))
    assert a1.largest_possible == pytest.approx((0.01 + 0.006 * reach, 0.015 + 0.0065 * reach))
    assert a2.largest - 0.005 > a2.largest_possible[1]  # 0.055 > 0.045: never of one group
    assert a1.largest - 0.005 < a1.largest_possible[1]


# The mean against the worst run


def test_shares_have_the_exact_interval():
    for hits, count in ((0, 20), (3, 20), (20, 20), (1200, 4000)):
        exact = stats.binomtest(hits, count).proportion_ci(0.95, "exact")
        share, low, high = share_with_interval(hits, count)
        assert share == hits / count
        assert (low, high) == pytest.approx((exact.low, exact.high), abs=1e-9)


def test_reductions_follow_from_two_deviations():
    """The simulated groups reach 75 % as often as normal errors of their two deviations do."""
    for name in ("a1", "a2"):
        for r in repetition.reductions(name, GROUPS):
            shared = r.shared * np.random.default_rng(3).standard_normal(100_000)
            if r.sources == "all":
                p, _ = sensor_problem(name, r.time_errors)
                shared += float(p.method_errors()[0])
            own = r.own * np.random.default_rng(4).standard_normal((RUNS, 100_000))
            expected = np.mean(reductions_of(own + shared) > 0.75)
            share, low, high = r.share_above(0.75)
            assert low < share < high
            sampling = math.sqrt(expected * (1.0 - expected) / GROUPS)
            assert share == pytest.approx(expected, abs=5.0 * sampling)


def test_reductions_at_the_ends():
    """Nothing shared: |Z| < sqrt(12) max / 4 nearly; all shared: no reduction at all."""
    alone = reductions_of_normals(0.0, RUNS, 50_000, 1)
    again = np.random.default_rng(2).standard_normal((RUNS, 50_000))
    same = 1.0 - np.abs(again.mean(axis=0)) / np.abs(again).max(axis=0)
    assert stats.ks_2samp(alone, same).pvalue > 1e-3
    assert np.quantile(reductions_of_normals(1e6, RUNS, 1000, 1), 0.99) < 1e-3
    np.testing.assert_allclose(reductions_of(np.array([[3.0], [1.0], [-1.0]])), [2.0 / 3.0])


# What averages out


@pytest.mark.parametrize("name", ["a1", "a2"])
@pytest.mark.parametrize("time_errors", repetition.TIME_ERRORS)
def test_sources_average_out_or_stay(name, time_errors):
    """Own errors by 1 / sqrt(M), shared ones not at all; all together in quadrature."""
    runs = (1, 4, 12)
    found = {s.source: s for s in repeated(name, time_errors, runs, GROUPS)}
    every = list(found.values())
    whole = every.pop()
    for s in every:
        own = s.lasting == 0.0
        assert s.linear == pytest.approx(s.linear[0] / np.sqrt(runs if own else 1), rel=1e-12)
        if s.linear[0] > 1e-5:  # smaller ones are of second order
            assert s.simulated == pytest.approx(s.linear, rel=5.0 / math.sqrt(2.0 * GROUPS))
    assert whole.linear == pytest.approx(np.sqrt(sum(s.linear**2 for s in every)), rel=1e-12)
    assert whole.lasting < whole.linear[-1] < whole.linear[0]
    assert {s.source for s in every} == set(AVERAGES_OUT)
    assert found["noise while moving"].lasting == found["time base"].lasting == 0.0
    assert found["tilt change"].lasting > 0.02


def test_noise_and_time_base_by_hand():
    """GUM by hand for A1 at a tilt that is known: g u dt sqrt(N) of noise, |a| u(dt) sqrt(n)."""
    found = {s.source: s for s in repeated("a1", "intervals err", (1, 12), 200)}
    p, _ = sensor_problem("a1", "intervals err")
    g, theta = 9.81213, -0.1332
    x = np.array([0.98, 0.008, -0.019]) - theta * np.array([-0.004, 0.004, 1.008])
    noise = g * 0.01 * math.sqrt(150.0) * math.hypot(*(x * [3.8e-3, 3.0e-3, 4.9e-3]))
    assert found["noise while moving"].linear[0] == pytest.approx(noise, rel=1e-3)
    # 40 steps of 2 m/s^2, and the acceleration that the linear tilt leaves in between.
    left = float(p.method_errors()[0]) / 1.5
    time = 1.6e-3 * math.sqrt(20 * (2 + left) ** 2 + 20 * (2 - left) ** 2 + 110 * left**2)
    assert found["time base"].linear[0] == pytest.approx(time, rel=0.02)
    # Change of tilt: g u T.
    assert found["tilt change"].linear[0] == pytest.approx(g * 1.8e-3 * 1.5, rel=0.01)


def test_words_follow_from_the_numbers(monkeypatch):
    monkeypatch.setattr(repeated_runs, "GROUPS", 1000)
    text = repeated_runs.repeated_runs().text
    assert "noise while moving and time base average out as the paper says" in text
    assert "noise at rest does not" in text
    assert "calibration matrix, zero bias and tilt change stay as the paper says" in text
    assert "holds in part of the groups" in text
    monkeypatch.setattr(repeated_runs, "_ALIKE", 1e-9)
    assert "none average out" in repeated_runs.repeated_runs().text


@pytest.mark.slow
def test_the_figure_holds_what_the_table_holds(tmp_path, monkeypatch):
    monkeypatch.setattr(repeated_runs, "GROUPS", 400)
    monkeypatch.setattr(repeated_runs, "_NORMALS", 2000)
    (picture,) = repeated_runs.FIGURE.make(tmp_path)
    assert picture.read_bytes().startswith(b"\x89PNG")
    table = pd.read_csv(tmp_path / "table.csv")
    assert set(table["source"]) == {*AVERAGES_OUT, "all together"}
    tilt = table[(table["sensor"] == "A1") & (table["source"] == "tilt change")]
    assert list(tilt["runs"]) == [1, 2, 4, 12, 48]
    assert np.ptp(tilt["linear [m/s]"]) == 0.0
