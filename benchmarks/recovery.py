"""How well N, B and K of the thesis's Tables 5.4 to 5.6 come back from simulated logs.

    python -m benchmarks.recovery [--trials 200]

First one log of 14 h at 100 Hz per axis, fitted as ``mcsim characterise`` does; then, for
scatter and coverage, many logs of 14 h at 2.5 Hz, fitted from 4 s on: what scatters is
the long clusters, which do not know the rate.  Flicker noise is Kasdin's, by FFT.  The last
rows have white noise whose level wanders by half: noise that no longer is what the covariance
of the curve takes it for.
"""

from __future__ import annotations

import argparse

import numpy as np

from mcsim.characterisation import allan_curve, fit_noise
from mcsim.characterisation.fit import Intervals
from tests.reference.noise import THESIS, flicker, gauss_markov, in_si, static_noise

RATE, SLOW_RATE, HOURS_14 = 100.0, 2.5, 14 * 3600
TERMS = "NBK"
METHODS: tuple[Intervals, ...] = ("bootstrap", "covariance")
WANDER, WANDER_TIMES = 0.5, (300.0, 1800.0)

Truth = tuple[float, float, float]


def full_log(truth: Truth, seed: int) -> str:
    """Errors of one fit in per cent; a star where the 95 % interval misses the truth."""
    rng = np.random.default_rng(seed)
    samples = static_noise(*truth, RATE, int(HOURS_14 * RATE), rng)
    fit = fit_noise(allan_curve(samples, RATE))
    cells = []
    for term, value in zip(TERMS, truth, strict=True):
        found = fit[term]
        inside = found.low < value < found.high
        cells.append(f"{100 * (found.value / value - 1):+8.2f}{' ' if inside else '*'}")
    return "".join(cells)


def scatter(truth: Truth, noises: list[np.ndarray], wander_time: float = 0.0) -> str:
    """Of each coefficient mean error, deviation, and coverage by each method (per cent)."""
    white, instability, walk = truth
    rng = np.random.default_rng(1)
    n = len(noises[0])
    ratios, hits = [], []
    for pink in noises:
        samples = static_noise(white, 0.0, 0.0, SLOW_RATE, n, rng)
        if wander_time:
            level = np.exp(gauss_markov(wander_time, WANDER, SLOW_RATE, n, rng) - WANDER**2)
            samples *= level
        samples += static_noise(0.0, 0.0, walk, SLOW_RATE, n, rng) + instability * pink
        curve = allan_curve(samples, SLOW_RATE)
        fits = [fit_noise(curve, (4.0, 1e9), intervals=method) for method in METHODS]
        ratios.append([fits[0][t].value / value for t, value in zip(TERMS, truth, strict=True)])
        hits.append(
            [
                [fit[t].low < value < fit[t].high for fit in fits]
                for t, value in zip(TERMS, truth, strict=True)
            ]
        )
    mean, deviation = np.mean(ratios, axis=0) - 1.0, np.std(ratios, axis=0)
    return "".join(
        f"{100 * m:+7.1f} ±{100 * d:5.1f}" + "".join(f"{100 * share:6.1f}" for share in shares)
        for m, d, shares in zip(mean, deviation, np.mean(hits, axis=0), strict=True)
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--no-full-logs", action="store_true")
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    noises = [flicker(int(HOURS_14 * SLOW_RATE), rng) for _ in range(options.trials)]
    print("error of one log (100 Hz) in %; * outside of its own 95 % interval")
    print(f"then of {options.trials} logs: mean error ± standard deviation in %, and coverage in %")
    print(f"of the 95 % intervals by {' and by '.join(METHODS)}\n")
    print(f"{'':<12}{'N':>8}{'B':>9}{'K':>9}   {'N':>14}{'B':>27}{'K':>27}")
    for sensor, axes in THESIS.items():
        for k, (axis, coefficients) in enumerate(zip("xyz", axes, strict=True)):
            truth = in_si(coefficients)
            one = f"{'':27}" if options.no_full_logs else full_log(truth, 100 + k)
            print(f"{sensor:<10}{axis} {one}  {scatter(truth, noises)}", flush=True)
    for time in WANDER_TIMES:
        print(f"\nwhite noise whose level wanders, correlation time {time:g} s:")
        for sensor in ("LSM9DS1", "LSM303"):
            truth = in_si(THESIS[sensor][0])
            print(f"{sensor:<10}x {'':27}  {scatter(truth, noises, time)}", flush=True)


if __name__ == "__main__":
    main()
