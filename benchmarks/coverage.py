"""How often the intervals of a run hold the truth, from nearly linear cases to rare events.

    python -m benchmarks.coverage [--trials 150] [--case NAME …]

Each trial is a run with random numbers of its own; the truth is one run of two million
realizations, which knows it to a fourteenth of the widest interval's deviation.  Coverage in per
cent of intervals of 95 % and of 99.73 %, mean over the errors and, in brackets, the worst one; of
150 trials it has itself a standard deviation of 1.8 and of 0.4.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from mcsim.cases.problem import Problem
from mcsim.engine import collect, run_point
from mcsim.estimation import LOOKED_AT
from mcsim.scenario.run import MonteCarlo
from mcsim.statistics import estimate, statistic_names
from tests.conftest import ALL_ERRORS, problem, scenario
from tests.strapdown import problem as problem_in_space

CURVE = {"trajectory": {"shape": "curve", "radius": "30 m", "angle": "90 °", "speed": "10 m/s"}}
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
}
RUNS = (
    (100, "plain", "random"),
    (1000, "plain", "random"),
    (1000, "control_variate", "random"),
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


def coverage(p: Problem, truth: np.ndarray, run: tuple[int, str, str], trials: int) -> np.ndarray:
    """Share (levels, e, statistics) of intervals that hold the truth, in per cent."""
    count, estimator, offsets = run
    hits = np.zeros((len(LEVELS), *truth.shape))
    mc = settings(realizations=count, estimator=estimator, offsets=offsets)
    limits = p.limits(1, LOOKED_AT)
    for key in range(trials):
        collector = collect(p, mc, count, limits, 1000 + key)
        for level, sigmas in enumerate(LEVELS):
            e = estimate(collector, sigmas, RESAMPLES, 1)
            margin = _ROUNDING * np.abs(e.value)
            hits[level] += (e.low - margin <= truth) & (truth <= e.high + margin)
    return 100.0 * hits / trials


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=150)
    parser.add_argument("--case", action="append", choices=list(CASES))
    arguments = parser.parse_args()
    print(f"{arguments.trials} trials; coverage of 95 % and 99.73 %, mean (worst) of the errors")
    names = statistic_names((0.5, 0.95))
    shown = [0, 1, 2, 4]
    print(f"{'':45}" + "".join(f"{names[k]:^29}" for k in shown))
    for case in arguments.case or CASES:
        p = problem_of_case(case)
        # Controlled: errors that are exactly linear have intervals of no width.
        known = settings(realizations=TRUTH, estimator="control_variate")
        truth = run_point(p, known, 1, 2).estimates.value
        for run in RUNS:
            found = coverage(p, truth, run, arguments.trials)
            cells = [
                "  ".join(f"{c[:, k].mean():5.1f} ({c[:, k].min():5.1f})" for c in found) + " "
                for k in shown
            ]
            count, estimator, offsets = run
            label = f"{case:21}{count:6}  {estimator.split('_')[0]:8}{offsets:7} "
            print(label + " ".join(cells), flush=True)


if __name__ == "__main__":
    main()
