"""Several logs beside each other, and one log before and after a bad stretch."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from scipy.integrate import quad

import mcsim
from mcsim import InputError
from mcsim.characterisation.analysis import Settings, characterise
from mcsim.characterisation.health.bad_stretch import bad_stretch
from mcsim.characterisation.process import GaussMarkov
from mcsim.characterisation.stretches import (
    Change,
    adjusted,
    changes,
    least_shown,
    mean_difference,
)
from mcsim.cli.main import exit_code
from mcsim.logs import Channel, Log, Timing
from tests.reference.noise import static_noise

RATE, N = 50.0, 20_000
MIX = (1e-3, 3e-4, 1e-5)
QUICK = ["--intervals", "covariance", "--quiet"]


def noise(seed, n=N, mix=MIX):
    return static_noise(*mix, RATE, n, np.random.default_rng(seed))


def log_of(*samples, rate=RATE):
    channels = tuple(
        Channel("accelerometer", axis, values) for axis, values in zip("xyz", samples, strict=False)
    )
    return Log(Path("log.csv"), channels, Timing(rate, stamped=False))


def write(path, **columns):
    table = {"time [s]": np.arange(N) / RATE} | {f"{k} [m/s^2]": v for k, v in columns.items()}
    pd.DataFrame(table).to_csv(path, index=False)
    return path


@dataclass
class Fit:
    """A noise model as ``mean_difference`` takes it."""

    model_squares: np.ndarray
    process: GaussMarkov | None = None
    gauss_markov: object = field(init=False)

    def __post_init__(self):
        self.gauss_markov = self if self.process else None

    @property
    def model(self):
        return self.process


@pytest.mark.parametrize(
    ("squares", "density"),
    [
        ([0.0, 2.0, 0.0, 0.0, 0.0], lambda f: 2.0 * f**0),
        ([0.0, 0.0, 2.0, 0.0, 0.0], lambda f: 2.0 / (2.0 * np.pi * f)),
        ([0.0, 0.0, 0.0, 2.0, 0.0], lambda f: 2.0 / (2.0 * np.pi * f) ** 2),
    ],
)
def test_means_differ_as_the_spectrum_says(squares, density):
    """∫ S(f) |H(f)|² df, where H is what the difference of two means makes of a frequency."""
    first, gap, second = 3.0, 2.0, 5.0

    def response(f):
        turn = 2j * np.pi * f
        one = (1.0 - np.exp(-turn * first)) / (turn * first)
        two = np.exp(-turn * (first + gap)) * (1.0 - np.exp(-turn * second)) / (turn * second)
        return abs(two - one) ** 2

    expected = 2.0 * sum(
        quad(lambda f: density(f) * response(f), a, b, limit=500)[0]
        for a, b in zip((1e-6, 0.2, 1, 5, 20), (0.2, 1, 5, 20, 60), strict=True)
    )
    found = mean_difference(Fit(np.array(squares)), first, gap, second)
    assert found == pytest.approx(expected, rel=5e-3)


def test_means_of_a_gauss_markov_process_differ_by_its_double_sum():
    model, step = GaussMarkov(4.0, 1.5), 0.02
    places = np.concatenate([np.arange(0, 3, step), np.arange(5, 10, step)]) + step / 2
    weights = np.where(places < 4.0, -1.0 / 150.0, 1.0 / 250.0)
    covariance = 1.5**2 * np.exp(-np.abs(places[:, None] - places) / 4.0)
    found = mean_difference(Fit(np.zeros(5), model), 3.0, 2.0, 5.0)
    assert found == pytest.approx(weights @ covariance @ weights, rel=1e-3)


def halves(samples, gap=1000):
    half = (len(samples) - gap) // 2
    return halves_of(samples, half, half + gap)


def halves_of(samples, end, start, rate=RATE):
    parts = samples[:end], samples[start:]
    return [characterise(log_of(p, rate=rate), Settings(intervals="covariance")) for p in parts]


@pytest.mark.slow
def test_a_log_that_goes_on_as_before_is_not_called_changed():
    """15 logs, 3 quantities: at 5 % 2.3 are expected, at most 7 by chance (0.1 %).  The control
    is a t test of the samples, which calls every third drift a change."""
    p, control = [], []
    for seed in range(15):
        samples = noise(seed)
        p.append([c.p for c in changes(*halves(samples), 1000 / RATE)])
        control.append(stats.ttest_ind(samples[:9500], samples[10_500:]).pvalue)
    assert np.sum(np.array(p) < 0.05) <= 7
    assert np.mean(np.array(control) < 0.05) > 0.25


@pytest.mark.slow
def test_the_levels_uncertainty_of_white_noise_is_that_of_its_means():
    """12 logs of 130 s: σ √(1/n + 1/m), which slow terms that chance fits do not enter.  The
    control is what all fitted terms say, which is more than 1.3 times too large in 6 of 10."""
    truth = 0.02 * np.sqrt(1 / 6000 + 1 / 6500)
    found, control = [], []
    for seed in range(12):
        samples = 0.02 * np.random.default_rng(1000 + seed).standard_normal(13_000)
        one, two = halves_of(samples, 6000, 6500, 100.0)
        level = next(c for c in changes(one, two, 5.0) if c.quantity == "level")
        found.append(level.uncertainty / truth)
        fits = [part.channels[0].fit for part in (one, two)]
        variance = np.mean([mean_difference(fit, 60.0, 5.0, 65.0) for fit in fits])
        control.append(np.sqrt(variance) / truth)
    assert np.mean(np.abs(np.array(found) - 1.0) < 0.3) >= 0.75
    assert np.median(found) == pytest.approx(1.0, abs=0.03)
    assert np.mean(np.array(control) > 1.3) > 0.3


def test_uncertainties_are_in_the_unit_of_their_quantity():
    """Values ten times as large have uncertainties ten times as large, all three of them."""
    samples = noise(1)
    one, two = (changes(*halves(k * samples), 1000 / RATE) for k in (1.0, 10.0))
    for small, large in zip(one, two, strict=True):
        assert large.uncertainty == pytest.approx(10.0 * small.uncertainty, rel=1e-3)
        assert large.p == pytest.approx(small.p, rel=1e-2)
    assert [c.unit for c in one] == ["m/s^2", "m/s^2", "m/s^1.5"]
    deviation = next(c for c in one if c.quantity == "deviation")
    # Of white noise: σ √(1/2n + 1/2m); flicker and walk are too slow for a second to matter.
    assert deviation.uncertainty == pytest.approx(deviation.before / np.sqrt(9500), rel=0.15)
    least = least_shown(one)
    assert list(least) == ["m/s^2"]
    assert least["m/s^2"] == pytest.approx(2.935 * one[0].uncertainty, rel=1e-3)


def test_what_changes_is_found():
    samples = noise(1)
    samples[10_000:] *= 1.2
    samples[10_000:] += 0.02
    found = {c.quantity: c for c in changes(*halves(samples), 1000 / RATE)}
    assert all(p < 1e-6 for p in adjusted(list(found.values())))
    assert found["level"].after - found["level"].before == pytest.approx(0.02, abs=2e-3)
    assert found["deviation"].after / found["deviation"].before == pytest.approx(1.2, rel=0.02)
    assert found["N"].after / found["N"].before == pytest.approx(1.2, rel=0.03)


def test_holms_p_are_those_of_their_definition():
    found = [Change("accel_x", "N", "m/s^1.5", 1.0, 1.0, 0.1, p) for p in (0.01, 0.04, 0.03, 0.005)]
    assert adjusted(found) == pytest.approx([0.03, 0.06, 0.06, 0.02])


def stuck(x):
    x[8000:11_000] = x[8000]


def noisy(x):
    x[8000:11_000] *= 3.0


def clipped(x):
    x[8000:11_000] = np.minimum(x[8000:11_000] + 0.05, 0.05)


@pytest.mark.parametrize(
    ("spoil", "why"), [(stuck, "accel_y stuck"), (noisy, "accel_y noisy"), (clipped, "at a rail")]
)
def test_bad_stretches_are_found(spoil, why):
    x, y = noise(2), noise(3)
    assert bad_stretch(log_of(x, y)) is None
    spoil(y)
    found = bad_stretch(log_of(x, y))
    assert why in found.why
    assert "accel_x" not in found.why
    assert found.start == pytest.approx(160.0, abs=1.0)
    assert found.end == pytest.approx(220.0, abs=1.0)


def test_healthy_logs_have_none_even_if_rounded():
    for seed in range(10):
        x = noise(seed)
        assert bad_stretch(log_of(np.round(x / 8e-3) * 8e-3, x)) is None


@pytest.fixture(scope="module")
def spoilt(tmp_path_factory):
    y = noise(5)
    stuck(y)
    y[11_000:] += 0.02
    return write(tmp_path_factory.mktemp("logs") / "bad.csv", accel_x=noise(4), accel_y=y)


@pytest.mark.slow
@pytest.mark.parametrize("stretches", ["auto", "160:220", "0:150,230:400"])
def test_before_and_after_a_bad_stretch(spoilt, stretches, tmp_path, capsys):
    arguments = ["characterise", str(spoilt), "--compare", stretches, "--intervals", "covariance"]
    assert exit_code([*arguments, "--output", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "Changed (Holm's p of all tests below 0.01): level of accel_y." in out
    assert ("accel_y stuck from 160 to 220 s" in out) == (stretches == "auto")
    table = pd.read_csv(tmp_path / "comparison.csv")
    assert table[table["changed"]]["quantity"].tolist() == ["level"]
    assert table["unit"].tolist() == ["m/s^2", "m/s^2", "m/s^1.5"] * 2
    names = {"comparison.csv", "comparison.png", "comparison.svg", "provenance.json"}
    assert {p.name for p in tmp_path.iterdir()} == names


@pytest.mark.parametrize(
    ("stretches", "message"),
    [
        ("never", "write auto (the stretch is looked for), FROM:TO"),
        ("300:200", "two ascending times"),
        ("10:20", "from 0 to 10 s is less than 60 s"),
        ("0:200,100:400", "overlap"),
        ("0:1,2:3,4:5", "write auto"),
    ],
)
def test_stretches_that_are_none_are_explained(spoilt, stretches, message, tmp_path, capsys):
    arguments = ["characterise", str(spoilt), "--compare", stretches, *QUICK]
    assert exit_code([*arguments, "--output", str(tmp_path / "o")]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "o").exists()


@pytest.mark.slow
def test_where_nothing_shows_it_is_said_what_would_have(tmp_path):
    path = write(tmp_path / "good.csv", accel_x=noise(6, mix=(1e-3, 0.0, 0.0)))
    found = mcsim.compare_stretches(path, "190:210", intervals="covariance")
    u = found.table.query("quantity == 'level'")["u_of_change"].item()
    assert "No change shown" in found.words
    assert f"would have shown from {2.935 * u:.2g} m/s^2 on" in found.words


def test_a_healthy_log_has_no_bad_stretch_to_compare(tmp_path):
    path = write(tmp_path / "good.csv", accel_x=noise(6))
    with pytest.raises(InputError, match="no stretch is stuck, noisy or at a rail"):
        mcsim.compare_stretches(path)


@pytest.mark.slow
def test_several_logs_share_one_plot(tmp_path):
    paths = [write(tmp_path / f"{n}.csv", accel_x=k * noise(7)) for n, k in (("a", 1), ("b", 2))]
    out = tmp_path / "o"
    assert exit_code(["characterise", *map(str, paths), *QUICK, "--output", str(out)]) == 0
    allan = pd.read_csv(out / "allan.csv")
    one, two = (allan[allan["log"] == name]["adev"].to_numpy() for name in "ab")
    np.testing.assert_allclose(two, 2.0 * one, rtol=1e-6)
    own = pd.read_csv(out / "a" / "allan.csv")["adev"].to_numpy()
    np.testing.assert_allclose(own, one, rtol=1e-12)
    table = pd.read_csv(out / "noise.csv")
    assert table["N"].tolist() == pytest.approx([1e-3, 2e-3], rel=0.02)
    assert (out / "allan.png").exists()
    assert (out / "b" / "sensor.yaml").exists()


def test_logs_of_one_name_and_parameters_are_refused(tmp_path, capsys):
    (tmp_path / "x").mkdir()
    path = write(tmp_path / "x" / "a.csv", accel_x=noise(8))
    assert exit_code(["characterise", str(path), str(path), *QUICK]) == 2
    assert "another log is called x_a too" in capsys.readouterr().err
    sensor = tmp_path / "sensor.yaml"
    sensor.write_text("accelerometer: {velocity_random_walk: 0.1 m/s/√h}\n", encoding="utf-8")
    assert exit_code(["characterise", str(path), str(sensor), *QUICK]) == 2
    assert "holds parameters; several files must all be logs" in capsys.readouterr().err
    assert exit_code(["characterise", str(path), str(path), "--compare", "auto", *QUICK]) == 2
    assert "--compare: takes one log" in capsys.readouterr().err
