"""How often 95 % intervals of `mcsim calibrate` and `mcsim linearity` hold the truth.

    python -m benchmarks.calibration [--trials 2000]

Six-position tests of one known sensor, the samples' noise 3.8, 3.0 and 4.9 mg. ``k`` is
the median coverage factor, ``width`` the median half-width of the interval over that of a
normal distribution with the errors' true deviation: 1 would be an interval that knew it.
Arbitrary positions are at random, weighted ones have two that are held badly; their trials are a
fifth as many.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from mcsim.calibration import (
    SixPositionFit,
    SixPositions,
    calibrate,
    calibrate_by_norm,
    calibrate_weighted,
    linearity,
    simulate_rest_positions,
)
from mcsim.calibration.estimate import NORMAL_FACTOR, Estimate
from mcsim.calibration.norm import NAMES
from mcsim.calibration.scatter import SampleScatter, own_variances, sample_scatter
from mcsim.calibration.six_positions import TRUE
from mcsim.errors import InputError

Array = NDArray[np.float64]

CORRECTION = np.array([[0.98, 0.008, -0.019], [0.002, 1.02, 0.01], [-0.004, 0.004, 1.008]])
BIAS = np.array([0.047, -0.018, -0.146])
NOISE = np.array([3.8e-3, 3.0e-3, 4.9e-3])
#: 0.1 ° in each direction.
ALIGNMENT = 1.75e-3
#: Elements of L on and off its diagonal, and those of B.
GROUPS = {"diagonal": [0, 4, 8], "off it": [1, 2, 3, 5, 6, 7], "bias": [9, 10, 11]}


@dataclass(frozen=True)
class Bench:
    """A six-position test: samples per position, repetitions, and what disturbs it.

    ``alignment`` (rad) is drawn anew at every position, about the axes of weight ``about``;
    ``fixture`` (rad) once for all repetitions; ``turn_on`` (g) is a bias drawn at each
    repetition; samples are a first-order process of lag-one correlation ``memory``.
    """

    samples: int
    repetitions: int = 1
    alignment: float = 0.0
    about: tuple[float, float, float] = (1.0, 1.0, 1.0)
    fixture: float = 0.0
    turn_on: float = 0.0
    memory: float | None = None

    def simulate(self, generator: np.random.Generator) -> SixPositions:
        shape = (self.repetitions, 6, 3)
        angles = self.alignment * np.array(self.about) * generator.standard_normal(shape)
        angles = angles + self.fixture * generator.standard_normal((6, 3))
        true = TRUE + np.cross(np.broadcast_to(TRUE, shape), angles)
        true /= np.linalg.norm(true, axis=-1, keepdims=True)
        means = true @ np.linalg.inv(CORRECTION).T + BIAS
        means = means + self.turn_on * generator.standard_normal((self.repetitions, 1, 3))
        counts = np.full(shape[:2], self.samples)
        if self.memory is not None:
            noise = self._correlated(generator)
            means = means + noise.mean(axis=2)
            return SixPositions(means, sample_scatter(list(noise.reshape(-1, *noise.shape[2:]))),
                                counts)  # fmt: skip
        means = means + NOISE / np.sqrt(self.samples) * generator.standard_normal(shape)
        if self.samples == 1:
            return SixPositions(means, None, counts)
        freedom = float(counts.size * (self.samples - 1))
        found = NOISE * np.sqrt(generator.chisquare(freedom, 3) / freedom)
        scatter = SampleScatter(found, np.ones(3), np.full(3, freedom))
        return SixPositions(means, scatter, counts)

    def _correlated(self, generator: np.random.Generator) -> Array:
        phi = float(self.memory or 0.0)
        settle = int(8.0 / (1.0 - phi))
        shape = (self.repetitions, 6, settle + self.samples, 3)
        gain = np.sqrt(1.0 - phi**2)
        process = lfilter([gain], [1.0, -phi], generator.standard_normal(shape), axis=2)
        return np.asarray(NOISE * process[:, :, settle:], float)


BENCHES = {
    "1000 samples per position": Bench(1000),
    "  and alignment of 0.005 ° (near the noise)": Bench(1000, alignment=ALIGNMENT / 20),
    "  and alignment of 0.02 °": Bench(1000, alignment=ALIGNMENT / 5),
    "  and alignment of 0.1 ° (dominates)": Bench(1000, alignment=ALIGNMENT),
    "  the same about one axis only": Bench(1000, alignment=ALIGNMENT, about=(1, 0, 0)),
    "one row per position": Bench(1),
    "  and alignment of 1 ° (dominates)": Bench(1, alignment=10 * ALIGNMENT),
    **{
        f"{text}, {n} repetitions": Bench(samples, n, alignment)
        for n in (2, 3, 5)
        for text, samples, alignment in (
            ("1000 samples", 1000, 0.0),
            ("1000 samples, 0.1 °", 1000, ALIGNMENT),
            ("one row", 1, 0.0),
        )
    },
    **{
        f"{text}, {n} repetitions": Bench(1000, n, alignment, fixture=fixture, turn_on=turn_on)
        for n in (2, 3, 5)
        for text, alignment, fixture, turn_on in (
            ("fixture 0.1 °", 0.0, ALIGNMENT, 0.0),
            ("fixture and alignment 0.1 °", ALIGNMENT, ALIGNMENT, 0.0),
            ("turn-on bias 1 mg", 0.0, 0.0, 1e-3),
            ("turn-on bias 1 mg, 0.1 °", ALIGNMENT, 0.0, 1e-3),
        )
    },
    "10 white samples": Bench(10, memory=0.0),
    **{
        f"300 samples correlated over {1 / (1 - phi):.0f}": Bench(300, memory=phi)
        for phi in (0.5, 0.9, 0.98, 0.995)
    },
    "300 samples correlated over 10, 2 repetitions": Bench(300, 2, memory=0.9),
}
#: Shaker tests: whether 2 mg of noise or a bend of 5000 ppm of full scale makes the residuals.
SHAKERS = {"points scatter": (2e-3, 0.0), "points bend": (0.0, 0.05), "both": (2e-3, 0.05)}


def six_positions(name: str, bench: Bench, trials: int) -> str:
    """One line: coverage, k and width for the three groups of parameters."""
    generator = np.random.default_rng(5)
    truth = np.append(CORRECTION, BIAS)
    errors, halves, factors = (np.empty((trials, len(truth))) for _ in range(3))
    normal = np.empty((trials, len(truth)))
    for i in range(trials):
        named = calibrate(bench.simulate(generator)).estimates()
        found = [e for key, e in named.items() if key[0] in "lb"]
        errors[i] = np.abs([e.value for e in found] - truth)
        factors[i] = [e.coverage_factor for e in found]
        halves[i] = factors[i] * [e.uncertainty for e in found]
        normal[i] = [NORMAL_FACTOR * e.normal_uncertainty for e in found]
    inside = 100.0 * np.mean(errors <= halves, axis=0)
    width = np.median(halves, axis=0) / (NORMAL_FACTOR * np.sqrt(np.mean(errors**2, axis=0)))
    assert np.allclose(normal, halves)
    cells = [
        f"{inside[g].min():6.1f} {inside[g].max():6.1f} {np.median(factors[:, g]):6.2f} "
        f"{np.median(width[g]):5.2f}"
        for g in GROUPS.values()
    ]
    return f"{name:<48}" + "  ".join(cells)


def norms(count: int, samples: int, between: float, trials: int) -> str:
    """One line: lowest, mean and highest coverage of the nine unknowns, k and width, refused."""
    values, vectors = np.linalg.eigh(CORRECTION.T @ CORRECTION)
    symmetric = (vectors * np.sqrt(values)) @ vectors.T
    truth = np.append(symmetric[np.triu_indices(3)], BIAS)
    generator = np.random.default_rng(8)
    inside, factors, halves, errors, refused = [], [], [], [], 0
    for _ in range(trials):
        test = simulate_rest_positions(CORRECTION, BIAS, NOISE, count, samples, between, generator)
        try:
            named = calibrate_by_norm(test).estimates()
        except InputError:
            refused += 1
            continue
        found = [named[name] for name in NAMES]
        errors.append(np.abs([e.value for e in found] - truth))
        factors.append([e.coverage_factor for e in found])
        halves.append([e.coverage_factor * e.uncertainty for e in found])
        inside.append(errors[-1] <= halves[-1])
    held = 100.0 * np.mean(inside, axis=0)
    name = f"{count} of {samples} samples, {1e3 * between:g} mg between them"
    return (
        f"{name:<48}{held.min():6.1f} {held.mean():6.1f} {held.max():6.1f}"
        f"{np.median(factors):8.2f}{100.0 * refused / trials:12.1f}"
    )


def badly_held(alignment: float, generator: np.random.Generator) -> SixPositions:
    """100 samples each; +x has ten, -z five times the noise of the others."""
    tilts = np.cross(TRUE, alignment * generator.standard_normal((6, 3)))
    outputs = (TRUE + tilts) @ np.linalg.inv(CORRECTION).T + BIAS
    rows = [
        mean + by * NOISE * generator.standard_normal((100, 3))
        for mean, by in zip(outputs, (10.0, 1.0, 1.0, 1.0, 1.0, 5.0), strict=True)
    ]
    means, scatter = np.array([[r.mean(axis=0) for r in rows]]), sample_scatter(rows)
    own = own_variances(rows, scatter, means.shape)
    return SixPositions(means, scatter, np.full((1, 6), 100), own)


def weighted(
    name: str, solve: Callable[[SixPositions], SixPositionFit], alignment: float, trials: int
) -> str:
    """One line: lowest, mean and highest coverage of L and B, and the RMS error of B in mg."""
    generator = np.random.default_rng(9)
    truth, inside, errors = np.append(CORRECTION, BIAS), [], []
    for _ in range(trials):
        named = solve(badly_held(alignment, generator)).estimates()
        found = [e for key, e in named.items() if key[0] in "lb"]
        errors.append(np.array([e.value for e in found]) - truth)
        halves = [e.coverage_factor * e.uncertainty for e in found]
        inside.append(np.abs(errors[-1]) <= halves)
    held = 100.0 * np.mean(inside, axis=0)
    bias = 1e3 * float(np.sqrt(np.mean(np.array(errors)[:, 9:] ** 2)))
    return f"{name:<48}{held.min():6.1f} {held.mean():6.1f} {held.max():6.1f}{bias:12.3f}"


def shaker(name: str, noise: float, bend: float, trials: int) -> str:
    """One line: coverage of slope and offset, and how often the points are said to bend."""
    generator = np.random.default_rng(6)
    reference = np.linspace(0.1, 1.0, 10)
    curve = 0.95 * reference + 0.01 + bend * reference**3
    centred = reference - reference.mean()
    slope = float(centred @ curve / (centred @ centred))
    offset = float(curve.mean() - slope * reference.mean())
    held, bends = [], 0
    for _ in range(trials):
        measured = curve + noise * generator.standard_normal(len(reference))
        fit = linearity(reference, measured, 3.0)
        found: list[tuple[Estimate, float]] = [
            (fit.slope_estimate, slope),
            (fit.offset_estimate, offset),
        ]
        held.append([abs(e.value - t) <= e.coverage_factor * e.uncertainty for e, t in found])
        bends += fit.bends
    inside = 100.0 * np.mean(held, axis=0)
    return f"{name:<20}{inside[0]:8.1f}{inside[1]:8.1f}{100.0 * bends / trials:18.1f}"


def main(tell: Callable[[str], None] = print) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=2000)
    trials = parser.parse_args().trials
    error = 100.0 * np.sqrt(0.05 * 0.95 / trials)
    tell(f"coverage of 95 % intervals in % of {trials} tests (± {error:.1f}):")
    tell("lowest and highest of a group's parameters, median k, median width\n")
    tell(" " * 48 + "  ".join(f"{name:^26}" for name in GROUPS))
    for name, bench in BENCHES.items():
        tell(six_positions(name, bench, trials))
    few = max(1, trials // 5)
    tell("\narbitrary positions at rest: lowest, mean, highest; median k; refused in %\n")
    for count in (10, 12, 18, 24, 50):
        for samples, between in ((1, 0.0), (100, 0.0), (100, 1e-3)):
            tell(norms(count, samples, between, few))
    tell(
        "\nsix positions of which two are held badly: lowest, mean, highest; RMS error of B in mg\n"
    )
    for alignment in (0.0, ALIGNMENT):
        for name, solve in {"without weights": calibrate, "weighted": calibrate_weighted}.items():
            told = f"{name}, alignment {np.rad2deg(alignment):.1f} °"
            tell(weighted(told, solve, alignment, few))
    tell("\nshaker test, 10 points: coverage in % of the line over these amplitudes\n")
    tell(f"{'':<20}{'slope':>8}{'offset':>8}{'said to bend, %':>18}")
    for name, (noise, bend) in SHAKERS.items():
        tell(shaker(name, noise, bend, trials))


if __name__ == "__main__":
    main()
