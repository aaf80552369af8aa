"""How often the intervals of a run hold the truth, from nearly linear cases to rare events.

    python -m benchmarks.coverage [--trials 300] [--seed 1] [--case NAME …]

Each trial is a run with random numbers of its own; the truth is one run of two million
realizations, with controls where the trials may have them, which knows it to a fourteenth of the
deviation of the most certain trials.  Coverage in per cent of intervals of 95 % and of 99.73 %,
mean over the errors and, in brackets, the worst one; of 300 trials an error's has itself a standard
deviation of 1.3 and of 0.3.  Errors that do not scatter are left out.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from mcsim.engine import collect, random_key, run_point
from mcsim.estimation import LOOKED_AT
from mcsim.scenario.run import MonteCarlo
from mcsim.simulation.problem import Problem
from mcsim.statistics import estimate, estimated
from tests.conftest import ALL_ERRORS, problem, scenario
from tests.strapdown import problem as problem_in_space

CURVE = {"trajectory": {"shape": "curve", "radius": "30 m", "angle": "90 °", "speed": "10 m/s"}}
LANE = {"shape": "half_cosine"}
_ACCELEROMETER = "sensors.accelerometer"


def spikes(rate: str) -> dict[str, Any]:
    return {f"{_ACCELEROMETER}.spikes": {"rate": rate, "amplitude": "100 m/s^2"}}


CASES: dict[str, dict[str, Any]] = {
    "nearly linear": ALL_ERRORS,
    "gyroscope 3 °/s": {**ALL_ERRORS, "sensors.gyroscope.miscalibration": "3 °/s"},
    "wide angles": {
        **CURVE,
        "sensors.gyroscope.miscalibration": "40 °/s",
        "initial.direction_error": "60 °",
    },
    "rare wraps": {"initial.direction_error": "52 °"},
    "wraps": {"initial.direction_error": "200 °"},
    "saturating": {
        f"{_ACCELEROMETER}.miscalibration": "0.5 m/s^2",
        f"{_ACCELEROMETER}.range": "4.2 m/s^2",
    },
    "rarely saturating": {
        f"{_ACCELEROMETER}.miscalibration": "0.1 m/s^2",
        f"{_ACCELEROMETER}.range": "4.6 m/s^2",
    },
    "spikes, 1 in 20 runs": spikes("0.01 Hz"),
    "spikes, 1 in 2000": spikes("0.0001 Hz"),
    "strapdown, tilt 5 °": {"initial.tilt_error": "5 °"},
    "strapdown, tilt 25 °": {"initial.tilt_error": "25 °"},
    "calibrated rest": {
        "trajectory.speed": "15 m/s",
        "sensors.calibration": {"duration": "5 s", "method": "kalman"},
        _ACCELEROMETER: {
            "noise_density": "0.01 m/s²/√Hz",
            "turn_on_bias": "50 mg",
            "acceleration_random_walk": "0.02 m/s²/√s",
            "gauss_markov": {"deviation": "0.05 m/s²", "correlation_time": "3 s"},
        },
        "sensors.gyroscope": {
            "noise_density": "0.1 °/s/√Hz",
            "turn_on_bias": "1 °/s",
            "rate_random_walk": "0.1 °/s/√s",
            "bias_instability": "0.1 °/s",
        },
    },
    "strapdown, slow rate": {
        "trajectory": {"shape": "straight", "length": "10 m", "speed": "10 m/s", "lead": "0 s"},
        "sensors.rate": "5 Hz",
        "sensors.calibration": {"duration": "20 s", "method": "kalman"},
        _ACCELEROMETER: {"noise_density": "0 m/s²/√Hz"},
        "sensors.gyroscope": {
            "noise_density": "0.001 °/s/√Hz",
            "gauss_markov": {"deviation": "1 °/s", "correlation_time": "1 s"},
        },
    },
    "strapdown, averages": {
        "trajectory": {**LANE, "length": "30 m", "width": "3 m", "speed": "12 m/s"},
        "sensors.rate": "50 Hz",
        "sensors.sampling": "average",
        "sensors.calibration": {"duration": "3 s", "method": "kalman"},
        "reconstruction.integration": "forward_euler",
        _ACCELEROMETER: {
            "noise_density": "0.02 m/s²/√Hz",
            "turn_on_bias": "1 m/s²",
            "bias_instability": "0.05 m/s²",
        },
        "sensors.gyroscope": {
            "noise_density": "0.2 °/s/√Hz",
            "turn_on_bias": "1 °/s",
            "gauss_markov": {"deviation": "0.5 °/s", "correlation_time": "2 s"},
        },
    },
}
RUNS = (
    (100, "plain", "random"),
    (1000, "plain", "random"),
    (1000, "control_variate", "random"),
    (1000, "plain", "sobol"),
    (1000, "control_variate", "sobol"),
    (10_000, "control_variate", "random"),
)
LEVELS = (1.959964, 3.0)
#: Fewer than a run takes, to save time: they make the ends of the intervals noisier.
RESAMPLES = 300
TRUTH = 2_000_000
#: Rounding, in units of a value.
_ROUNDING = 1e-9


def problem_of_case(name: str) -> Problem:
    """The problem of one of the cases."""
    if name.startswith("strapdown"):
        return problem_in_space(CASES[name])
    return problem(CASES[name])


def settings(**values: Any) -> MonteCarlo:
    return scenario({f"monte_carlo.{key}": value for key, value in values.items()}).base.monte_carlo


def coverage(
    p: Problem, truth: np.ndarray, run: tuple[int, str, str], trials: int, seed: int
) -> np.ndarray:
    """Share (levels, e, statistics) of intervals that hold the truth, in per cent."""
    count, estimator, offsets = run
    hits = np.zeros((len(LEVELS), *truth.shape))
    mc = settings(realizations=count, estimator=estimator, offsets=offsets)
    limits = p.limits(1, LOOKED_AT)
    for key in range(trials):
        collector = collect(p, mc, count, limits, random_key(seed, "coverage", str(key)))
        for level, sigmas in enumerate(LEVELS):
            e = estimate(collector, sigmas, RESAMPLES, 1)
            margin = _ROUNDING * np.abs(e.value)
            hits[level] += (e.low - margin <= truth) & (truth <= e.high + margin)
    return 100.0 * hits / trials


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", action="append", choices=list(CASES))
    arguments = parser.parse_args()
    print(f"{arguments.trials} trials, seed {arguments.seed}; coverage of intervals of")
    print("95 % and 99.73 %, mean (worst) of the errors")
    names = tuple(estimated())
    shown = [0, 1, 2, 4]
    print(f"{'':45}" + "".join(f"{names[k]:^29}" for k in shown))
    for case in arguments.case or CASES:
        p = problem_of_case(case)
        # Controlled: errors that are exactly linear have intervals of no width.
        known = settings(realizations=TRUTH, estimator="control_variate")
        known_point = run_point(p, known, 1, 2).estimates
        truth, scatters = known_point.value, ~known_point.degenerate
        for run in RUNS:
            found = coverage(p, truth, run, arguments.trials, arguments.seed)
            cells = [
                "  ".join(
                    f"{c[scatters, k].mean():5.1f} ({c[scatters, k].min():5.1f})" for c in found
                )
                + " "
                for k in shown
            ]
            count, estimator, offsets = run
            label = f"{case:21}{count:6}  {estimator.split('_')[0]:8}{offsets:7} "
            print(label + " ".join(cells), flush=True)


if __name__ == "__main__":
    main()
