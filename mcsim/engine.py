"""The realizations of one point: to a count, or until the intervals are narrow enough."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.cases import Problem
from mcsim.cases.limits import may_wrap
from mcsim.cases.problem import Limit
from mcsim.scenario.error_names import UNITS
from mcsim.scenario.run import MonteCarlo
from mcsim.statistics import (
    KEPT,
    MOMENTS,
    Collector,
    Estimates,
    Rare,
    Reference,
    estimate,
    statistic_names,
)
from mcsim.statistics.collector import MOST_NETS, cell_size

Array = NDArray[np.float64]

#: Realizations simulated at once; small enough for prompt progress and interruption.
CHUNK = 4096
#: With fewer realizations the fitted coefficients of control variates would pretend
#: a precision that is not there; the plain estimator serves them.
FEWEST_CONTROLLED = 500
_FIRST_COUNT = 1000
#: Realizations that limits are looked for in, at most.
LOOKED_AT = 1000
#: Realizations beyond an abrupt limit that must be there before a control is trusted to
#: follow them, and events of a rare kind before they count as seen.
_SEEN = 50
#: Share of the variance from which on events that were hardly seen are remarked on.
_MATTERS = 0.1
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
_RMS = MOMENTS.index("rms")

Notes = dict[str, str]


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
    while True:
        collector = collect(problem, settings, count, limits, key, threads, told.begin())
        estimates = estimate(collector, settings.confidence, settings.resamples, bootstrap_key)
        if settings.precision is None:
            break
        wider = _widest(estimates) / settings.precision
        if wider <= 1.0:
            break
        if count >= settings.most_realizations:
            for i, name in enumerate(problem.error_names):
                if _relative_width(estimates)[i] > settings.precision:
                    _add(notes, name, f"precision not reached with {count} realizations")
            break
        # Widths shrink with the root of the count; a tenth more spares a further round.
        wanted = int(np.ceil(1.1 * count * wider**2))
        count = min(max(wanted, 2 * count), settings.most_realizations)
    _note_degenerate(problem, estimates, count, notes)
    _note_uncertain(problem, settings, estimates, count, notes)
    _note_not_finite(problem, estimates, notes)
    return _result(problem, estimates, count, notes, [*limits, *_without_effect(settings, count)])


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
    reference = _reference(problem, settings, count, limits)
    collector = Collector(count, reference, nets=settings.offsets == "sobol")
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
        tuple(limit.text for limit in limits if limit.text),
    )


def _add(notes: Notes, name: str, note: str) -> None:
    """One more note on an error."""
    notes[name] = f"{notes[name]}; {note}" if name in notes else note


def _linear_point(problem: Problem, settings: MonteCarlo, key: int) -> PointResult:
    """The linear model's answer, with a note where a Monte-Carlo run contradicts it."""
    estimates = linear_estimates(problem)
    checked = run_point(problem, settings.model_copy(update=_CHECK), key)
    names = statistic_names(problem.percentiles)
    low, high = checked.estimates.low, checked.estimates.high
    misses = np.abs(estimates.value - checked.estimates.value)
    with np.errstate(invalid="ignore"):
        # Means and percentiles may be zero: the RMS is what they are compared with.
        contradicted = ((estimates.value < low) | (estimates.value > high)) & (
            misses > CONTRADICTION * checked.estimates.value[:, [_RMS]]
        )
    notes: Notes = {}
    for name, row in zip(problem.error_names, contradicted, strict=True):
        if row.any():
            where = ", ".join(n for n, wrong in zip(names, row, strict=True) if wrong)
            _add(
                notes,
                name,
                "Monte Carlo contradicts the linear model by more than 1 % of the RMS: " + where,
            )
    _note_not_finite(problem, estimates, notes)
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


def _reference(
    problem: Problem, settings: MonteCarlo, count: int, limits: Sequence[Limit]
) -> Reference:
    """What the estimator may use: the method errors, and the linear model's moments."""
    method, rare = problem.method_errors(), _rare(problem)
    if settings.estimator == "plain" or count < FEWEST_CONTROLLED:
        return Reference(method, percentiles=problem.percentiles, rare=rare)
    linear, trusted = problem.linear, _trusted(problem, count, limits)
    return Reference(
        method,
        np.where(trusted, linear.control_mean, np.nan),
        np.where(trusted, linear.control_second_moment, np.nan),
        problem.percentiles,
        rare,
    )


def _rare(problem: Problem) -> Rare | None:
    """Spikes and flips of angles, if there are any."""
    linear = problem.linear
    none = np.zeros(len(problem.error_names))
    spikes = linear.spike_events if len(linear.spike_events) else none
    flips = linear.flips if len(linear.flips) else none
    if not (np.any(spikes) or np.any(flips)):
        return None
    variance = linear.spike_variance() + flips * np.pi**2
    return Rare(variance, np.where(flips > 0.0, flips, spikes))


def _trusted(problem: Problem, count: int, limits: Sequence[Limit]) -> NDArray[np.bool_]:
    """Whether the linear model is a control of each error.

    Not where a realization may do, and so few do that the run would not show it, what no linear
    model follows: an angle wraps, or a range is reached.
    """
    trusted = np.ones(len(problem.error_names), bool)
    for limit in limits:
        hardly = limit.looked_at and limit.reached * count < _SEEN * limit.looked_at
        if limit.abrupt and not limit.certain and hardly:
            trusted[:] = False
    method, spread = problem.method_errors(), problem.linear.spread
    for i, name in enumerate(problem.error_names):
        if UNITS.get(name) == "deg" and may_wrap(method[i], spread[i]):
            trusted[i] = False
    return trusted


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


def _note_not_finite(problem: Problem, estimates: Estimates, notes: Notes) -> None:
    """Say why numbers are missing where nothing else does."""
    numbers = np.concatenate([estimates.value, estimates.low, estimates.high], axis=1)
    for name, row in zip(problem.error_names, numbers, strict=True):
        if not np.all(np.isfinite(row)):
            notes.setdefault(name, "beyond the range of numbers: the inputs are too large or small")


def _note_degenerate(problem: Problem, estimates: Estimates, count: int, notes: Notes) -> None:
    linear = np.sum(list(problem.linear.variances.values()), axis=0)
    for i, (name, degenerate) in enumerate(
        zip(problem.error_names, estimates.degenerate, strict=True)
    ):
        if count == 1:
            _add(notes, name, "one realization: no scatter and no interval follow from it")
        elif degenerate and linear[i] > 0.0:
            _add(notes, name, "all realizations are equal: what disturbs this error does not show")
        elif degenerate:
            _add(notes, name, "all realizations are equal: nothing disturbs this error")


def _without_effect(settings: MonteCarlo, count: int) -> Iterator[Limit]:
    """What is written and does nothing with so few realizations."""
    written = settings.model_fields_set
    controlled = "estimator" in written and settings.estimator == "control_variate"
    if controlled and count < FEWEST_CONTROLLED:
        yield Limit(
            f"estimator: control variates take {FEWEST_CONTROLLED} realizations; the plain "
            "estimator served"
        )
    if settings.offsets == "sobol" and cell_size(count, nets=True) == 1:
        yield Limit(
            f"offsets: Sobol points take more than {MOST_NETS} realizations; these are random"
        )


def _note_uncertain(
    problem: Problem, settings: MonteCarlo, estimates: Estimates, count: int, notes: Notes
) -> None:
    """What the intervals rest on where the realizations alone do not tell."""
    rare = _rare(problem)
    share = seen = np.zeros(len(problem.error_names))
    if rare is not None:
        whole = np.maximum(np.sum(list(problem.linear.variances.values()), axis=0), 1e-300)
        share, seen = problem.linear.spike_variance() / whole, rare.events * count
    controlled = settings.estimator == "control_variate" and count >= FEWEST_CONTROLLED
    scatter = "what the linear model leaves" if controlled else "the scatter"
    for i, name in enumerate(problem.error_names):
        if count > 1 and share[i] > _MATTERS and seen[i] < _SEEN:
            _add(
                notes,
                name,
                f"spikes make {share[i]:.0%} of the variance by the linear model, and only "
                f"{seen[i]:.2g} are expected among {count:,} realizations: the intervals allow "
                "for those not seen",
            )
        elif estimates.few is not None and estimates.few[i]:
            _add(
                notes,
                name,
                f"few realizations carry most of {scatter}: the intervals are widened for it",
            )
        if count > 1 and estimates.unbounded and not estimates.degenerate[i]:
            _add(
                notes,
                name,
                f"{count} realizations do not bound {', '.join(estimates.unbounded)} at "
                f"{settings.confidence:.3g} sigma: the interval ends at an extreme realization",
            )
