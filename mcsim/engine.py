"""The realizations of one point: to a count, or until the intervals are narrow enough."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.estimation import LOOKED_AT, limit_texts, reference, takes_nets
from mcsim.remarks import (
    Notes,
    add_note,
    note_degenerate,
    note_not_finite,
    note_uncertain,
    without_effect,
)
from mcsim.scenario.run import MonteCarlo
from mcsim.simulation.problem import Limit, Problem
from mcsim.statistics import KEPT, Collector, Distribution, Estimates, estimate, estimated

Array = NDArray[np.float64]

#: Realizations simulated at once; small enough for prompt progress and interruption.
CHUNK = 4096
_FIRST_COUNT = 1000
#: The run that a linear answer is held against, and by how much it may miss it.
_CHECK = {
    "estimator": "control_variate",
    "realizations": 1000,
    "precision": None,
    "offsets": "random",
    "confidence": 3.0,  # at 95 %, two of forty statistics would miss it by chance
    "resamples": 1000,
}
CONTRADICTION = 0.01


@dataclass(frozen=True)
class PointResult:
    """Estimates of one point, its method errors (e,), and remarks per error and on the point.

    Everything in SI units; ``notes`` maps an error's label to why a value is missing,
    degenerate or uncertain, ``variances`` a source of disturbance to its share (e,) of the linear
    model's variance; ``limits`` are the bounds of sensors and models that the point reaches.
    """

    estimates: Estimates
    method: Array
    realizations: int
    notes: Notes
    variances: Mapping[str, Array]
    limits: tuple[str, ...] = ()


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
    count = settings.realizations or min(_FIRST_COUNT, settings.most_realizations)
    limits = problem.limits(key, min(count, LOOKED_AT))
    notes: Notes = {}
    told = _Told(progress)
    statistics = estimated(problem.percentiles)
    while True:
        collector = collect(problem, settings, count, limits, key, threads, told.begin())
        estimates = estimate(
            collector, settings.confidence, settings.resamples, bootstrap_key, statistics
        )
        if settings.precision is None:
            break
        wider = _widest(estimates) / settings.precision
        if wider <= 1.0:
            break
        if count >= settings.most_realizations:
            for i, name in enumerate(problem.error_names):
                if _relative_width(estimates)[i] > settings.precision:
                    add_note(notes, name, f"precision not reached with {count} realizations")
            break
        # Widths shrink with the root of the count; a tenth more spares a further round.
        wanted = int(np.ceil(1.1 * count * wider**2))
        count = min(max(wanted, 2 * count), settings.most_realizations)
    note_degenerate(problem, estimates, count, notes)
    note_uncertain(problem, settings, estimates, count, notes)
    note_not_finite(problem, estimates, notes)
    return _result(
        problem,
        estimates,
        count,
        notes,
        [*limits, *without_effect(problem, settings, count, limits)],
    )


def collect(
    problem: Problem,
    settings: MonteCarlo,
    count: int,
    limits: Sequence[Limit],
    key: int,
    threads: int = 1,
    progress: Callable[[int], None] = lambda _: None,
) -> Collector:
    """``count`` realizations of a problem that reaches ``limits``, ready for estimates."""
    nets = takes_nets(problem, settings, limits)
    collector = Collector(count, reference(problem, settings, count, limits), nets)
    _fill(collector, problem, key, threads, progress)
    return collector


class _Told:
    """Progress of a run whose realizations are begun again when it goes on: told once each."""

    def __init__(self, progress: Callable[[int], None]) -> None:
        self._progress, self._most = progress, 0
        self._lock = threading.Lock()

    def begin(self) -> Callable[[int], None]:
        """Hears the realizations of one more round."""
        done = 0

        def advance(finished: int) -> None:
            nonlocal done
            with self._lock:
                done += finished
                new = done - self._most
                self._most = max(self._most, done)
            if new > 0:
                self._progress(new)

        return advance


def _result(
    problem: Problem, estimates: Estimates, count: int, notes: Notes, limits: Sequence[Limit]
) -> PointResult:
    """With what is undefined said before anything else."""
    return PointResult(
        estimates,
        problem.method_errors(),
        count,
        {**notes, **problem.missing},
        problem.linear.variances,
        limit_texts(limits),
    )


def _linear_point(problem: Problem, settings: MonteCarlo, key: int) -> PointResult:
    """The linear model's answer, with a note where a Monte-Carlo run contradicts it."""
    estimates = linear_estimates(problem)
    checked = run_point(problem, settings.model_copy(update=_CHECK), key)
    names = estimates.statistics
    low, high = checked.estimates.low, checked.estimates.high
    misses = np.abs(estimates.value - checked.estimates.value)
    with np.errstate(invalid="ignore"):
        # Means and percentiles may be zero: the RMS is what they are compared with.
        contradicted = ((estimates.value < low) | (estimates.value > high)) & (
            misses > CONTRADICTION * checked.estimates.of("rms").value[:, None]
        )
    notes: Notes = {}
    for name, row in zip(problem.error_names, contradicted, strict=True):
        if row.any():
            where = ", ".join(n for n, wrong in zip(names, row, strict=True) if wrong)
            add_note(
                notes,
                name,
                "Monte Carlo contradicts the linear model by more than 1 % of the RMS: " + where,
            )
    note_not_finite(problem, estimates, notes)
    return PointResult(
        estimates,
        problem.method_errors(),
        0,
        {**notes, **problem.missing},
        problem.linear.variances,
        checked.limits,
    )


def linear_estimates(problem: Problem) -> Estimates:
    """What the linear model says of every statistic; the intervals have no width."""
    linear, method = problem.linear, problem.method_errors()
    std = np.sqrt(np.maximum(linear.second_moment - linear.mean**2, 0.0))
    distribution = Distribution(method + linear.mean, std, linear.quantiles)
    statistics = estimated(problem.percentiles)
    value = np.stack([s.by_linear_model(distribution) for s in statistics.values()], axis=1)
    value[np.isnan(method)] = np.nan
    none = np.zeros(len(method), bool)
    return Estimates(tuple(statistics), value, value.copy(), value.copy(), none)


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
    rms = estimates.of("rms")
    value, half = rms.value, 0.5 * (rms.high - rms.low)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(value > 0.0, half / value, 0.0)


def _widest(estimates: Estimates) -> float:
    widths = _relative_width(estimates)
    return float(np.nanmax(widths)) if np.any(np.isfinite(widths)) else 0.0
