"""How well N, B and K of the thesis's Tables 5.4 to 5.6 come back from simulated logs.

    python -m benchmarks.recovery [--trials 200]

First one log of 14 h at 100 Hz per axis, fitted as ``mcsim characterise`` does; then, for
scatter and coverage, many logs of 14 h at 2.5 Hz, fitted from 4 s on: what scatters is
the long clusters, which do not know the rate.  Flicker noise is Kasdin's, by FFT.
"""

from __future__ import annotations

import argparse

import numpy as np

from mcsim.characterisation import allan_curve, fit_noise
from tests.reference.noise import THESIS, flicker, in_si, static_noise

RATE, SLOW_RATE, HOURS_14 = 100.0, 2.5, 14 * 3600
TERMS = "NBK"


def full_log(truth: tuple[float, float, float], seed: int) -> str:
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


def scatter(truth: tuple[float, float, float], noises: list[np.ndarray]) -> str:
    """Mean error, standard deviation and coverage (per cent) of each coefficient."""
    white, instability, walk = truth
    rng = np.random.default_rng(1)
    n = len(noises[0])
    ratios, hits = [], []
    for pink in noises:
        samples = static_noise(white, 0.0, walk, SLOW_RATE, n, rng) + instability * pink
        fit = fit_noise(allan_curve(samples, SLOW_RATE), (4.0, 1e9))
        found = [fit[term] for term in TERMS]
        ratios.append([c.value / value for c, value in zip(found, truth, strict=True)])
        hits.append([c.low < value < c.high for c, value in zip(found, truth, strict=True)])
    mean, deviation = np.mean(ratios, axis=0) - 1.0, np.std(ratios, axis=0)
    return "".join(
        f"{100 * m:+7.1f} ±{100 * d:5.1f}{100 * h:6.1f}"
        for m, d, h in zip(mean, deviation, np.mean(hits, axis=0), strict=True)
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=200)
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    noises = [flicker(int(HOURS_14 * SLOW_RATE), rng) for _ in range(options.trials)]
    print("error of one log (100 Hz) in %; * outside of its own 95 % interval")
    print(f"then of {options.trials} logs: mean error ± standard deviation, coverage, in %\n")
    print(f"{'':<12}{'N':>8}{'B':>9}{'K':>9}   {'N':>14}{'B':>21}{'K':>21}")
    for sensor, axes in THESIS.items():
        for k, (axis, coefficients) in enumerate(zip("xyz", axes, strict=True)):
            truth = in_si(coefficients)
            one, many = full_log(truth, 100 + k), scatter(truth, noises)
            print(f"{sensor:<10}{axis} {one}  {many}", flush=True)


if __name__ == "__main__":
    main()
