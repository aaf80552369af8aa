"""Arbitrary positions at rest, the rests of a log, and weighted six positions."""

import numpy as np
import pytest
from ruamel.yaml import YAML
from scipy.linalg import sqrtm

import mcsim
from mcsim import InputError
from mcsim.calibration import (
    RestPositions,
    SixPositions,
    calibrate,
    calibrate_by_norm,
    calibrate_weighted,
    simulate_rest_positions,
)
from mcsim.calibration.norm import NAMES, equations
from mcsim.calibration.norm_words import norm_words
from mcsim.calibration.rest_positions import find_rests, read_positions, rests
from mcsim.calibration.scatter import own_variances, sample_scatter
from mcsim.calibration.six_positions import TRUE
from mcsim.cli.main import exit_code
from tests.test_calibration import BIAS, CORRECTION, NOISE, SCENARIOS, coverage

#: The symmetric correction that has the same norms, by scipy's square root of a matrix.
SYMMETRIC = np.real(sqrtm(CORRECTION.T @ CORRECTION))
TRUTH = np.append(SYMMETRIC[np.triu_indices(3)], BIAS)


def simulated(seed, count=24, samples=100, between=0.0):
    generator = np.random.default_rng(seed)
    return simulate_rest_positions(CORRECTION, BIAS, NOISE, count, samples, between, generator)


def exact(seed, count=24):
    generator = np.random.default_rng(seed)
    return simulate_rest_positions(CORRECTION, BIAS, 0 * NOISE, count, 1, 0.0, generator)


def ellipsoid(means):
    """The quadric of least squares through the outputs, in closed form: L symmetric, and B.

    Its residuals are those of squares, so it weights positions another way than norms do.
    """
    x, y, z = means.T
    design = np.column_stack([x * x, 2 * x * y, 2 * x * z, y * y, 2 * y * z, z * z, x, y, z])
    q = np.linalg.lstsq(design, np.ones(len(means)), rcond=None)[0]
    form = np.array([[q[0], q[1], q[2]], [q[1], q[3], q[4]], [q[2], q[4], q[5]]])
    centre = -0.5 * np.linalg.solve(form, q[6:])
    return np.real(sqrtm(form / (1.0 + centre @ form @ centre))), centre


def test_without_errors_the_parameters_come_back_exactly():
    fit = calibrate_by_norm(exact(1))
    np.testing.assert_allclose(fit.correction, SYMMETRIC, atol=1e-12)
    np.testing.assert_allclose(fit.bias, BIAS, atol=1e-12)
    np.testing.assert_allclose(fit.matrix @ fit.correction, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(np.abs(fit.residuals).max(), 0.0, atol=1e-12)


def test_it_agrees_with_the_closed_form_of_an_ellipsoid():
    """Both have errors of the noise's order; they differ by a part of it."""
    test = simulated(2, count=200)
    fit, (correction, bias) = calibrate_by_norm(test), ellipsoid(test.means)
    u = np.sqrt(np.diag(fit.covariance))
    assert (np.abs(fit.correction - correction)[np.triu_indices(3)] < 2.0 * u[:6]).all()
    assert (np.abs(fit.bias - bias) < 2.0 * u[6:]).all()
    np.testing.assert_allclose(ellipsoid(exact(2).means)[0], SYMMETRIC, atol=1e-10)


def test_derivatives_are_those_of_differences():
    means, unknowns = simulated(3).means, TRUTH + 0.01
    _, jacobian = equations(means, unknowns)
    for k, step in enumerate(1e-6 * np.eye(9)):
        ahead, behind = equations(means, unknowns + step)[0], equations(means, unknowns - step)[0]
        np.testing.assert_allclose(jacobian[:, k], (ahead - behind) / 2e-6, atol=1e-9)


def test_any_rotation_of_the_sensor_gives_the_same():
    """The twelve parameters' other three: true directions turned by anything."""
    generator = np.random.default_rng(4)
    turn = np.linalg.qr(generator.standard_normal((3, 3)))[0]
    turned = simulate_rest_positions(
        turn @ CORRECTION, BIAS, 0 * NOISE, 20, 1, 0.0, np.random.default_rng(5)
    )
    fit = calibrate_by_norm(turned)
    np.testing.assert_allclose(fit.correction, SYMMETRIC, atol=1e-10)


def test_six_positions_agree_with_it_but_for_the_rotation():
    """The six, and as many between them, of one sensor: (LᵀL)^½ of the one is L of the other."""
    between = np.array([[1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1], [0, 1, 1], [0, 1, -1]])
    true = np.vstack([TRUE, between / np.sqrt(2.0), -between / np.sqrt(2.0)])
    generator = np.random.default_rng(6)
    means = true @ np.linalg.inv(CORRECTION).T + BIAS
    means += NOISE / 10.0 * generator.standard_normal(means.shape)
    six = calibrate(SixPositions(means[None, :6]))
    found = calibrate_by_norm(
        RestPositions(means, np.ones(18, int), None, tuple("abcdefghijklmnopqr"))
    )
    same = np.real(sqrtm(six.correction.T @ six.correction))
    np.testing.assert_allclose(found.correction, same, atol=4e-3 / np.sqrt(10.0))
    np.testing.assert_allclose(found.bias, six.bias, atol=4e-3 / np.sqrt(10.0))
    assert np.abs(found.correction - six.correction).max() > 4e-3  # the rotation


def held(tests):
    """Share (9,) of the tests whose 95 % intervals hold each unknown."""
    inside = []
    for test in tests:
        named = calibrate_by_norm(test).estimates()
        errors = [abs(named[name].value - true) for name, true in zip(NAMES, TRUTH, strict=True)]
        widths = [named[name].coverage_factor * named[name].uncertainty for name in NAMES]
        inside.append(np.array(errors) <= np.array(widths))
    return np.mean(inside, axis=0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("count", "samples", "between"), [(24, 1, 0.0), (24, 100, 0.0), (24, 100, 1e-3), (50, 1, 0.0)]
)
def test_intervals_hold_the_truth_as_often_as_they_say(count, samples, between):
    """95 %; 150 tests make a rate uncertain by 0.018, and the axes' noise differs by 1.6 where
    nothing tells it (more of it: benchmarks/calibration.txt)."""
    rates = held(simulated(seed, count, samples, between) for seed in range(150))
    assert rates.min() > 0.95 - 4 * 0.018
    assert rates.mean() > 0.93
    assert rates.mean() < 0.9995


def test_noise_alone_would_not_hold_it():
    """The control: intervals without what positions scatter beyond their samples."""
    inside = []
    for seed in range(60):
        fit = calibrate_by_norm(simulated(seed, 24, 100, 2e-3))
        share = np.sqrt(np.diag(fit.covariance)) * 1.96
        share *= np.sqrt(np.mean(fit.deviations**2 - fit.position**2) / np.mean(fit.deviations**2))
        found = np.append(fit.correction[np.triu_indices(3)], fit.bias)
        inside.append(np.abs(found - TRUTH) < share)
        assert "norms scatter by" in norm_words(fit)
    assert np.mean(inside) < 0.7


@pytest.mark.slow
def test_elements_of_the_matrix_have_the_uncertainty_of_their_scatter():
    fits = [calibrate_by_norm(simulated(seed)) for seed in range(100)]
    for name in ("mxx", "mxy", "mzz"):
        found = [fit.estimates()[name] for fit in fits]
        scatter = np.std([e.value for e in found])
        assert np.median([e.uncertainty for e in found]) == pytest.approx(scatter, rel=0.25)


def test_positions_that_cover_too_little_are_refused():
    with pytest.raises(InputError, match="9 positions at rest are too few: 10 are needed"):
        calibrate_by_norm(simulated(7, 9))
    with pytest.raises(InputError, match="cover too little"):
        calibrate_by_norm(RestPositions(np.tile(TRUE, (3, 1)), np.ones(18, int), None, ("",) * 18))
    generator = np.random.default_rng(8)
    cone = np.array([0.0, 0.0, 1.0]) + 0.25 * generator.standard_normal((30, 3))
    cone /= np.linalg.norm(cone, axis=1)[:, None]
    with pytest.raises(InputError, match=r"cover too little \(condition number .* turn each axis"):
        calibrate_by_norm(RestPositions(cone, np.ones(30, int), None, ("",) * 30))
    half = generator.standard_normal((30, 3)) * [1.0, 0.2, 1.0]
    half[:, 2] = np.abs(half[:, 2])
    half /= np.linalg.norm(half, axis=1)[:, None]
    noisy = half + 1e-3 * generator.standard_normal(half.shape)
    fit = calibrate_by_norm(RestPositions(noisy, np.ones(30, int), None, ("",) * 30))
    assert 15.0 < fit.condition < 300.0
    assert "tell little of" in norm_words(fit)


def test_a_position_that_moved_is_named():
    test = simulated(9, 40)
    test.means[17] *= 1.05
    assert "Far off: 18;" in norm_words(calibrate_by_norm(test))


def turned_log(generator, rate=100.0, count=16):
    """Outputs (n, 3) of a sensor that is turned to a position, and lies there for 4 s."""
    parts, before = [], np.array([0.0, 0.0, 1.0])
    for _ in range(count):
        after = generator.standard_normal(3)
        after /= np.linalg.norm(after)
        share = np.linspace(0.0, 1.0, round(1.5 * rate))[:, None]
        way = (1.0 - share) * before + share * after
        way /= np.linalg.norm(way, axis=1)[:, None]
        parts += [way + 0.1 * generator.standard_normal(way.shape), np.tile(after, (400, 1))]
        before = after
    true = np.vstack(parts)
    raw = true @ np.linalg.inv(CORRECTION).T + BIAS
    return raw + NOISE * generator.standard_normal(raw.shape)


def test_rests_are_found_where_the_sensor_lies():
    raw = turned_log(np.random.default_rng(10))
    found = rests(raw, 100.0, 2.0)
    assert len(found) == 16
    for k, (begin, end) in enumerate(found):
        lies = 550 * k + 150, 550 * (k + 1)
        assert lies[0] <= begin < end <= lies[1]
        assert end - begin >= 250
    assert rests(raw, 100.0, 5.0) == []


@pytest.mark.parametrize("unit", ["g", "m/s^2"])
def test_a_log_of_a_turned_sensor_calibrates_it(unit, tmp_path, capsys):
    raw = turned_log(np.random.default_rng(11)) * (1.0 if unit == "g" else 9.80665)
    path = tmp_path / "turned.csv"
    time = np.arange(len(raw)) / 100.0
    header = ",".join(["time [s]", *(f"accel_{axis} [{unit}]" for axis in "xyz")])
    np.savetxt(path, np.column_stack([time, raw]), delimiter=",", header=header, comments="")
    arguments = ["calibrate", str(path), "--positions", "rests", "--output", str(tmp_path / "o")]
    assert exit_code(arguments) == 0
    out, err = capsys.readouterr()
    assert "16 positions at rest" in out
    assert "16 rests of 2 s or more" in err
    block = (tmp_path / "o" / "turned-calibration" / "calibration.yaml").read_text()
    assert "L is symmetric" in block
    found = find_rests(path, 2.0)
    fit = calibrate_by_norm(found)
    u = np.sqrt(np.diag(fit.covariance))
    errors = np.append(fit.correction[np.triu_indices(3)], fit.bias) - TRUTH
    assert (np.abs(errors) < 4.0 * u).all()


def test_the_block_is_read_by_a_velocity_scenario():
    found = mcsim.calibrate(SCENARIOS / "velocity" / "a1.yaml", positions="arbitrary", samples=50)
    assert len(found.residuals) == 24
    yaml = YAML(typ="safe")
    tree = yaml.load((SCENARIOS / "velocity" / "a1.yaml").read_text(encoding="utf-8"))
    tree["calibration"] = yaml.load(found.scenario)["calibration"]
    read = mcsim.Scenario.from_dict(tree).base.calibration
    assert read.lxx.estimate == pytest.approx(found.fit.correction[0, 0], rel=1e-8)
    assert read.lzx.estimate == read.lxz.estimate


def write(path, rows, header="x,y,z"):
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def test_a_table_of_positions_has_rows_or_samples(tmp_path):
    means = simulated(12, 12).means
    rows = [",".join(f"{v:.9g}" for v in mean) for mean in means]
    alone = read_positions(write(tmp_path / "rows.csv", rows))
    np.testing.assert_allclose(alone.means, means, rtol=1e-8)
    assert alone.scatter is None
    several = [f"p{k},{row}" for k, row in enumerate(rows) for _ in range(3)]
    grouped = read_positions(write(tmp_path / "samples.csv", several, "position,x,y,z"))
    np.testing.assert_allclose(grouped.means, means, rtol=1e-8)
    assert list(grouped.counts) == [3] * 12
    assert grouped.names[:2] == ("p0", "p1")


@pytest.mark.parametrize(
    ("rows", "options", "message"),
    [
        (["0.1,0.2,9.7"], ["arbitrary"], "t.csv:2: 9.7 is no fraction of g"),
        (["0.1,0.1,0.2"] * 12, ["arbitrary"], "position 1 has the norm 0.245 g"),
        (["0,0,1"] * 9, ["arbitrary"], "t.csv: 9 positions at rest are too few"),
        (["0,0,1"] * 12, ["arbitrary", "--weighted"], "--weighted: belongs to six positions"),
        (["0,0,1"] * 12, ["rests"], "no time stamps; give the sampling rate"),
        (["0,0,1"] * 12, ["six"], "column position is missing"),
    ],
)
def test_bad_tables_are_explained(rows, options, message, tmp_path, capsys):
    header = "accel_x [g],accel_y [g],accel_z [g]" if options == ["rests"] else "x,y,z"
    path = write(tmp_path / "t.csv", rows, header)
    out = ["--output", str(tmp_path / "o"), "--quiet"]
    assert exit_code(["calibrate", str(path), "--positions", *options, *out]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "o").exists()


def unequal(seed, loud=(8.0, 1.0, 1.0, 1.0, 1.0, 4.0), alignment=0.0, samples=100):
    """A test one of whose positions was held badly."""
    generator = np.random.default_rng(seed)
    tilts = np.cross(TRUE, alignment * generator.standard_normal((6, 3)))
    outputs = (TRUE + tilts) @ np.linalg.inv(CORRECTION).T + BIAS
    rows = [
        mean + by * NOISE * generator.standard_normal((samples, 3))
        for mean, by in zip(outputs, loud, strict=True)
    ]
    means = np.array([[r.mean(axis=0) for r in rows]])
    scatter = sample_scatter(rows)
    own = own_variances(rows, scatter, means.shape)
    return SixPositions(means, scatter, np.full((1, 6), samples), own)


def test_equal_weights_are_none():
    test = unequal(1, loud=(1.0,) * 6)
    alike = SixPositions(test.means, test.scatter, test.counts, np.ones((1, 6, 3)))
    np.testing.assert_allclose(calibrate_weighted(alike).matrix, calibrate(test).matrix, atol=1e-14)


def test_weights_are_those_of_least_squares():
    """An independent solution: numpy's, of equations divided by their deviations."""
    test = unequal(2)
    fit = calibrate_weighted(test)
    assert fit.uncertainties.position.max() == 0.0
    for k in range(3):
        root = 1.0 / np.sqrt(test.own[0, :, k])
        design = np.column_stack([TRUE, np.ones(6)]) * root[:, None]
        expected = np.linalg.lstsq(design, test.means[0, :, k] * root, rcond=None)[0]
        np.testing.assert_allclose([*fit.matrix[k], fit.bias[k]], expected, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("alignment", [0.0, 1.75e-3])
def test_weights_lower_the_errors_and_the_intervals_hold(alignment, monkeypatch):
    tests = [unequal(seed, alignment=alignment) for seed in range(100)]
    errors = {
        solve: np.std([solve(t).bias for t in tests], axis=0)
        for solve in (calibrate, calibrate_weighted)
    }
    assert errors[calibrate_weighted].mean() < 0.95 * errors[calibrate].mean()
    assert errors[calibrate_weighted].min() < 0.8 * errors[calibrate].min()
    monkeypatch.setattr("tests.test_calibration.calibrate", calibrate_weighted)
    assert coverage(tests).min() > 0.95 - 4 * 0.022


def test_weights_that_nothing_tells_are_refused(tmp_path, capsys):
    names = ("+x", "-x", "+y", "-y", "+z", "-z")
    rows = [f"{n},{','.join(map(str, v))}" for n, v in zip(names, TRUE, strict=True)]
    path = write(tmp_path / "six.csv", rows, "position,x,y,z")
    assert exit_code(["calibrate", str(path), "--weighted", "--output", str(tmp_path / "o")]) == 2
    assert "each position needs 10 samples or more" in capsys.readouterr().err
