"""Six-position and shaker tests: true parameters come back, wrong input is explained."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.special import stdtrit
from scipy.stats import linregress

from mcsim import InputError, Scenario
from mcsim.calibration import (
    SixPositions,
    calibrate,
    linearity,
    read_six_positions,
    simulate_shaker,
    simulate_six_positions,
)
from mcsim.calibration.scatter import sample_scatter
from mcsim.calibration.shaker import cubic_of
from mcsim.calibration.six_positions import POSITIONS, TRUE
from mcsim.calibration.words import calibration_words
from mcsim.cli.main import exit_code

CORRECTION = np.array([[0.98, 0.008, -0.019], [0.002, 1.02, 0.01], [-0.004, 0.004, 1.008]])
BIAS = np.array([0.047, -0.018, -0.146])
SCENARIOS = Path(__file__).parent.parent / "scenarios"
NOISE = np.array([3.8e-3, 3.0e-3, 4.9e-3])


def simulated(seed, samples=100, repetitions=2, alignment=0.0):
    generator = np.random.default_rng(seed)
    return simulate_six_positions(
        CORRECTION, BIAS, NOISE, samples, repetitions, alignment, generator
    )


def test_without_errors_the_parameters_come_back_exactly():
    exact = simulate_six_positions(CORRECTION, BIAS, 0 * NOISE, 1, 1, 0.0, np.random.default_rng(0))
    fit = calibrate(exact)
    np.testing.assert_allclose(fit.correction, CORRECTION, atol=1e-14)
    np.testing.assert_allclose(fit.bias, BIAS, atol=1e-14)
    np.testing.assert_allclose(TRUE @ fit.matrix.T + fit.bias, exact.means[0], atol=1e-14)


def coverage(tests, correction=CORRECTION, bias=BIAS):
    """Share (12,) of the tests whose 95 % intervals hold each element of L and B."""
    truth = np.append(correction, bias)
    inside = []
    for test in tests:
        named = calibrate(test).estimates()
        found = [e for name, e in named.items() if name[0] in "lb"]
        inside.append(
            [
                abs(e.value - true) <= e.coverage_factor * e.uncertainty
                for e, true in zip(found, truth, strict=True)
            ]
        )
    return np.mean(inside, axis=0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("samples", "repetitions", "alignment"),
    [(100, 1, 0.0), (100, 1, 2e-3), (1, 1, 0.0), (100, 2, 0.0), (100, 2, 2e-3), (1, 5, 2e-3)],
)
def test_intervals_hold_the_truth_as_often_as_they_say(samples, repetitions, alignment):
    """95 % by Student's t; 300 tests make a rate uncertain by 0.0126 (all of them: see
    benchmarks/calibration.txt)."""
    tests = (simulated(seed, samples, repetitions, alignment) for seed in range(300))
    rates = coverage(tests)
    assert rates.min() > 0.95 - 4 * 0.0126
    assert rates.mean() < 0.9995  # intervals that hold everything would say nothing


def test_residuals_alone_would_not_hold_it():
    """The control: u of one test's residuals as a normal deviation covers 95 % far too rarely."""
    held = []
    for seed in range(300):
        test = simulated(seed, repetitions=1)
        fit = calibrate(SixPositions(test.means))
        held.append(np.abs(fit.bias - BIAS) < 1.96 * fit.u_bias)
    assert np.mean(held) < 0.88


def test_samples_bound_the_uncertainty_from_below():
    """u(B) is at least that of the samples' own scatter, s / sqrt(6 n), however the residuals
    happen to agree."""
    n = 200
    floor = NOISE / np.sqrt(6 * n)
    alone = [calibrate(SixPositions(simulated(s, n, 1).means)).u_bias for s in range(100)]
    assert (np.array(alone) < 0.2 * floor).any()
    for seed in range(100):
        fit = calibrate(simulated(seed, n, 1))
        assert (fit.u_bias > 0.9 * floor).all()


def test_effective_degrees_of_freedom_are_those_of_their_limits():
    """Closed forms: without samples, a level contrast of weight 1 and one of 1/3; with samples
    and alignment far beyond the noise, 1 and 1/3 on each of three axes."""
    one_row = calibrate(simulated(1, samples=1, repetitions=1))
    weights = np.array([1.0, 1.0 / 3.0])
    own = np.sum(weights**2) ** 2 / np.sum(weights**4)
    np.testing.assert_allclose(one_row.uncertainties.freedom, own)
    aligned = calibrate(simulated(1, samples=10**6, repetitions=1, alignment=0.02))
    shared = 3.0 * np.sum(weights) ** 2 / np.sum(weights**2)
    # A variance that cannot be below zero is known a little better: 4.8 become 5.3.
    np.testing.assert_allclose(aligned.uncertainties.freedom, shared / 0.898, rtol=0.01)


@pytest.mark.parametrize("phi", [0.0, 0.9])
def test_correlated_samples_widen_the_mean(phi):
    """A first-order process: means scatter by (1 + phi) / (1 - phi) more than white noise."""
    generator = np.random.default_rng(4)
    white = generator.standard_normal((24, 3000, 1))
    process = lfilter([np.sqrt(1 - phi**2)], [1, -phi], white, axis=1)[:, 500:]
    scatter = sample_scatter(list(process))
    # 24 records of 2500 samples know the sum to some 10 % (phi = 0.9).
    assert scatter.inflation == pytest.approx((1 + phi) / (1 - phi), rel=0.05 + 0.25 * phi)
    assert scatter.deviation == pytest.approx(1.0, rel=0.1)


def test_repetitions_of_another_kind_are_told():
    generator = np.random.default_rng(3)
    alike = simulated(3, repetitions=3)
    assert "repetitions agree" in calibration_words(calibrate(alike))
    offsets = 0.02 * generator.standard_normal((3, 1, 3))
    moved = calibrate(replace(alike, means=alike.means + offsets))
    assert "The zero bias changes between the repetitions" in calibration_words(moved)
    type_a = offsets[:, 0].std(axis=0, ddof=1) / np.sqrt(3)
    np.testing.assert_allclose(moved.u_bias, type_a, rtol=0.1)
    assert moved.uncertainties.freedom[0, 3] == pytest.approx(2.0, rel=0.1)
    fixture = calibrate(
        replace(alike, means=alike.means + 0.02 * generator.standard_normal((6, 3)))
    )
    words = calibration_words(fixture)
    assert "not clearly independent" in words
    assert "positions scatter by" in words
    assert "no more than" in calibration_words(calibrate(simulated(0, 100, 1)))


def write(path, rows, header="position,x,y,z"):
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def rows_of(test):
    return [
        f"{position},{x:.9f},{y:.9f},{z:.9f}"
        for mean in test.means
        for position, (x, y, z) in zip(POSITIONS, mean, strict=True)
    ]


def test_means_and_samples_are_read(tmp_path):
    test = simulated(1, repetitions=1)
    read = read_six_positions(write(tmp_path / "a.csv", rows_of(test)))
    np.testing.assert_allclose(read.means, test.means, atol=1e-9)
    assert read.scatter is None
    thousandths = [
        ",".join([row.split(",")[0], *(f"{1e3 * float(v):.6f}" for v in row.split(",")[1:])])
        for row in rows_of(test)
    ]
    in_mg = write(tmp_path / "b.csv", thousandths, "Position,x [mg],y [mg],z [mg]")
    np.testing.assert_allclose(read_six_positions(in_mg).means, test.means, atol=1e-8)
    generator = np.random.default_rng(3)
    samples = [
        f"{p},{','.join(f'{v:.9f}' for v in mean + NOISE * generator.standard_normal(3))}"
        for p, mean in zip(POSITIONS, test.means[0], strict=True)
        for _ in range(500)
    ]
    noise = read_six_positions(write(tmp_path / "c.csv", samples)).scatter.deviation
    # 3000 samples know a deviation to 1.3 %
    np.testing.assert_allclose(noise, NOISE, rtol=5 * 0.013)


def test_the_block_holds_the_interval_of_a_normal_distribution(tmp_path, capsys):
    path = write(tmp_path / "one.csv", rows_of(simulated(1, repetitions=1)))
    assert exit_code(["calibrate", str(path), "--output", str(tmp_path)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    fit = calibrate(read_six_positions(path))
    k = stdtrit(fit.uncertainties.freedom[0, 3], 0.975)
    assert f"degrees of freedom need k = {k:.1f}" in out
    text = (tmp_path / "one-calibration" / "calibration.yaml").read_text()
    assert f"uncertainty: {k * fit.u_bias[0] / 1.959964:.3g} g" in text
    assert f"u {fit.u_bias[0]:.3g}, " in text


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda rows: rows[:-1], "position -z is missing"),
        (lambda rows: [*rows[:5], rows[4].replace("+z", "-z")], "same outputs"),
        (lambda rows: [rows[1].replace("-x", "+x"), rows[0].replace("+x", "-x"), *rows[2:]],
         "interchanged"),
        (lambda rows: [rows[0].replace("+x", "north"), *rows[1:]], "is not one of"),
        (lambda rows: ["+x,one,0,0", *rows[1:]], 'test.csv:2: column "x" holds "one", where'),
        (lambda rows: ["+x,9.81,0.1,0.2", *rows[1:]], "unit into the header, such as x [m/s"),
        (lambda rows: ["+x,1.0", *rows[1:]], 'test.csv:2: column "y" holds nothing'),
        (lambda rows: ["+x,1.0,0,0,7", *rows[1:]], "test.csv:2: has more cells than the header"),
        (lambda rows: ["+x,nan,0,0", *rows[1:]], 'column "x" holds nothing (or nan)'),
        (lambda rows: ["", "# done by hand", "+x,,0,0", *rows[1:]], "test.csv:4: column"),
        (lambda _: [], "holds a header and no rows"),
    ],
)  # fmt: skip
def test_bad_tests_are_explained(tmp_path, change, message):
    path = write(tmp_path / "test.csv", change(rows_of(simulated(1, repetitions=1))))
    with pytest.raises(InputError) as caught:
        read_six_positions(path)
    assert message in str(caught.value)


def test_wrong_units_and_singular_matrices_are_explained(tmp_path, capsys):
    rows = rows_of(simulated(1, repetitions=1))
    path = write(tmp_path / "t.csv", rows, "position,x [deg/s],y [deg/s],z [deg/s]")
    assert exit_code(["calibrate", str(path), "--output", str(tmp_path / "out")]) == 2
    assert "an acceleration is needed here" in capsys.readouterr().err
    twice = [",".join([r.split(",")[0], *[r.split(",")[1]] * 3]) for r in rows]
    path = write(tmp_path / "s.csv", twice)
    assert exit_code(["calibrate", str(path), "--output", str(tmp_path / "out")]) == 2
    assert not (tmp_path / "out").exists()


def test_calibration_block_is_usable_in_a_scenario(tmp_path):
    path = write(tmp_path / "robot.csv", rows_of(simulated(5)), "position,x,y,z")
    lines = path.read_text().splitlines()
    numbered = [lines[0] + ",repetition", *(f"{r},{1 + i // 6}" for i, r in enumerate(lines[1:]))]
    path.write_text("\n".join(numbered) + "\n")
    assert exit_code(["calibrate", str(path), "--output", str(tmp_path)]) == 0
    folder = tmp_path / "robot-calibration"
    block = (folder / "calibration.yaml").read_text()
    text = (
        "case: velocity\ntrajectory: {top_speed: 0.4 m/s}\n"
        "sensor: {rate: 100 Hz, noise: {x: 1 mg, y: 1 mg, z: 1 mg}}\n"
        f"monte_carlo: {{realizations: 100}}\n{block}"
    )
    base = Scenario.from_yaml(text).base
    assert base.calibration.lxx.estimate == pytest.approx(0.98, abs=2e-3)
    assert base.calibration.bz.uncertainty > 0.0
    table = (folder / "calibration.csv").read_text()
    assert "lyz" in table
    assert len((folder / "residuals.csv").read_text().splitlines()) == 13


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("rate: 100 Hz", "rate: 20 Hz", "must lie below half of the sensor's rate, 10 Hz"),
        ("ppm}", "ppm, series: 1000, duration: 1 h}", "samples in all are more than"),
    ],
)
def test_shakers_that_cannot_be_simulated_are_explained(tmp_path, capsys, old, new, message):
    text = (SCENARIOS / "velocity" / "a1.yaml").read_text(encoding="utf-8")
    path = tmp_path / "s.yaml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    out = tmp_path / "out"
    assert exit_code(["linearity", str(path), "--output", str(out)]) == 2
    assert message in capsys.readouterr().err
    assert not out.exists()


def test_shaker_finds_slope_and_nonlinearity():
    frequencies = np.linspace(1.0, 10.0, 10)
    reference, time = frequencies / 10.0, np.arange(500) / 100.0
    cubic = cubic_of(5e-3, 3.0, 1.02, reference)
    measured = simulate_shaker(
        frequencies, reference, 1.02, cubic, 1e-3, time, 10, np.random.default_rng(2)
    )
    fit = linearity(reference, measured, 3.0)
    # Amplitudes err by 1e-3 sqrt(2 / 500 / 10) = 2e-5 g, that is 7 ppm of 3 g.
    assert fit.nonlinearity == pytest.approx(5e-3, abs=5 * 7e-6)
    # A cubic term c a^3 has the amplitude 3/4 c a^3 at the frequency itself.
    expected = np.polyfit(reference, 1.02 * (reference + 0.75 * cubic * reference**3), 1)
    np.testing.assert_allclose([fit.slope, fit.offset], expected, atol=1e-4)
    straight = simulate_shaker(
        frequencies, reference, 1.02, 0.0, 1e-3, time, 10, np.random.default_rng(2)
    )
    assert linearity(reference, straight, 3.0).nonlinearity < 5 * 7e-6
    assert fit.scale_uncertainty(3e-3, 1.02) == pytest.approx(
        np.hypot(3e-3, fit.nonlinearity / 1.02 / np.sqrt(3.0))
    )
    assert fit.bends
    assert not linearity(reference, straight, 3.0).bends


def test_uncertainty_of_a_slope_is_that_of_linregress_and_holds():
    reference = np.linspace(0.1, 1.0, 10)
    held = []
    for seed in range(400):
        generator = np.random.default_rng(seed)
        measured = 0.95 * reference + 0.01 + 1e-3 * generator.standard_normal(10)
        fit = linearity(reference, measured, 3.0)
        slope, offset = fit.slope_estimate, fit.offset_estimate
        oracle = linregress(reference, measured)
        assert slope.uncertainty == pytest.approx(oracle.stderr)
        assert offset.uncertainty == pytest.approx(oracle.intercept_stderr)
        held.append(
            [
                abs(e.value - true) < e.coverage_factor * e.uncertainty
                for e, true in ((slope, 0.95), (offset, 0.01))
            ]
        )
    assert np.mean(held, axis=0) == pytest.approx(0.95, abs=4 * 0.011)


@pytest.mark.slow
def test_equation_34_divides_by_the_element_of_the_matrix(tmp_path, capsys):
    """The slope of A2's bent line is 7 % from its mxx."""
    scenario = str(SCENARIOS / "velocity" / "a2.yaml")
    assert exit_code(["linearity", scenario, "--output", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    c = Scenario.from_yaml(scenario).base.calibration
    own = c.lxx.estimate - c.lxz.estimate * c.lzx.estimate / c.lzz.estimate
    # The row of L for y is (0, 1, 0).
    assert f"Eq. (34) with mxx = {1 / own:.6g}" in out
    assert "the points bend" in out
    assert out.startswith("simulated: slope")
    header = (tmp_path / "a2-linearity" / "linearity.csv").read_text().splitlines()[0]
    assert header == "reference [g],simulated [g],fitted [g],residual [ppm FS]"
    points = [f"{0.1 * i:.1f},{0.096 * i + 1e-3 * (-1) ** i:.4f}" for i in range(1, 9)]
    path = write(tmp_path / "s.csv", points, "reference,measured")
    command = ["linearity", str(path), "--full-scale", "15 g", "--output", str(tmp_path)]
    assert exit_code(command) == 0
    out = capsys.readouterr().out
    assert out.startswith("measured: slope")
    assert "give it by --mxx" in out
    assert "bend" not in out
    assert exit_code([*command, "--mxx", "0.96"]) == 0
    assert "with mxx = 0.96" in capsys.readouterr().out
    assert exit_code(["linearity", scenario, "--mxx", "0.96", "--output", str(tmp_path)]) == 2
    assert "--mxx: the scenario brings its own" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (["0.1,0", "0.2,0", "0.5,0", "1,0"], "the sensor did not follow"),
        (["0.1,0.1", "-1e308,0.2", "0.5,0.5", "1,1"], "s.csv:3: reference: -1e+308 g is no"),
        (["0.1,1e300", "0.2,0.2", "0.5,0.5", "1,1"], "s.csv:2: measured: 1e+300 g is no"),
        (["1,1", "1,1.1", "2,2", "2,2.1"], "has 2 different amplitudes"),
        (["1e-300,1", "2e-300,2", "3e-300,3", "4e-300,4"], "hardly differ"),
        (["0.1,0.1", "0.2,0.2", "0.3,0.3"], "3 points; a line"),
    ],
)
def test_extreme_amplitudes_are_explained(tmp_path, capsys, rows, message):
    path = write(tmp_path / "s.csv", rows, "reference,measured")
    out = tmp_path / "out"
    assert exit_code(["linearity", str(path), "--full-scale", "15 g", "--output", str(out)]) == 2
    assert message in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.slow
def test_commands_of_the_velocity_paper(tmp_path, capsys):
    out = ["--output", str(tmp_path), "--quiet"]
    assert exit_code(["figures", "12", "13", "14", *out]) == 0
    for number in (12, 13, 14):
        assert (tmp_path / f"figure{number}" / "figure.png").stat().st_size > 10_000
        assert (tmp_path / f"figure{number}" / "table.csv").exists()
    scenario = str(SCENARIOS / "velocity" / "a1.yaml")
    assert exit_code(["linearity", scenario, "--output", str(tmp_path)]) == 0
    assert "ppm of 15 g" in capsys.readouterr().out
    assert exit_code(["linearity", str(tmp_path / "none.csv"), "--full-scale", "15 g"]) == 2
    assert "no such file" in capsys.readouterr().err
    assert exit_code(["budget", str(SCENARIOS / "paper" / "figure1.yaml")]) == 2
    assert "a budget needs `case: velocity`" in capsys.readouterr().err
    assert exit_code(["budget", scenario, *out]) == 0
    table = (tmp_path / "a1-budget" / "budget.csv").read_text().splitlines()
    assert table[0] == "i,quantity,estimate,uncertainty,equation,sensitivity,variance,printed,ratio"
    assert len(table) == 33
    provenance = json.loads((tmp_path / "a1-budget" / "provenance.json").read_text())
    assert provenance["scenario"]["sensor"]["rate"] == "100 Hz"
    assert provenance["versions"].keys() >= {"python", "numpy"}
