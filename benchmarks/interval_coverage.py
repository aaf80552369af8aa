"""How often the intervals of ``mcsim characterise`` hold, and how often it finds what is not there.

    python -m benchmarks.interval_coverage [--trials 40] [--healthy 200]

Coverage of the 95 % intervals of N, B, K, R, of a Gauss-Markov bias and of the Allan deviation
itself, for output as sensors have it: white, filtered, averaged, held, decimated, with slow
noises.  Then healthy logs of 90 s to 2 h, of random mixes of noises and quantisation, and what
is wrongly found in them.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.signal import butter, lfilter

from mcsim.characterisation import allan_curve, characterise, fit_noise
from mcsim.characterisation.allan import degrees_of_freedom, intervals
from mcsim.errors import InputError
from mcsim.logs.model import Channel, Log, Timing
from tests.reference.noise import gauss_markov, static_noise

Array = np.ndarray
WHITE = 2e-3
#: Findings that describe a log and blame nothing; a bias without a correlation time is flicker.
HARMLESS = {"length", "channels", "units", "remark", "log", "quantisation", "coarse", "bias"}


def white(n: int, rate: float, rng: np.random.Generator) -> Array:
    return static_noise(WHITE, 0.0, 0.0, rate, n, rng)


def filtered(order: int, cut: float) -> Callable[..., Array]:
    """White noise through a Butterworth low-pass (Hz) that has settled."""

    def make(n: int, rate: float, rng: np.random.Generator) -> Array:
        settle = int(20.0 * rate / cut)
        numerator, denominator = butter(order, cut / (0.5 * rate))
        return lfilter(numerator, denominator, white(n + settle, rate, rng))[settle:]

    return make


def averaged(count: int) -> Callable[..., Array]:
    return lambda n, rate, rng: np.convolve(
        white(n + count - 1, rate, rng), np.full(count, 1.0 / count), "valid"
    )


def held(count: int) -> Callable[..., Array]:
    return lambda n, rate, rng: np.repeat(white(-(-n // count), rate / count, rng), count)[:n]


def mixed(b: float, k: float, ramp: float = 0.0) -> Callable[..., Array]:
    return lambda n, rate, rng: static_noise(WHITE, b, k, rate, n, rng) + ramp * np.arange(n) / rate


def biased(time: float, deviation: float) -> Callable[..., Array]:
    return lambda n, rate, rng: white(n, rate, rng) + gauss_markov(time, deviation, rate, n, rng)


#: Maker, rate (Hz), length (s), and the truth beside N.
CASES: dict[str, tuple[Callable[..., Array], float, float, dict[str, float]]] = {
    "white, 90 s": (white, 100.0, 90.0, {"B": 0.0, "K": 0.0}),
    "white, 15 min": (white, 100.0, 900.0, {"B": 0.0, "K": 0.0}),
    "white, 4 h": (white, 10.0, 14_400.0, {"B": 0.0, "K": 0.0}),
    "first order 5 Hz of 100 Hz, 15 min": (filtered(1, 5.0), 100.0, 900.0, {"B": 0.0, "K": 0.0}),
    "first order 5 Hz of 200 Hz, 90 s": (filtered(1, 5.0), 200.0, 90.0, {"B": 0.0, "K": 0.0}),
    "Butterworth 2, 20 Hz of 100 Hz, 15 min": (
        filtered(2, 20.0), 100.0, 900.0, {"B": 0.0, "K": 0.0},
    ),
    "mean of 10, 15 min": (averaged(10), 100.0, 900.0, {"B": 0.0, "K": 0.0}),
    "held 4 times, 15 min": (held(4), 100.0, 900.0, {"B": 0.0, "K": 0.0}),
    "flicker, 2 h": (mixed(1e-3, 0.0), 20.0, 7200.0, {"B": 1e-3, "K": 0.0}),
    "random walk, 2 h": (mixed(0.0, 5e-5), 20.0, 7200.0, {"B": 0.0, "K": 5e-5}),
    "random walk too weak to see, 15 min": (
        mixed(0.0, 5e-6), 100.0, 900.0, {"B": 0.0, "K": 5e-6},
    ),
    "flicker and random walk, 2 h": (mixed(1e-3, 5e-5), 20.0, 7200.0, {"B": 1e-3, "K": 5e-5}),
    "ramp, 1 h": (mixed(0.0, 0.0, 5e-6), 20.0, 3600.0, {"R": 5e-6}),
    "Gauss-Markov 10 s, 2 h": (biased(10.0, 3e-3), 10.0, 7200.0, {"Tc": 10.0, "σ": 3e-3}),
    "Gauss-Markov 40 s, 2 h": (biased(40.0, 3e-3), 10.0, 7200.0, {"Tc": 40.0, "σ": 3e-3}),
    "Gauss-Markov 300 s, 4 h": (biased(300.0, 3e-3), 2.0, 14_400.0, {"Tc": 300.0, "σ": 3e-3}),
}  # fmt: skip
TERMS = ("N", "B", "K", "R", "Tc", "σ", "ADEV")


def coverage(case: str, trials: int) -> str:
    """Share of intervals that hold, per cent, of each term; how far N is off on the mean."""
    make, rate, length, truth = CASES[case]
    rng = np.random.default_rng(sum(map(ord, case)))
    hits: dict[str, list[bool]] = {term: [] for term in TERMS}
    ratios = []
    for _ in range(trials):
        curve = allan_curve(make(int(length * rate), rate, rng), rate)
        fit = fit_noise(curve)
        process = fit.gauss_markov
        ratios.append(fit["N"].value / WHITE)
        hits["N"].append(fit["N"].low <= WHITE <= fit["N"].high)
        for term in "BKR":
            if term in truth and term in fit.coefficients and process is None:
                hits[term].append(fit[term].low <= truth[term] <= fit[term].high)
        if process is not None and "Tc" in truth:
            hits["Tc"].append(process.time_low <= truth["Tc"] <= process.time_high)
            hits["σ"].append(process.deviation_low <= truth["σ"] <= process.deviation_high)
        if make is white:
            degrees = degrees_of_freedom(curve, np.maximum(fit.squares, 0.0))
            low, high = intervals(curve, degrees, 0.95)
            expected = WHITE / np.sqrt(curve.tau)
            hits["ADEV"] += ((low <= expected) & (expected <= high)).tolist()
    cells = "".join(f"{100 * np.mean(hits[t]):7.0f}" if hits[t] else f"{'–':>7}" for t in TERMS)
    off, scatter = 100 * (np.mean(ratios) - 1.0), 100 * np.std(ratios)
    return f"{case:<40}{cells}   {off:+6.2f} ± {scatter:5.2f}"


def healthy(count: int) -> list[str]:
    """What is found in logs that nothing is wrong with: one axis each."""
    rng = np.random.default_rng(2)
    found: Counter[str] = Counter()
    blamed = refused = 0
    for _ in range(count):
        length = float(np.exp(rng.uniform(np.log(90.0), np.log(7200.0))))
        rate = float(rng.choice([20.0, 50.0, 100.0])) if length < 1200.0 else 20.0
        b, k = (float(rng.choice([0.0, 1.0])) * x for x in (5e-4, 2e-5))
        n = int(length * rate)
        samples = static_noise(WHITE, b, k, rate, n, rng)
        if rng.random() < 0.25:
            samples += gauss_markov(float(rng.uniform(5.0, 100.0)), 1e-3, rate, n, rng)
        step = float(np.exp(rng.uniform(np.log(0.1), np.log(3.0)))) * WHITE * np.sqrt(rate)
        if rng.random() < 0.7:
            samples = np.round((samples + rng.uniform(0.0, step)) / step) * step
        log = Log(
            Path("healthy.csv"), (Channel("accelerometer", "x", samples),), Timing(rate, False)
        )
        try:
            kinds = {f.kind for f in characterise(log).findings}
        except InputError:
            refused += 1
            continue
        kinds -= HARMLESS
        blamed += bool(kinds)
        found.update(kinds)
    lines = [f"{count} healthy logs: refused {refused}, blamed for anything {blamed}"]
    return lines + [f"  {kind}: {times}" for kind, times in found.most_common()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--healthy", type=int, default=200)
    options = parser.parse_args()
    print(f"coverage of 95 % intervals in % ({options.trials} logs each), and N's error in %\n")
    print(f"{'':<40}" + "".join(f"{t:>7}" for t in TERMS) + "   N: mean ± scatter")
    for case in CASES:
        print(coverage(case, options.trials), flush=True)
    print()
    print("\n".join(healthy(options.healthy)))


if __name__ == "__main__":
    main()
