"""The realizations of one point: to a count, or until the intervals are narrow enough."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.cases import Problem
from mcsim.scenario.run import MonteCarlo
from mcsim.statistics import KEPT, MOMENTS, Collector, Estimates, Reference, estimate

Array = NDArray[np.float64]

#: Realizations simulated at once; small enough for prompt progress and interruption.
CHUNK = 4096
#: With fewer realizations the fitted coefficients of control variates would pretend
#: a precision that is not there; the plain estimator serves them.
FEWEST_CONTROLLED = 100
_FIRST_COUNT = 1000
#: The run that a linear answer is held against, and by how much it may miss it.
_CHECK = {"estimator": "control_variate", "realizations": 1000, "precision": None}
CONTRADICTION = 0.01
_RMS = MOMENTS.index("rms")


@dataclass(frozen=True)
class PointResult:
    """Estimates of one point, its method errors (e,), and remarks per error.

    Everything in SI units; ``notes`` maps an error's label to why a value is missing
    or degenerate, ``variances`` a source of disturbance to its share (e,) of the linear
    model's variance.
    """

    estimates: Estimates
    method: Array
    realizations: int
    notes: dict[str, str]
    variances: Mapping[str, Array]


def random_key(seed: int, *parts: str) -> int:
    """A 64-bit key from the seed and what distinguishes a use of it."""
    text = "\x1f".join([str(seed), *parts])
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little")


def point_key(settings: MonteCarlo, identities: Iterable[str]) -> int:
    """The key of a point's random numbers: the seed and the point's own coordinates."""
    own = () if settings.common_random_numbers else sorted(identities)
    return random_key(settings.seed, "realizations", *own)


def run_point(
    problem: Problem,
    settings: MonteCarlo,
    key: int,
    threads: int = 1,
    progress: Callable[[int], None] = lambda _: None,
) -> PointResult:
    """Simulate one point and estimate its statistics.

    ``threads`` share the realizations; the result does not depend on it.
    ``progress`` is called with the number of realizations just finished.
    """
    if settings.estimator == "linear":
        return _linear_point(problem, settings, key)
    bootstrap_key = random_key(settings.seed, "bootstrap")
    count = settings.realizations or min(_FIRST_COUNT, settings.max_realizations)
    notes = dict(problem.missing)
    reference = _reference(problem, settings, count)
    while True:
        collector = Collector(count, reference, nets=settings.offsets == "sobol")
        _fill(collector, problem, key, threads, progress)
        estimates = estimate(collector, settings.confidence, settings.resamples, bootstrap_key)
        if settings.precision is None:
            break
        wider = _widest(estimates) / settings.precision
        if wider <= 1.0:
            break
        if count >= settings.max_realizations:
            for i, name in enumerate(problem.error_names):
                if _relative_width(estimates)[i] > settings.precision:
                    notes.setdefault(name, f"precision not reached with {count} realizations")
            break
        # Widths shrink with the root of the count; a tenth more spares a further round.
        wanted = int(np.ceil(1.1 * count * wider**2))
        count = min(max(wanted, 2 * count), settings.max_realizations)
    _note_degenerate(problem, estimates, count, notes)
    _note_not_finite(problem, estimates, notes)
    return PointResult(estimates, problem.method_errors(), count, notes, problem.linear.variances)


def _linear_point(problem: Problem, settings: MonteCarlo, key: int) -> PointResult:
    """The linear model's answer, with a note where a Monte-Carlo run contradicts it."""
    estimates = linear_estimates(problem)
    checked = run_point(problem, settings.model_copy(update=_CHECK), key)
    notes = dict(problem.missing)
    for i, name in enumerate(problem.error_names):
        linear, simulated = estimates.value[i, _RMS], checked.estimates.value[i, _RMS]
        low, high = checked.estimates.low[i, _RMS], checked.estimates.high[i, _RMS]
        if not low <= linear <= high and abs(linear / simulated - 1.0) > CONTRADICTION:
            notes[name] = "Monte Carlo contradicts the linear model by more than 1 %"
    _note_not_finite(problem, estimates, notes)
    return PointResult(estimates, problem.method_errors(), 0, notes, problem.linear.variances)


def linear_estimates(problem: Problem) -> Estimates:
    """What the linear model says of every statistic; the intervals have no width."""
    from scipy.special import ndtri

    linear, method = problem.linear, problem.method_errors()
    percentiles = problem.percentiles
    std = np.sqrt(np.maximum(linear.second_moment - linear.mean**2, 0.0))
    mean = method + linear.mean
    value = np.stack(
        [mean, std, np.hypot(mean, std), *(mean + std * ndtri(p) for p in percentiles)], axis=1
    )
    for row, quantile in linear.quantiles.items():
        value[row, len(MOMENTS) :] = [quantile(p) for p in percentiles]
    value[np.isnan(method)] = np.nan
    return Estimates(value, value.copy(), value.copy(), np.zeros(len(method), bool))


def _reference(problem: Problem, settings: MonteCarlo, count: int) -> Reference:
    """What the estimator may use: the method errors, and the linear model's moments."""
    method = problem.method_errors()
    if settings.estimator == "plain" or count < FEWEST_CONTROLLED:
        return Reference(method, percentiles=problem.percentiles)
    linear = problem.linear
    return Reference(method, linear.control_mean, linear.control_second_moment, problem.percentiles)


def _fill(
    collector: Collector,
    problem: Problem,
    key: int,
    threads: int,
    progress: Callable[[int], None],
) -> None:
    """Simulate all realizations of a collector, in chunks over threads."""
    count = collector.count
    chunk = max(CHUNK, collector.cell)
    with_controls = collector.reference.mean is not None
    net = collector.cell if collector.nets else 0

    def simulate(start: int) -> None:
        size = min(chunk, count - start)
        sample = problem.simulate(key, start, size, controls=with_controls, net=net)
        collector.add(start, sample.errors, sample.controls)
        progress(size)

    # The kept realizations come first: percentiles of the others are sought near theirs.
    for part in (range(0, min(count, KEPT), chunk), range(KEPT, count, chunk)):
        if threads == 1 or len(part) <= 1:
            for start in part:
                simulate(start)
            continue
        with ThreadPoolExecutor(threads) as pool:
            try:
                for _ in pool.map(simulate, part):
                    pass
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise


def _relative_width(estimates: Estimates) -> Array:
    """Half-width of each RMS interval relative to the RMS; zero where there is no scatter."""
    value = estimates.value[:, _RMS]
    half = 0.5 * (estimates.high[:, _RMS] - estimates.low[:, _RMS])
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(value > 0.0, half / value, 0.0)


def _widest(estimates: Estimates) -> float:
    widths = _relative_width(estimates)
    return float(np.nanmax(widths)) if np.any(np.isfinite(widths)) else 0.0


def _note_not_finite(problem: Problem, estimates: Estimates, notes: dict[str, str]) -> None:
    """Say why numbers are missing where nothing else does."""
    numbers = np.concatenate([estimates.value, estimates.low, estimates.high], axis=1)
    for name, row in zip(problem.error_names, numbers, strict=True):
        if not np.all(np.isfinite(row)):
            notes.setdefault(name, "beyond the range of numbers: the inputs are too large or small")


def _note_degenerate(
    problem: Problem, estimates: Estimates, count: int, notes: dict[str, str]
) -> None:
    for name, degenerate in zip(problem.error_names, estimates.degenerate, strict=True):
        if count == 1:
            notes.setdefault(name, "one realization: no scatter and no interval follow from it")
        elif degenerate:
            notes.setdefault(name, "all realizations are equal: nothing disturbs this error")
