"""What holds of every statistic, and of those that are added from outside."""

from __future__ import annotations

from pathlib import Path

import jsonschema
import numpy as np
import pytest
from scipy import stats

import mcsim
from mcsim import Scenario, run
from mcsim.cli.summary import summary
from mcsim.errors import InputError
from mcsim.figures.single import draw_single
from mcsim.figures.sweeps import draw_sweep
from mcsim.results import Results
from mcsim.scenario_file.schema import scenario_schema
from mcsim.statistics import (
    STATISTICS,
    Collector,
    Distribution,
    Evidence,
    Reference,
    Statistic,
    estimate,
    estimated,
    percentile,
)
from mcsim.statistics.history import history_statistics
from tests.conftest import BASE_YAML

#: The velocity case's, and two more that a user adds.
PERCENTILES = (0.025, 0.50, 0.95, 0.975)


def _median_deviation(errors):
    centre = np.median(errors, axis=-1, keepdims=True)
    return np.median(np.abs(errors - centre), axis=-1)


def _mean_magnitude(errors):
    return np.mean(np.abs(errors), axis=-1)


MAD = mcsim.Statistic("mad", "median absolute deviation", _median_deviation, never_negative=True)
MAGNITUDE = Statistic("mean_abs", "mean magnitude", _mean_magnitude, never_negative=True)
ALL = {**estimated(PERCENTILES), "p99": percentile(0.99), "mad": MAD, "mean_abs": MAGNITUDE}


@pytest.fixture
def added():
    """The median absolute deviation and the 99th percentile, as long as a test runs."""
    mcsim.add(MAD)
    mcsim.add(mcsim.percentile(0.99))
    yield
    STATISTICS.remove("mad")
    STATISTICS.remove("p99")


def collected(errors: np.ndarray, percentiles: tuple[float, ...] = (*PERCENTILES, 0.99)):
    """The realizations (e, r) as a collector takes them in."""
    reference = Reference(np.zeros(len(errors)), percentiles=percentiles)
    collector = Collector(errors.shape[1], reference)
    step = max(4096, collector.cell)
    for first in range(0, errors.shape[1], step):
        piece = np.ascontiguousarray(errors[:, first : first + step])
        collector.add(first, piece, np.empty((len(errors), 0)))
    return collector


SKEWED = np.random.default_rng(8).gamma(3.0, 1.0, (4, 900)) - 2.0


def test_every_statistic_has_words_of_its_own():
    words = [statistic.words for statistic in ALL.values()]
    assert len(set(words)) == len(words)
    assert all(words)
    assert list(ALL) == [statistic.name for statistic in ALL.values()]


@pytest.mark.parametrize(
    ("p", "name", "words"),
    [
        (0.025, "p2.5", "2.5th percentile"),
        (0.05, "p05", "5th percentile"),
        (0.5, "p50", "median"),
        (0.11, "p11", "11th percentile"),
        (0.22, "p22", "22nd percentile"),
        (0.91, "p91", "91st percentile"),
        (0.999, "p99.9", "99.9th percentile"),
    ],
)
def test_percentiles_are_called_by_their_number(p, name, words):
    assert (percentile(p).name, percentile(p).words) == (name, words)


@pytest.mark.parametrize("name", ALL)
def test_a_value_is_that_of_the_realizations_and_lies_in_its_interval(name):
    found = estimate(collected(SKEWED), 2.0, 300, 1, {name: ALL[name]}).of(name)
    np.testing.assert_allclose(found.value, ALL[name].value(SKEWED), rtol=1e-12)
    assert np.all(found.low < found.value)
    assert np.all(found.value < found.high)
    if ALL[name].never_negative:
        assert np.all(found.low >= 0.0)


@pytest.mark.parametrize("name", ALL)
def test_a_value_goes_with_its_unit(name):
    """Tables turn radian into degrees afterwards."""
    value = ALL[name].value
    np.testing.assert_allclose(value(-2.0 * -SKEWED), 2.0 * value(SKEWED), rtol=1e-12)


@pytest.mark.parametrize("name", ALL)
def test_errors_that_are_all_equal_have_their_value_and_no_width(name):
    equal = np.full((1, 40), -0.3)
    found = estimate(collected(equal), 3.0, 300, 1, {name: ALL[name]}).of(name)
    assert found.low == found.value == found.high
    assert found.value[0] == pytest.approx(float(ALL[name].value(equal)[0]), abs=1e-15)


@pytest.mark.parametrize("name", ALL)
def test_the_linear_value_is_that_of_realizations_of_its_distribution(name):
    """A normal error, and one of which the linear model knows the quantile function."""
    rng = np.random.default_rng(4)
    gamma = stats.gamma(2.0)
    drawn = np.stack([1.0 + 2.0 * rng.standard_normal(100_000), gamma.ppf(rng.random(100_000))])
    known = Distribution(
        np.array([1.0, gamma.mean()]), np.array([2.0, gamma.std()]), {1: gamma.ppf}
    )
    linear = ALL[name].by_linear_model(known)
    found = estimate(collected(drawn), 4.0, 300, 1, {name: ALL[name]}).of(name)
    # Equally probable errors stand for the distribution of those that have no closed form.
    slack = 2e-3 * found.value if ALL[name].linear is None else 0.0
    assert np.all(found.low - slack <= linear)
    assert np.all(linear <= found.high + slack)
    # The control: a tenth more would be noticed.
    assert not np.any((found.low - slack <= 1.1 * linear) & (1.1 * linear <= found.high + slack))


TRIALS = 400


def hits(statistic: Statistic, truth: float, draw, n: int, shrink: float = 1.0) -> int:
    """How often of ``TRIALS`` intervals of 2 sigma hold the truth."""
    found = 0
    for part in range(TRIALS // 100):
        evidence = Evidence(collected(draw((100, n))), np.arange(100), 2.0, 300, part)
        interval = statistic.interval(evidence)
        low = interval.value - shrink * (interval.value - interval.low)
        high = interval.value + shrink * (interval.high - interval.value)
        found += int(np.sum((low <= truth) & (truth <= high)))
    return found


NORMAL_MAD = float(stats.norm.ppf(0.75))
FOLDED = float(np.sqrt(2.0 / np.pi))


@pytest.mark.slow
@pytest.mark.parametrize("n", [100, 400])
@pytest.mark.parametrize(
    ("statistic", "truth", "shape"),
    [(MAD, NORMAL_MAD, "normal"), (MAGNITUDE, FOLDED, "normal"), (MAGNITUDE, 2.0, "gamma")],
)
def test_resampled_intervals_cover(statistic, truth, shape, n):
    """Binomial bounds at 1e-5; the bootstrap's own error is allowed two percent (measured: one)."""
    rng = np.random.default_rng(n)

    def draw(size):
        return rng.standard_normal(size) if shape == "normal" else rng.gamma(2.0, 1.0, size)

    level = 2.0 * stats.norm.cdf(2.0) - 1.0
    found = hits(statistic, truth, draw, n)
    assert found >= stats.binom.ppf(1e-5, TRIALS, level - 0.02), found / TRIALS
    assert found <= stats.binom.ppf(1.0 - 1e-5, TRIALS, level + 0.015), found / TRIALS


def test_coverage_control_must_fail():
    rng = np.random.default_rng(3)
    found = hits(MAGNITUDE, FOLDED, rng.standard_normal, 100, shrink=0.7)
    level = 2.0 * stats.norm.cdf(2.0) - 1.0
    assert found < stats.binom.ppf(1e-5, TRIALS, level - 0.02)


@pytest.mark.slow
def test_many_realizations_are_resampled_in_cells_and_give_the_width_of_single_ones():
    """From 2,048 to 32,768 realizations widths fall by four."""
    rng = np.random.default_rng(6)
    few, many = (
        MAGNITUDE.interval(
            Evidence(collected(rng.standard_normal((12, n))), np.arange(12), 3.0, 600, 1)
        )
        for n in (2048, 16 * 2048)
    )
    ratio = np.mean(few.high - few.low) / np.mean(many.high - many.low)
    assert ratio == pytest.approx(4.0, rel=0.08)


def planar(text: str = BASE_YAML, **settings: object) -> Results:
    return run(Scenario.from_yaml(text, overrides=settings))


VELOCITY = Path(__file__).parent.parent / "scenarios" / "velocity" / "a1.yaml"
SINGLE = BASE_YAML.split("sweep:")[0]


def rows(results: Results, statistic: str):
    table = results.table
    return table[table["statistic"] == statistic].set_index("error")


@pytest.mark.usefixtures("added")
def test_statistics_from_outside_stand_last_in_the_table_with_their_intervals():
    results = planar(SINGLE)
    names = list(dict.fromkeys(results.table["statistic"]))
    assert names == ["mean", "std", "rms", "p50", "p95", "mad", "p99", "method"]
    for name in ("mad", "p99"):
        found = rows(results, name)
        assert (found["ci_low"] < found["value"]).all()
        assert (found["value"] < found["ci_high"]).all()
    ratio = rows(results, "mad")["value"] / rows(results, "std")["value"]
    assert ratio["heading"] == pytest.approx(NORMAL_MAD, rel=0.2)


@pytest.mark.usefixtures("added")
def test_a_linear_answer_has_them_too_and_monte_carlo_does_not_contradict_it():
    results = planar(SINGLE, **{"monte_carlo.estimator": "linear"})
    assert not any("contradicts" in remark and "mad" in remark for remark in results.remarks)
    ratio = rows(results, "mad")["value"] / rows(results, "std")["value"]
    assert ratio["heading"] == pytest.approx(NORMAL_MAD, rel=2e-3)


@pytest.mark.usefixtures("added")
def test_every_history_ends_in_its_table():
    results = planar(SINGLE, **{"outputs.history": True})
    history = results.history
    assert list(dict.fromkeys(history["statistic"])) == list(history_statistics())
    end = history[history["time [s]"] == history["time [s]"].max()]
    both = end.merge(results.table, on=["error", "statistic"])
    assert {"mean", "std", "rms", "p50", "p95", "mad", "p99"} == set(both["statistic"])
    np.testing.assert_array_equal(both["value_x"], both["value_y"])
    assert (history[history["statistic"] == "mad"]["value"] >= 0.0).all()


@pytest.mark.usefixtures("added")
def test_figures_and_summaries_show_them():
    swept = planar(BASE_YAML + "figure: {statistic: mad}\n")
    labels = [axes.get_ylabel() for axes in draw_sweep(swept).axes]
    assert any("along-road error, median absolute deviation [m]" in label for label in labels)
    single = planar(SINGLE)
    names = draw_single(single).legends[0].get_texts()
    assert "median absolute deviation" in [text.get_text() for text in names]
    assert " mad " in summary(single).splitlines()[0]


def test_what_was_taken_away_is_in_no_table():
    assert not {"mad", "p99"} & set(planar(SINGLE).table["statistic"])


@pytest.mark.parametrize("name", ["p97.5", "mad", "method", "p5O"])
def test_a_figure_shows_a_statistic_that_the_case_estimates(name, scenario_file):
    text = BASE_YAML + f"figure:\n  statistic: {name}\n"
    with pytest.raises(InputError) as told:
        Scenario.from_yaml(scenario_file(text))
    assert (
        f"case.yaml:14: figure.statistic: the case planar has no statistic `{name}` "
        "(it has mean, std, rms, p50, p95)"
    ) in str(told.value)


def test_the_velocity_case_draws_its_coverage_interval():
    scenario = Scenario.from_yaml(VELOCITY, {"figure.statistic": "p97.5"})
    assert scenario.base.figure.statistic in type(scenario.base).statistics()
    jsonschema.Draft7Validator(scenario_schema()).validate(scenario.document.tree)


@pytest.mark.parametrize("name", ["method", "p99", "mean"])
def test_names_that_tables_use_otherwise_are_refused(name):
    with pytest.raises(InputError):
        STATISTICS.add(Statistic(name, "largest", lambda errors: errors.max(axis=-1)))
    assert name == "mean" or name not in STATISTICS


@pytest.mark.parametrize("p", [0.0, 1.0, 95.0, -0.1])
def test_a_percentile_is_a_share(p):
    with pytest.raises(InputError, match="between 0 and 1"):
        percentile(p)
