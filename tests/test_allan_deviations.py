"""Modified, Hadamard and total deviation, and their intervals."""

import math
import warnings

import allantools
import numpy as np
import pytest

import mcsim
from mcsim.characterisation.allan import averaging_factors
from mcsim.characterisation.deviations import (
    DEVIATIONS,
    WELCH,
    deviation_curve,
    interval_of,
    local_exponents,
)
from mcsim.characterisation.freedom import degrees_of_freedom, freedom_of_total
from mcsim.errors import InputError
from tests.reference.noise import static_noise

RATE = 100.0
THEIRS = {
    "adev": allantools.adev,
    "oadev": allantools.oadev,
    "mdev": allantools.mdev,
    "hdev": allantools.ohdev,
    "totdev": allantools.totdev,
}


@pytest.fixture(scope="module")
def samples():
    return 9.81 + static_noise(0.01, 0.003, 0.001, RATE, 20_000, np.random.default_rng(1))


@pytest.mark.slow
@pytest.mark.parametrize("kind", DEVIATIONS)
def test_deviations_are_those_of_allantools(kind, samples):
    curve = deviation_curve(samples, RATE, kind, averaging_factors(20_000, RATE))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the few clusters at the end
        tau, theirs, _, _ = THEIRS[kind](samples, rate=RATE, data_type="freq", taus=curve.tau)
    np.testing.assert_allclose(tau, curve.tau, rtol=1e-12)
    np.testing.assert_allclose(curve.deviation, theirs, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [k for k in DEVIATIONS if k != "totdev"])
@pytest.mark.parametrize("alpha", [2, 0, -1, -2])
def test_degrees_of_freedom_are_greenhalls(kind, alpha):
    of = DEVIATIONS[kind]
    for m, n in ((1, 2001), (10, 2001), (400, 2001), (100, 100_001), (20_000, 100_001)):
        try:
            theirs = allantools.edf_greenhall(
                alpha, of.order, m, n, overlapping=of.overlapping, modified=of.modified
            )
        except NotImplementedError:
            continue  # quantisation over half of the log
        ours = degrees_of_freedom(
            alpha, of.order, m, n, modified=of.modified, overlapping=of.overlapping
        )
        assert ours == pytest.approx(max(theirs, 1.0), rel=0.02)


def test_degrees_of_freedom_of_the_total_deviation():
    for alpha in (0, -1, -2):
        theirs = allantools.edf_totdev(1000, 50, alpha)
        assert freedom_of_total(alpha, 20.0) == pytest.approx(theirs, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("kind", DEVIATIONS)
def test_intervals_cover(kind):
    """White noise, 300 logs of 2000 samples; the exponent is taken from each log's own curve."""
    rng = np.random.default_rng(5)
    factors = np.array([1, 3, 10, 30, 100, 200])
    truth = 1.0 / np.sqrt(factors)
    if kind == "mdev":
        # White noise: the modified variance is (1 + 1/m²) / 2 of the Allan variance.
        truth = truth * np.sqrt((1.0 + 1.0 / factors**2) / 2.0)
    hits, narrow = np.zeros(len(factors)), np.zeros(len(factors))
    for _ in range(300):
        curve = deviation_curve(rng.standard_normal(2000), 1.0, kind, factors)
        low, high = interval_of(curve, 2000, 0.9)
        hits += (low < truth) & (truth < high)
        low, high = interval_of(curve, 2000, 0.6)
        narrow += (low < truth) & (truth < high)
    # Noise that is taken for another kind costs some coverage at long clusters.
    assert np.all(hits / 300 > 0.9 - 0.06 - 3.0 * math.sqrt(0.09 / 300))
    assert np.all(narrow / 300 < 0.8)


def test_slopes_tell_the_noise():
    rng = np.random.default_rng(6)
    n = 100_000
    factors = averaging_factors(n, 1.0)[2:25]
    noises = {
        0: rng.standard_normal(n),
        -2: np.cumsum(rng.standard_normal(n)),
        2: np.diff(rng.standard_normal(n + 1)),
    }
    for kind in ("oadev", "mdev", "hdev"):
        for alpha, noise in noises.items():
            found = local_exponents(deviation_curve(noise, 1.0, kind, factors))
            assert np.median(found) == alpha, (kind, alpha)


def test_a_ramp_does_not_show_in_the_hadamard_deviation():
    rng = np.random.default_rng(7)
    noise = rng.standard_normal(20_000)
    drifting = noise + 1e-3 * np.arange(20_000)
    factors = np.array([10, 100, 1000])
    hadamard = [deviation_curve(s, 1.0, "hdev", factors).deviation for s in (noise, drifting)]
    np.testing.assert_allclose(hadamard[1], hadamard[0], rtol=1e-6)
    allan = [deviation_curve(s, 1.0, "oadev", factors).deviation for s in (noise, drifting)]
    assert allan[1][2] > 10.0 * allan[0][2]


def test_welchs_density_gives_the_allan_deviation():
    """Within the scatter of both where clusters are short, 10 % where they are a fifth of a
    segment."""
    rng = np.random.default_rng(8)
    samples = static_noise(0.01, 0.0, 0.0003, RATE, 200_000, rng)
    factors = averaging_factors(200_000, RATE)
    welch = deviation_curve(samples, RATE, WELCH, factors)
    allan = deviation_curve(samples, RATE, "oadev", welch.factors)
    ratio = welch.deviation / allan.deviation
    assert 10 < len(ratio) < len(factors)
    np.testing.assert_allclose(ratio[:15], 1.0, atol=0.02)
    np.testing.assert_allclose(ratio, 1.0, atol=0.1)


@pytest.fixture
def log(tmp_path, samples):
    time = np.arange(len(samples)) / RATE
    file = tmp_path / "static.csv"
    columns = np.column_stack([time, samples, 0.5 * samples])
    header = "time [s],accel_x [m/s^2],gyro_z [deg/s]"
    np.savetxt(file, columns, delimiter=",", header=header, comments="", fmt="%.12g")
    return file


def test_deviations_of_a_log(log, tmp_path, samples):
    found = mcsim.allan.deviations(log, ("oadev", "mdev", "welch"), confidence="95 %")
    assert [c.channel.name for c in found.channels] == ["accel_x", "gyro_z"]
    table = found.table.query("channel == 'accel_x' and kind == 'mdev'")
    expected = deviation_curve(samples, RATE, "mdev", averaging_factors(20_000, RATE))
    np.testing.assert_allclose(table["deviation"], expected.deviation, rtol=1e-6)
    assert (table["ci_low"] < table["deviation"]).all()
    assert (table["ci_high"] > table["deviation"]).all()
    files = found.write(tmp_path / "out")
    assert {f.name for f in files} >= {"deviations.csv", "deviations.png", "provenance.json"}
    assert "gyro_z [°/s]" in found.text
    assert "95 %" in found.text


def test_what_is_no_deviation_is_refused(log):
    with pytest.raises(InputError, match="ohdev"):
        mcsim.allan.deviations(log, ("ohdev",))
    with pytest.raises(InputError, match="name a deviation"):
        mcsim.allan.deviations(log, ())
    with pytest.raises(InputError, match="at least 16"):
        deviation_curve(np.ones(10), 1.0, "mdev", np.array([1]))
