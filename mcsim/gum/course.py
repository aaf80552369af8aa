"""Uncertainty of the velocity over time: by summing steps, and by Monte Carlo, by source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.engine import point_key
from mcsim.estimation import LOOKED_AT, limit_texts
from mcsim.gum.budget import known_of
from mcsim.gum.propagation import step_variances, summed
from mcsim.systems.velocity.linear import calibration_pushes
from mcsim.systems.velocity.problem import VelocityProblem
from mcsim.systems.velocity.scenario import VelocityScenario
from mcsim.systems.velocity.sources import SENSOR_TERMS, acting_alone

Array = NDArray[np.float64]

#: Sources of uncertainty, as the comparison tells them apart.
SOURCES = ("calibration matrix", "zero bias", "noise", "tilt change", "gravity", "time base")
#: Groups simulated for the comparison.
GROUPS = 10_000


@dataclass(frozen=True)
class Course:
    """Standard uncertainty of the velocity after every step; arrays (n + 1,), m/s.

    ``summed`` is Eq. (30) by source, which knows nothing of ``sensor_terms``, the accelerometer's
    own (their names; none if empty), ``summed_mean`` Eq. (31); ``simulated`` the Monte-Carlo
    deviation of a single run by source acting alone, ``total`` of all together,
    ``total_mean`` that of the mean of ``runs`` runs; ``scatter`` is s(v), and
    ``other_scatter`` what it is with the other kind of time errors than the scenario's
    (``stamps`` or independent intervals).  ``by_acceleration`` is what the errors of the
    calibration would make of the velocity if they entered the acceleration alone, and not the
    initial tilt as well (to first order).  ``limits`` are the bounds of the sensor and of the model
    that the run reaches.  Of ``measured`` runs ``truth`` is their mean, ``scatter`` theirs, and
    ``other_scatter`` what noise and time base alone would make; a single one has nan for both.
    """

    time: Array
    truth: Array
    runs: int
    summed: Mapping[str, Array]
    summed_mean: Array
    simulated: Mapping[str, Array]
    total: Array
    total_mean: Array
    scatter: Array
    other_scatter: Array
    stamps: bool
    by_acceleration: Array
    sensor_terms: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    measured: bool = False

    @property
    def summed_total(self) -> Array:
        """uc(vX,N), Eq. (30)."""
        return np.sqrt(np.sum([u**2 for u in self.summed.values()], axis=0))

    @property
    def interaction(self) -> Array:
        """Variance that the sources make together beyond the sum of each alone."""
        return self.total**2 - np.sum([u**2 for u in self.simulated.values()], axis=0)


def course_of_uncertainty(
    model: VelocityScenario, groups: int = GROUPS, folder: Path = Path()
) -> Course:
    """Propagate the scenario's uncertainties over its run, in both ways.

    ``folder`` is where recorded files lie.

    Raises
    ------
    InputError
        The run cannot be sampled.
    """
    problem = VelocityProblem.from_model(model, folder)
    key = point_key(model.monte_carlo, ())
    by_sums, without_noise = _summed(model, problem)
    total, total_mean, scatter = _deviations(problem, key, groups)
    terms = _sensor_terms(problem)
    sources = (*SOURCES, SENSOR_TERMS) if terms else SOURCES
    simulated = {
        source: _deviations(acting_alone(problem, source), key, groups)[0] for source in sources
    }
    return Course(
        time=np.round(np.arange(len(problem.truth)) * problem.interval, 12),
        truth=problem.truth,
        runs=model.runs,
        summed=by_sums,
        summed_mean=np.sqrt(without_noise + scatter**2 / model.runs),
        simulated=simulated,
        total=total,
        total_mean=total_mean,
        scatter=scatter,
        other_scatter=_deviations(replace(problem, stamps=not problem.stamps), key, groups)[2],
        stamps=problem.stamps,
        by_acceleration=_by_acceleration(problem),
        sensor_terms=terms,
        limits=limit_texts(problem.limits(key, min(groups, LOOKED_AT))),
    )


def _sensor_terms(problem: VelocityProblem) -> tuple[str, ...]:
    """Names of the accelerometer's error terms beyond white noise."""
    prefix = "accelerometer "
    names = [s.removeprefix(prefix) for s in problem.linear.variances if s.startswith(prefix)]
    m = problem.measurement
    if any(m.largest(problem.signals, axis) > limit for axis, limit in enumerate(m.ranges)):
        names.append("range")
    return tuple(names)


def _summed(model: VelocityScenario, problem: VelocityProblem) -> tuple[dict[str, Array], Array]:
    """Eq. (30) by source, and the sum of Eq. (31) that leaves out the raw output's noise."""
    known = known_of(model)
    return summed(step_variances(known, problem.raw, problem.inputs[9:12], problem.interval))


def _by_acceleration(problem: VelocityProblem) -> Array:
    """Deviation (n + 1,) of the velocity from the calibration's errors at a known tilt."""
    pushes = calibration_pushes(problem.raw, problem.inputs, problem.tilt_order)
    velocity = problem.interval * np.cumsum(pushes, axis=0) * problem.uncertainties[:9]
    return np.append(0.0, np.sqrt(np.sum(velocity**2, axis=1)))


def _deviations(problem: VelocityProblem, key: int, groups: int) -> tuple[Array, Array, Array]:
    """Standard deviation of a run's velocity and of the mean; root mean square of s(v)."""
    single, mean, scatter = problem.errors_over_time(key, 0, groups)
    return single.std(axis=1), mean.std(axis=1), np.sqrt(np.mean(scatter**2, axis=1))
