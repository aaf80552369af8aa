"""Plans of static tests: Eq. (3.24), what a fit attains, and how often simulation agrees."""

import math

import numpy as np
import pytest

import mcsim
from mcsim.characterisation import allan_curve, fit_noise
from mcsim.characterisation.expected_errors import (
    TIME,
    Truth,
    clusters_needed,
    fit_errors,
    length_for,
    relative_error,
)
from mcsim.characterisation.process import GaussMarkov
from mcsim.cli.main import exit_code
from mcsim.errors import InputError
from tests.reference.noise import static_noise

MIX = (1.0, 0.1, 0.01)
TRUTH = Truth(np.array([0.0, 1.0, 0.01, 1e-4, 0.0]))


def test_nine_clusters_make_a_quarter():
    """S6: Eq. (3.25), and the thesis' example of 216 h for 24 h to 25 %."""
    assert relative_error(9.0) == 0.25
    assert clusters_needed(0.25) == 9.0
    assert 24.0 * clusters_needed(0.25) == 216.0
    assert relative_error(1.0) == math.inf
    # The thesis' 0.3 %: 14 h of clusters of 1 s.
    assert relative_error(14 * 3600.0) == pytest.approx(0.00315, abs=1e-5)


def test_errors_fall_with_the_root_of_the_length():
    long, longer = (fit_errors(TRUTH, t, 1.0) for t in (1e5, 4e5))
    for name in "BK":
        assert long[name] / longer[name] == pytest.approx(2.0, rel=0.2)
    assert length_for(0.05, lambda t: fit_errors(TRUTH, t, 1.0)["K"], 100.0) == pytest.approx(
        4.0 * length_for(0.1, lambda t: fit_errors(TRUTH, t, 1.0)["K"], 100.0), rel=0.25
    )
    assert length_for(1e-9, lambda t: fit_errors(TRUTH, t, 1.0)["K"], 100.0) == math.inf


@pytest.mark.slow
def test_a_planned_log_gives_the_accuracy():
    """Scatter of 25 fits of simulated logs that are planned for K to 10 %; a deviation of 25 values
    is known to 14 %, and the prediction is of first order."""
    length = length_for(0.1, lambda t: fit_errors(TRUTH, t, 1.0)["K"], 100.0)
    rng = np.random.default_rng(3)
    whole, quarter = [], []
    for found, share, trials in ((whole, 1.0, 25), (quarter, 0.25, 10)):
        for _ in range(trials):
            samples = static_noise(*MIX, 1.0, int(share * length), rng)
            fit = fit_noise(allan_curve(samples, 1.0), (0.0, 1e9), intervals="covariance")
            found.append([fit[term].value for term in "BK"])
    ratios = np.array(whole) / MIX[1:]
    promised = fit_errors(TRUTH, length, 1.0)
    assert promised["K"] == pytest.approx(0.1, rel=0.02)
    for scatter, term in zip(ratios.std(axis=0), "BK", strict=True):
        assert scatter == pytest.approx(promised[term], rel=0.45)
    np.testing.assert_allclose(ratios.mean(axis=0), 1.0, atol=0.06)
    # Control: a quarter of the log does not.
    assert (np.array(quarter) / MIX[1:])[:, 1].std() > 0.14


def test_a_correlation_time_is_known_as_well_as_it_can_be():
    """The Cramér-Rao bound of an Ornstein-Uhlenbeck process that is seen itself: √(2 Tc / T)."""
    model = GaussMarkov(20.0, 0.5)
    truth = Truth(np.array([0.0, 0.0225, 0.0, 0.0, 0.0]), model)
    for length in (5e3, 5e4):
        bound = math.sqrt(2.0 * model.correlation_time / length)
        assert bound < fit_errors(truth, length, 0.1)[TIME] < 1.3 * bound
        # Eq. (3.24) at the peak promises more than any estimate can hold.
        assert relative_error(length / (1.89 * model.correlation_time)) < 0.8 * bound


def test_the_plan_of_a_named_sensor():
    plan = mcsim.allan.plan("MPU-9250", "10 %")
    assert {t.name for t in plan.terms} == {"N", "B", "K"}
    assert [t.axis.axis for t in plan.terms[::3]] == ["x", "y", "z"]
    assert plan.rate == 920.0  # twice the bandwidth
    for t in plan.terms:
        assert t.by_equation == pytest.approx(t.reading.tau * 51.0)
        assert t.reading.bias <= 0.1
    assert plan.length == max(t.by_fit for t in plan.terms)
    finer = mcsim.allan.plan("MPU-9250", "5 %", terms=("K",), axis="z")
    (z,) = finer.terms
    assert z.by_fit > 3.0 * plan.terms[-1].by_fit
    assert "Log " in plan.text
    assert "too low" in mcsim.allan.plan("MPU-9250", rate="100 Hz", axis="x").text


def test_a_plan_says_what_is_hidden_and_what_never_comes(tmp_path):
    file = tmp_path / "walker.yaml"
    file.write_text(
        "accelerometer: {velocity_random_walk: 1 m/s/√h, bias_instability: 0.5 m/s/h, "
        "acceleration_random_walk: 100 m/s/h^1.5}\n"
    )
    text = mcsim.allan.plan(file).text
    assert "Hidden: B" in text


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--sensor", "MPU-9250", "--accuracy", "10"], "has no unit"),
        (["--sensor", "MPU-9250", "--accuracy", "90 %"], "between 0.5 % and 50 %"),
        (["--sensor", "MPU-9250", "--terms", "N,Tc"], "MPU-9250 has no Tc"),
        (["--sensor", "MPU-9250", "--terms", "Z"], '"Z" is none of N, B, K, Tc'),
        (["--sensor", "MPU-9250", "--rate", "0 Hz"], "above zero"),
        (["--sensor", "MPU-9250", "--element", "gyroscope"], "has no gyroscope"),
        (["--sensor", "MPU-9251"], 'did you mean "MPU-9250"'),
        (["--sensor", "LIS33DE"], "no noise of Allan analysis"),
    ],
)
def test_bad_plans_are_refused(arguments, said, capsys):
    assert exit_code(["allan", "plan", *arguments]) == 2
    out, err = capsys.readouterr()
    assert said in err
    assert not out


def test_a_plan_is_written(tmp_path, capsys):
    folder = tmp_path / "plan"
    arguments = [
        "allan",
        "plan",
        "--sensor",
        "BNO055",
        "--accuracy",
        "20%",
        "--output",
        str(folder),
    ]
    assert exit_code(arguments) == 0
    assert {f.name for f in folder.iterdir()} == {
        "plan.csv", "plan.png", "plan.svg", "provenance.json",
    }  # fmt: skip
    assert "log for the fit" in capsys.readouterr().out


def test_unknown_sensors_are_no_plan():
    with pytest.raises(InputError, match="--axis"):
        mcsim.allan.plan("MPU-9250", axis="w")
