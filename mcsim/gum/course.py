"""Uncertainty of the velocity over time: by summing steps, and by Monte Carlo, by source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.engine import point_key
from mcsim.errors import InputError
from mcsim.estimation import LOOKED_AT, limit_texts
from mcsim.gum.budget import correction
from mcsim.gum.propagation import step_sensitivities, tilt_sensitivities
from mcsim.systems.velocity.linear import calibration_pushes
from mcsim.systems.velocity.problem import VelocityProblem
from mcsim.systems.velocity.raw_output import raw_noise
from mcsim.systems.velocity.scenario import VelocityScenario

Array = NDArray[np.float64]

#: Sources of uncertainty, as the comparison tells them apart.
SOURCES = ("calibration matrix", "zero bias", "noise", "tilt change", "gravity", "time base")
#: What each source is among the kernel's inputs of a group.
_GROUP_INPUTS = {
    "calibration matrix": slice(0, 6),
    "zero bias": slice(6, 9),
    "noise": slice(9, 12),
    "tilt change": slice(12, 13),
    "gravity": slice(13, 14),
}
#: What Monte Carlo has beyond them: the accelerometer's error terms that are not white noise.
SENSOR_TERMS = "accelerometer terms"
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
    that the run reaches.
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

    @property
    def summed_total(self) -> Array:
        """uc(vX,N), Eq. (30)."""
        return np.sqrt(np.sum([u**2 for u in self.summed.values()], axis=0))

    @property
    def interaction(self) -> Array:
        """Variance that the sources make together beyond the sum of each alone."""
        return self.total**2 - np.sum([u**2 for u in self.simulated.values()], axis=0)


def course_of_uncertainty(model: VelocityScenario, groups: int = GROUPS) -> Course:
    """Propagate the scenario's uncertainties over its run, in both ways.

    Raises
    ------
    InputError
        The run cannot be sampled.
    """
    if model.sensor.time.varies:
        raise InputError(
            "sensor.time: a budget over time has even intervals, as Eq. (29) has; leave it out, "
            "and say by `time_error` how they err"
        )
    problem = VelocityProblem.from_model(model)
    key = point_key(model.monte_carlo, ())
    summed, without_noise = _summed(model, problem)
    total, total_mean, scatter = _deviations(problem, key, groups)
    terms = _sensor_terms(problem)
    sources = (*SOURCES, SENSOR_TERMS) if terms else SOURCES
    simulated = {source: _deviations(_only(problem, source), key, groups)[0] for source in sources}
    return Course(
        time=np.round(np.arange(len(problem.truth)) * problem.interval, 12),
        truth=problem.truth,
        runs=model.runs,
        summed=summed,
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
    """Eq. (30) by source, and the sum of Eq. (31) that leaves out the raw output's noise.

    At rest the raw output enters with the uncertainty of a single sample, as in the source.
    """
    g, interval = model.gravity, problem.interval
    noise = raw_noise(model)
    x, z = correction(model, "x"), correction(model, "z")
    rest = problem.inputs[9:12]
    by_rest_x, by_rest_z = tilt_sensitivities(x.value(rest), z.value(rest))
    theta = np.arctan(x.value(rest) / z.value(rest))
    acx, acz = x.value(problem.raw), z.value(problem.raw)
    by_x, by_z, by_theta, by_g, by_interval = step_sensitivities(
        acx, acz, theta, g.estimate, interval
    )
    of_x, of_z = x.variances(problem.raw, noise), z.variances(problem.raw, noise)
    of_rest_x, of_rest_z = x.variances(rest, noise), z.variances(rest, noise)
    steps = {
        source: by_x**2 * of_x[source]
        + by_z**2 * of_z[source]
        + by_theta**2 * (by_rest_x**2 * of_rest_x[source] + by_rest_z**2 * of_rest_z[source])
        for source in of_x
    }
    steps["tilt change"] = by_theta**2 * model.tilt.change**2 * np.ones_like(acx)
    steps["gravity"] = by_g**2 * g.uncertainty**2
    steps["time base"] = by_interval**2 * model.sensor.time_error**2
    sums = {source: np.append(0.0, np.cumsum(steps[source])) for source in SOURCES}
    return (
        {source: np.sqrt(variance) for source, variance in sums.items()},
        np.sum([variance for source, variance in sums.items() if source != "noise"], axis=0),
    )


def _by_acceleration(problem: VelocityProblem) -> Array:
    """Deviation (n + 1,) of the velocity from the calibration's errors at a known tilt."""
    pushes = calibration_pushes(problem.raw, problem.inputs, problem.tilt_order)
    velocity = problem.interval * np.cumsum(pushes, axis=0) * problem.uncertainties[:9]
    return np.append(0.0, np.sqrt(np.sum(velocity**2, axis=1)))


def _only(problem: VelocityProblem, source: str) -> VelocityProblem:
    """The problem with one source of uncertainty alone."""
    alone = np.zeros_like(problem.uncertainties)
    if source in _GROUP_INPUTS:
        alone[_GROUP_INPUTS[source]] = problem.uncertainties[_GROUP_INPUTS[source]]
    errors = problem.sensor_errors
    if source == SENSOR_TERMS:
        errors = replace(errors, white=np.zeros_like(errors.white))
    else:
        errors = errors.white_alone() if source == "noise" else errors.silent()
    return replace(
        problem,
        uncertainties=alone,
        sensor_errors=errors,
        time_error=problem.time_error if source == "time base" else 0.0,
    )


def _deviations(problem: VelocityProblem, key: int, groups: int) -> tuple[Array, Array, Array]:
    """Standard deviation of a run's velocity and of the mean; root mean square of s(v)."""
    single, mean, scatter = problem.errors_over_time(key, 0, groups)
    return single.std(axis=1), mean.std(axis=1), np.sqrt(np.mean(scatter**2, axis=1))
