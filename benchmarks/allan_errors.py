"""What Eq. (3.24) and the planner promise, and what simulated logs give.

    python -m benchmarks.allan_errors [--seeds 6] [--trials 30]

First the thesis' 15 axes: logs of 14 h at 10 Hz with the printed N, B and K, several seeds; how
often the printed errors, Eq. (3.24) where each term is read, and the fit's own 95 % hold the truth.
Then mixes of noises, in logs that are planned for an accuracy: the scatter of the fits, and of the
peak rule for Tc, beside the promise and Eq. (3.24).
"""

from __future__ import annotations

import argparse

import numpy as np

from mcsim.characterisation import GaussMarkov, allan_curve, fit_noise
from mcsim.characterisation.expected_errors import (
    TIME,
    Truth,
    fit_errors,
    length_for,
    relative_error,
)
from mcsim.characterisation.peak_rule import find_peak
from mcsim.papers.allan_recovery import SENSORS, TERMS, recovered
from tests.reference.noise import gauss_markov, static_noise

MIXES = {"K to 10 %": ("K", 0.1, (1.0, 0.1, 0.01)), "B to 10 %": ("B", 0.1, (1.0, 0.1, 0.003))}
CORRELATION, DEVIATION, WHITE, RATE = 20.0, 0.5, 0.15, 10.0
ACCURACIES = (0.1, 0.2)


def recovery(seeds: int) -> None:
    found = [e for seed in range(1, seeds + 1) for e in recovered(seed=seed)]
    print(f"{seeds} logs of 14 h at 10 Hz of each of {3 * len(SENSORS)} axes: shares in % of the")
    print("coefficients whose error is within what is stated (one standard error: 68), and the")
    print("root mean square of error over statement")
    print(f"{'':4}{'printed ±':>12}{'rms':>8}{'Eq. (3.24)':>12}{'rms':>8}{'95 % of the fit':>18}")
    for term in TERMS:
        own = [e for e in found if e.term == term]
        off = np.array([e.off for e in own])
        printed, equation = (
            np.array([e.printed_error for e in own]),
            np.array([e.error for e in own]),
        )
        inside = 100.0 * np.mean([e.inside_interval for e in own])
        cells = []
        for stated in (printed, equation):
            share = 100.0 * np.mean(np.abs(off) <= stated)
            cells.append(f"{share:12.0f}{np.sqrt(np.mean((off / stated) ** 2)):8.2f}")
        print(f"{term:4}{''.join(cells)}{inside:18.1f}", flush=True)


def planned(name: str, trials: int) -> None:
    term, asked, mix = MIXES[name]
    truth = Truth(np.array([0.0, *np.square(mix), 0.0]))
    length = length_for(asked, lambda t: fit_errors(truth, t, 1.0)[term], 100.0)
    promised = fit_errors(truth, length, 1.0)
    rng = np.random.default_rng(1)
    values = []
    for _ in range(trials):
        samples = static_noise(*mix, 1.0, int(length), rng)
        fit = fit_noise(allan_curve(samples, 1.0), (0.0, 1e9), intervals="covariance")
        values.append([fit[t].value for t in TERMS])
    ratios = np.array(values) / mix
    cells = [
        f"{t} {100 * promised[t]:5.1f} {100 * s:5.1f} {100 * m:+5.1f}"
        for t, s, m in zip(TERMS, ratios.std(axis=0), ratios.mean(axis=0) - 1.0, strict=True)
    ]
    print(f"{name:10} {length:8.0f} s   {'   '.join(cells)}", flush=True)


def correlation_times(asked: float, trials: int) -> None:
    truth = Truth(np.array([0.0, WHITE**2, 0.0, 0.0, 0.0]), GaussMarkov(CORRELATION, DEVIATION))
    length = length_for(asked, lambda t: fit_errors(truth, t, 1.0 / RATE)[TIME], 100.0)
    n, rng = int(RATE * length), np.random.default_rng(4)
    fitted, read = [], []
    for _ in range(trials):
        samples = gauss_markov(CORRELATION, DEVIATION, RATE, n, rng)
        samples += WHITE * np.sqrt(RATE) * rng.standard_normal(n)
        curve = allan_curve(samples, RATE)
        fit = fit_noise(curve, intervals="covariance")
        process = fit.comparison.process
        fitted += [] if process is None else [process.model.correlation_time]
        peak = find_peak(curve.tau, curve.variance, fit["N"].value)
        read += [] if peak is None else [peak.correlation_time]
    equation = relative_error(length / (1.89 * CORRELATION))
    print(
        f"Tc to {100 * asked:.0f} %  {length:8.0f} s   Eq. (3.24) {100 * equation:.1f}, promised "
        f"{100 * asked:.1f}, fit {100 * np.std(np.log(fitted)):.1f} ({len(fitted)} logs), peak "
        f"rule {100 * np.std(np.log(read)):.1f} ({len(read)} logs have a peak)",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--trials", type=int, default=30)
    options = parser.parse_args()
    recovery(options.seeds)
    print(
        f"\n{options.trials} logs planned for an accuracy; promised error, scatter, mean error in %"
    )
    for name in MIXES:
        planned(name, options.trials)
    for asked in ACCURACIES:
        correlation_times(asked, options.trials)


if __name__ == "__main__":
    main()
