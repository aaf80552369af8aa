"""From raw output to velocity, and how uncertain inputs act on it: by sums, and by Monte Carlo.

The Monte Carlo draws what the velocity case of a scenario draws: calibration, change of the tilt
and gravity once for all steps and runs, the mean noise of a rest once for its run, noise and
intervals for every step.  The acceleration is linear in the raw output,
``aX = k (am - B)`` with three numbers k, so that a draw needs the sums of the measured steps alone:
all draws are made together.  Noise of a step acts along k, as one normal number.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.gum.propagation import Known, step_variances, summed
from mcsim.measured_velocity.correction_file import CorrectionInput
from mcsim.measured_velocity.group import Group
from mcsim.systems.velocity.linear import accelerations, calibration_pushes, turn

Array = NDArray[np.float64]

#: Sources of uncertainty, as the comparison tells them apart.
SOURCES = ("calibration matrix", "zero bias", "noise", "tilt change", "gravity", "time base")
#: Draws, and numbers (draws × runs × steps) that are held at once.
DRAWS, _AT_ONCE = 10_000, 4_000_000
_ENDS = (2.5, 97.5)


@dataclass(frozen=True)
class Inputs:
    """What is known beside the runs, with standard uncertainties.

    ``tilt_change`` u(δα) (rad), ``gravity`` and ``gravity_error`` (m/s²), ``interval_error`` u(Δt)
    (s); ``stamps`` says that time stamps err, not intervals; ``order`` is that of the tilt
    (0 Eq. (15), 1 Eq. (12), 2 the whole rotation).
    """

    correction: CorrectionInput
    tilt_change: float
    gravity: float
    gravity_error: float
    interval_error: float
    stamps: bool
    order: int = 0

    def known(self, group: Group) -> Known:
        """What the steps share, for Eq. (26) to (29); the noise is that of the rests."""
        return Known(
            self.correction.row("x"),
            self.correction.row("z"),
            group.scatter.deviation,
            self.tilt_change,
            self.gravity,
            self.gravity_error,
            self.interval_error,
        )

    def vector(self, rest: Array) -> Array:
        """Estimates (14,) as the velocity case orders them, for a run with this rest (3,)."""
        return np.array([*self.correction.estimates, *rest, 0.0, self.gravity])


def velocities(inputs: Inputs, group: Group) -> Array:
    """Velocity (M, n + 1) of every run (m/s), Eq. (4), (5), (15)–(24), from standstill."""
    found = np.zeros((group.runs, len(group.time)))
    for own, raw, rest, dt in zip(found, group.raw, group.rests, group.intervals, strict=True):
        own[1:] = np.cumsum(accelerations(raw, inputs.vector(rest), inputs.order) * dt)
    return found


def tilts(inputs: Inputs, group: Group) -> Array:
    """Initial tilt θ0 (M,) of every run (rad), Eq. (20)."""
    known = inputs.known(group)
    return np.arctan(known.x.value(group.rests) / known.z.value(group.rests))


@dataclass(frozen=True)
class Sums:
    """Eq. (30) by source and Eq. (31): standard uncertainties over time (n + 1,), m/s.

    ``single`` (M, n + 1) is Eq. (30) of each run, ``by_source`` its root mean square over the
    runs; ``scatter`` is s(v), nan for a single run, and so is ``mean``.
    """

    single: Array
    by_source: dict[str, Array]
    mean: Array
    scatter: Array


def sums(inputs: Inputs, group: Group, found: Array) -> Sums:
    """The source's uncertainties of velocities (M, n + 1): steps as if independent."""
    known = inputs.known(group)
    each = [
        summed(step_variances(known, raw, rest, dt))
        for raw, rest, dt in zip(group.raw, group.rests, group.intervals, strict=True)
    ]
    by_source = {
        source: np.sqrt(np.mean([own[source] ** 2 for own, _ in each], axis=0))
        for source in SOURCES
    }
    m = group.runs
    scatter = found.std(axis=0, ddof=1) if m > 1 else np.full(len(group.time), np.nan)
    systematic = np.mean([without for _, without in each], axis=0)
    return Sums(
        single=np.sqrt([np.sum([u**2 for u in own.values()], axis=0) for own, _ in each]),
        by_source=by_source,
        mean=np.sqrt(systematic + scatter**2 / m),
        scatter=scatter,
    )


@dataclass(frozen=True)
class Drawn:
    """What Monte Carlo finds over time: deviations (M, n + 1) of the runs, (n + 1,) of their mean.

    ``low`` and ``high`` (n + 1,) hold 95 % of the mean's velocities; ``scatter`` is what the
    standard deviation over the runs would be from noise and intervals alone (root mean square).
    """

    single: Array
    mean: Array
    low: Array
    high: Array
    scatter: Array


def draw(inputs: Inputs, group: Group, draws: int, seed: int, only: str | None = None) -> Drawn:
    """Propagate the distributions of all inputs, or of one source of ``SOURCES`` ``only``."""
    generator = np.random.default_rng(seed)
    wanted = {name: only in (None, name) for name in SOURCES}
    measured = _Measured.of(group)
    m, n = group.raw.shape[:2]
    at_once = max(1, min(draws, _AT_ONCE // (m * n)))
    moments, means = [np.zeros((m, n + 1)) for _ in range(2)], np.empty((draws, n + 1))
    scatter = np.zeros(n + 1)
    centre = velocities(inputs, group)
    for first in range(0, draws, at_once):
        count = min(at_once, draws - first)
        drawn = _drawn(inputs, group, measured, count, wanted, generator) - centre
        means[first : first + count] = drawn.mean(axis=1)
        moments[0] += drawn.sum(axis=0)
        moments[1] += np.sum(drawn**2, axis=0)
        if m > 1:
            own = drawn - means[first : first + count, None]
            scatter += np.sum(own**2, axis=(0, 1)) / (m - 1)
    single = np.sqrt(np.maximum(moments[1] / draws - (moments[0] / draws) ** 2, 0.0))
    low, high = np.percentile(means, _ENDS, axis=0) + centre.mean(axis=0)
    return Drawn(single, means.std(axis=0), low, high, np.sqrt(scatter / draws))


@dataclass(frozen=True)
class _Measured:
    """Sums over the steps of each run: of raw output times interval (M, 3, n + 1), of intervals."""

    outputs: Array
    times: Array

    @classmethod
    def of(cls, group: Group) -> _Measured:
        steps = (group.raw * group.intervals[..., None]).transpose(0, 2, 1)
        outputs = np.concatenate([np.zeros((*steps.shape[:2], 1)), np.cumsum(steps, axis=2)], 2)
        zeros = np.zeros((group.runs, 1))
        return cls(outputs, np.concatenate([zeros, np.cumsum(group.intervals, axis=1)], 1))


def _drawn(
    inputs: Inputs,
    group: Group,
    measured: _Measured,
    count: int,
    wanted: dict[str, bool],
    generator: np.random.Generator,
) -> Array:
    """Velocities (count, M, n + 1) of as many draws."""
    m, n = group.raw.shape[:2]
    matrix, bias = _calibrations(inputs.correction, count, wanted, generator)
    noise = group.scatter.deviation * np.sqrt(group.scatter.inflation) * wanted["noise"]
    of_rest = noise / np.sqrt(group.rest_samples[:, None])
    rest = group.rests + of_rest * generator.standard_normal((count, m, 3))
    tilt = inputs.tilt_change * wanted["tilt change"] * generator.standard_normal(count)
    g = inputs.gravity + inputs.gravity_error * wanted["gravity"] * generator.standard_normal(count)
    k = _weights(matrix, bias, rest, tilt, g, inputs.order)
    found = np.einsum("cmk,mkn->cmn", k, measured.outputs)
    found -= np.sum(k * bias[:, None], axis=2)[..., None] * measured.times
    if wanted["noise"]:
        along = np.sqrt(np.sum((k * noise) ** 2, axis=2))[..., None]
        steps = along * generator.standard_normal((count, m, n)) * group.intervals
        found[..., 1:] += np.cumsum(steps, axis=2)
    if wanted["time base"] and inputs.interval_error > 0.0:
        errors = _interval_errors(inputs, (count, m, n), generator)
        pushes = np.einsum("cmk,mnk->cmn", k, group.raw)
        pushes -= np.sum(k * bias[:, None], axis=2)[..., None]
        found[..., 1:] += np.cumsum(pushes * errors, axis=2)
    return found


def _calibrations(
    correction: CorrectionInput,
    count: int,
    wanted: dict[str, bool],
    generator: np.random.Generator,
) -> tuple[Array, Array]:
    """Correction rows (count, 2, 3) of x and z and biases (count, 3), as their covariance has."""
    acts = np.repeat([wanted["calibration matrix"], wanted["zero bias"]], [6, 3])
    covariance = correction.covariance * np.outer(acts, acts)
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    drawn = correction.estimates + generator.standard_normal((count, 9)) @ root.T
    return drawn[:, :6].reshape(count, 2, 3), drawn[:, 6:]


def _weights(
    matrix: Array, bias: Array, rest: Array, tilt: Array, gravity: Array, order: int
) -> Array:
    """k (count, M, 3) of aX = k (am - B), Eq. (4), (5), (15)-(20)."""
    at_rest = rest - bias[:, None]
    x, z = np.einsum("cak,cmk->acm", matrix, at_rest)
    p, q = turn(np.arctan(x / z) + tilt[:, None], order)
    p = np.broadcast_to(p, x.shape)
    rows = p[..., None] * matrix[:, None, 0] - q[..., None] * matrix[:, None, 1]
    return np.asarray(gravity[:, None, None] * rows)


def _interval_errors(
    inputs: Inputs, shape: tuple[int, int, int], generator: np.random.Generator
) -> Array:
    """Errors (count, M, n) of the intervals: independent, or differences of the stamps' errors."""
    if not inputs.stamps:
        return inputs.interval_error * generator.standard_normal(shape)
    stamps = generator.standard_normal((*shape[:2], shape[2] + 1))
    return inputs.interval_error / np.sqrt(2.0) * np.diff(stamps, axis=2)


def by_acceleration(inputs: Inputs, group: Group) -> Array:
    """Deviation (n + 1,) of the mean run from the calibration's errors at a known tilt (m/s)."""
    vector = inputs.vector(group.rests.mean(axis=0))
    pushes = calibration_pushes(group.raw.mean(axis=0), vector, inputs.order)
    steps = pushes * group.intervals.mean(axis=0)[:, None]
    velocity = np.cumsum(steps, axis=0)
    variance = np.einsum("ni,ij,nj->n", velocity, inputs.correction.covariance, velocity)
    return np.append(0.0, np.sqrt(np.maximum(variance, 0.0)))
