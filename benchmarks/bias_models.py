"""How often a log's bias is taken for what it is: Gauss-Markov, flicker or random walk.

    python -m benchmarks.bias_models [--trials 50]

Logs of 14 h (T) with the white noise of the LSM9DS1's x axis, sampled at 1 Hz and fitted from
4 s on, since all that differs is in the long clusters.
"""

from __future__ import annotations

import argparse

import numpy as np

from mcsim.characterisation import allan_curve, fit_noise
from tests.reference.noise import THESIS, gauss_markov, in_si, static_noise

DURATION, RATE = 14 * 3600, 1.0
WHITE, FLICKER, WALK = in_si(THESIS["LSM9DS1"][0])
#: N, B and K; correlation time as a part of the log, and deviation (m/s²), of a process.
CASES = {
    "white": ((WHITE, 0.0, 0.0), None),
    "B": ((WHITE, FLICKER, 0.0), None),
    "K": ((WHITE, 0.0, WALK), None),
    "10 K": ((WHITE, 0.0, 10.0 * WALK), None),
    **{
        f"{sensor} {'xyz'[axis]}": (in_si(THESIS[sensor][axis]), None)
        for sensor, axis in (("LSM9DS1", 0), ("BNO055", 1), ("Xsens", 2))
    },
    **{
        f"Gauss-Markov, T/{part}": ((WHITE, 0.0, 0.0), (part, 2e-3))
        for part in (200, 50, 20, 10, 5, 3)
    },
    **{f"B, Gauss-Markov, T/{part}": ((WHITE, FLICKER, 0.0), (part, 2e-3)) for part in (50, 20)},
    **{f"K, Gauss-Markov, T/{part}": ((WHITE, 0.0, WALK), (part, 1e-3)) for part in (100, 20)},
}


def samples_of(case: str, seed: int) -> np.ndarray:
    """A simulated log (n,)."""
    noises, process = CASES[case]
    rng = np.random.default_rng(seed)
    samples = static_noise(*noises, RATE, DURATION, rng)
    if process is not None:
        part, deviation = process
        samples += gauss_markov(DURATION / part, deviation, RATE, DURATION, rng)
    return samples


def row(case: str, trials: int) -> str:
    """Shares of each answer in per cent; the medians of what is found of a process."""
    found = []
    for seed in range(trials):
        curve = allan_curve(samples_of(case, seed), RATE)
        found.append(fit_noise(curve, (4.0, 1e9), intervals="covariance").comparison)
    decided = [c.process.model for c in found if c.is_gauss_markov and c.process]
    share = [len(decided), sum(c.is_undecided for c in found)]
    cells = [100.0 * x / trials for x in (*share, trials - sum(share))]
    text = f"{case:<24}" + "".join(f"{cell:12.0f}" for cell in cells)
    alike = [c.shortest_alike for c in found if c.shortest_alike is not None]
    text += f"{np.median(alike):16.0f}" if alike else f"{'–':>16}"
    if decided:
        times = [DURATION / m.correlation_time for m in decided]
        text += f"{np.median(times):12.0f}{1e3 * np.median([m.deviation for m in decided]):12.2f}"
    return text


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=50)
    trials = parser.parse_args().trials
    print(f"answers of {trials} logs each, in %; a Gauss-Markov bias slower than `alike` could be")
    print("the random walk; where Gauss-Markov is the answer, medians of T/Tc and σ [1e-3 m/s²]\n")
    titles = ("Gauss-Markov", "undecided", "B or K")
    print(
        f"{'':<24}"
        + "".join(f"{t:>12}" for t in titles)
        + f"{'alike [s]':>16}{'T/Tc':>12}{'σ':>12}"
    )
    for case in CASES:
        print(row(case, trials), flush=True)


if __name__ == "__main__":
    main()
