"""What repeating a run does for its velocity: claims V5 and V6 of the velocity paper.

The errors of M runs of a group are a shared part, drawn once (calibration, tilt, the noise of the
one rest), and each run's own (noise while moving, the time base).  The mean of the runs keeps the
first and has the second divided by sqrt(M).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.engine import point_key
from mcsim.papers.shipped import velocity_sensor
from mcsim.systems.velocity.linear import NOISE, TIME_BASE
from mcsim.systems.velocity.problem import VelocityProblem
from mcsim.systems.velocity.sources import acting_alone

Array = NDArray[np.float64]

#: What errs in the time base, and what the scenario's key calls it.
TIME_ERRORS = {"intervals err": "independent", "time stamps err": "stamps"}
#: Every source of the velocity's error, and what the source says of averaging: its Section 5
#: names the time base and the noise as what averages out, calibration and tilt as what stays.
AVERAGES_OUT: dict[str, bool | None] = {
    "calibration matrix": False,
    "zero bias": False,
    "tilt change": False,
    "gravity": None,
    "noise at rest": True,
    NOISE: True,
    TIME_BASE: True,
}
#: Groups simulated at once: what that takes in memory does not grow with their number.
_AT_ONCE = 1000
_CONFIDENCE = 0.95


@dataclass(frozen=True)
class Reduction:
    """How much smaller the error of the mean is than that of the worst of its runs.

    ``reductions`` (g,) are ``1 - |error of the mean| / largest |error|`` of simulated groups.
    """

    sensor: str
    sources: str
    time_errors: str
    shared: float
    own: float
    reductions: Array

    def share_above(self, least: float) -> tuple[float, float, float]:
        """Share of groups whose reduction exceeds ``least``, with its exact 95 % interval."""
        return share_with_interval(int(np.sum(self.reductions > least)), len(self.reductions))


def share_with_interval(hits: int, count: int) -> tuple[float, float, float]:
    """A share and its 95 % interval of Clopper and Pearson, exact for binomial counts."""
    from scipy.special import betaincinv

    tail = 0.5 * (1.0 - _CONFIDENCE)
    low = float(betaincinv(hits, count - hits + 1, tail)) if hits else 0.0
    high = float(betaincinv(hits + 1, count - hits, 1.0 - tail)) if hits < count else 1.0
    return hits / count, low, high


def reductions_of(errors: Array) -> Array:
    """``1 - |mean| / max |.|`` of errors (runs, groups) over the runs."""
    return np.asarray(1.0 - np.abs(errors.mean(axis=0)) / np.abs(errors).max(axis=0), float)


def end_errors(problem: VelocityProblem, key: int, groups: int) -> Array:
    """Errors (runs, groups) of all runs at the end (m/s)."""
    parts = [
        problem.velocities(key, first, min(_AT_ONCE, groups - first))[-1]
        for first in range(0, groups, _AT_ONCE)
    ]
    return np.concatenate(parts, axis=1) - problem.truth[-1]


def sensor_problem(name: str, time_errors: str) -> tuple[VelocityProblem, int]:
    """The problem of a sensor, errors at the end alone, and its key of random numbers."""
    _, model = velocity_sensor(name, sensor__time_errors=TIME_ERRORS[time_errors])
    model = model.model_copy(update={"instants": None})
    return VelocityProblem.from_model(model), point_key(model.monte_carlo, ())


def without_shared(problem: VelocityProblem) -> VelocityProblem:
    """The problem without what its runs share: neither calibration nor tilt err."""
    return replace(problem, uncertainties=np.zeros_like(problem.uncertainties))


def reductions(name: str, groups: int) -> Iterator[Reduction]:
    """Claim V5 for a sensor: with all errors, and with each run's own alone."""
    for time_errors in TIME_ERRORS:
        whole, key = sensor_problem(name, time_errors)
        for sources, problem in (("all", whole), ("each run's own", without_shared(whole))):
            errors = end_errors(problem, key, groups)
            if sources != "all":
                errors = errors - float(problem.method_errors()[0])
            shared, own = deviations(problem)
            yield Reduction(name.upper(), sources, time_errors, shared, own, reductions_of(errors))


def deviations(problem: VelocityProblem) -> tuple[float, float]:
    """Deviations (m/s) at the end of what runs share and of each run's own, linear model."""
    of_group, of_steps = problem.weights.group_variances(), problem.weights.step_variances()
    shared, own = (math.sqrt(sum(float(v[-1]) for v in of.values())) for of in (of_group, of_steps))
    return shared, own


def reductions_of_normals(ratio: float, runs: int, groups: int, seed: int) -> Array:
    """Reductions (groups,) where all is normal; ``ratio`` is shared by own deviation."""
    draw = np.random.Generator(np.random.PCG64(seed))
    own = draw.standard_normal((runs, groups))
    return reductions_of(own + ratio * draw.standard_normal(groups))


@dataclass(frozen=True)
class Repeated:
    """One source's uncertainty of the velocity at the end (m/s), over the number of runs M.

    ``simulated`` and ``linear`` (k,) at ``runs`` (k,); ``lasting`` is what no repetition takes
    away.
    """

    source: str
    averages_out: bool | None
    runs: NDArray[np.int64]
    linear: Array
    simulated: Array
    lasting: float


def repeated(name: str, time_errors: str, runs: tuple[int, ...], groups: int) -> list[Repeated]:
    """Claim V6 for a sensor: each source alone, then all together, for means of ``runs`` runs."""
    problem, key = sensor_problem(name, time_errors)
    problem = replace(problem, runs=max(runs))
    weights = problem.weights
    own = {source: float(v[-1]) for source, v in weights.step_variances().items()}
    shared = {source: float(v[-1]) for source, v in weights.group_variances().items()}
    counts = np.array(runs)
    found = []
    for source, averages in AVERAGES_OUT.items():
        variance = shared.get(source, 0.0) + own.get(source, 0.0) / counts
        means = _means(acting_alone(problem, source), key, counts, groups)
        lasting = math.sqrt(shared.get(source, 0.0))
        linear = np.sqrt(np.broadcast_to(variance, counts.shape))
        found.append(Repeated(source, averages, counts, linear, means, lasting))
    total = sum(shared.values()) + sum(own.values()) / counts
    means = _means(problem, key, counts, groups)
    lasting = math.sqrt(sum(shared.values()))
    return [*found, Repeated("all together", None, counts, np.sqrt(total), means, lasting)]


def _means(problem: VelocityProblem, key: int, counts: NDArray[np.int64], groups: int) -> Array:
    """Deviations (k,) over groups of the mean of their first ``counts`` (k,) runs."""
    errors = end_errors(problem, key, groups)
    return np.array([errors[:count].mean(axis=0).std() for count in counts])
