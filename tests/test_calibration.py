"""Six-position and shaker tests: true parameters come back, wrong input is explained."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.special import stdtrit

from mcsim import InputError, Scenario
from mcsim.calibration import (
    calibrate,
    linearity,
    read_six_positions,
    simulate_shaker,
    simulate_six_positions,
)
from mcsim.calibration.shaker import cubic_of
from mcsim.calibration.six_positions import POSITIONS, TRUE
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


@pytest.mark.parametrize("repetitions", [2, 5])
@pytest.mark.parametrize("alignment", [0.0, 2e-3])
def test_uncertainties_hold_the_truth_as_often_as_they_say(repetitions, alignment):
    """95 % by Student's t; 400 tests make a rate uncertain by 0.011. Misalignment hardly
    touches the diagonal, whose uncertainty then errs on the safe side."""
    inside = []
    for seed in range(400):
        fit = calibrate(simulated(seed, repetitions=repetitions, alignment=alignment))
        z = np.append(
            (fit.correction - CORRECTION) / fit.u_correction, (fit.bias - BIAS) / fit.u_bias
        )
        inside.append(np.abs(z) < stdtrit(fit.freedom, 0.975))
    rates = np.mean(inside, axis=0)
    assert rates.min() > 0.95 - 4 * 0.011
    off_diagonal = [1, 2, 3, 5, 6, 7]
    assert rates[off_diagonal].max() < 0.95 + 4 * 0.011
    assert np.mean(inside) < 0.999  # intervals that hold everything would say nothing


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
    assert read.noise is None
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
    noise = read_six_positions(write(tmp_path / "c.csv", samples)).noise
    # 3000 samples know a deviation to 1.3 %
    np.testing.assert_allclose(noise, NOISE, rtol=5 * 0.013)


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


def test_shaker_finds_slope_and_nonlinearity():
    frequencies = np.linspace(1.0, 10.0, 10)
    reference = frequencies / 10.0
    cubic = cubic_of(5e-3, 3.0, 1.02, reference)
    measured = simulate_shaker(
        frequencies, reference, 1.02, cubic, 1e-3, 100.0, 5.0, 10, np.random.default_rng(2)
    )
    fit = linearity(reference, measured, 3.0)
    # Amplitudes err by 1e-3 sqrt(2 / 500 / 10) = 2e-5 g, that is 7 ppm of 3 g.
    assert fit.nonlinearity == pytest.approx(5e-3, abs=5 * 7e-6)
    # A cubic term c a^3 has the amplitude 3/4 c a^3 at the frequency itself.
    expected = np.polyfit(reference, 1.02 * (reference + 0.75 * cubic * reference**3), 1)
    np.testing.assert_allclose([fit.slope, fit.offset], expected, atol=1e-4)
    straight = simulate_shaker(
        frequencies, reference, 1.02, 0.0, 1e-3, 100.0, 5.0, 10, np.random.default_rng(2)
    )
    assert linearity(reference, straight, 3.0).nonlinearity < 5 * 7e-6
    assert fit.scale_uncertainty(3e-3) == pytest.approx(
        np.hypot(3e-3, fit.nonlinearity / fit.slope / np.sqrt(3.0))
    )


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
