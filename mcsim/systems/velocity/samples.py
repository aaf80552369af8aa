"""What the velocity case's accelerometer would read without errors: its raw output."""

from __future__ import annotations

import numpy as np

from mcsim.sensor_terms.mechanisms.linear_filter import Filters
from mcsim.simulation.problem import Array
from mcsim.systems.velocity.scenario import Calibration, VelocityScenario
from mcsim.systems.velocity.truth import RunMotion, TrueRun

#: Beside a jump of the acceleration (s).
_JUST_BESIDE = 1e-7
#: Steps of the filters in each sampling interval.
_DENSE_STEPS = 8


def run_samples(
    model: VelocityScenario,
    run: TrueRun,
    times: Array,
    filters: tuple[Filters, ...] = ((),) * 3,
) -> Array:
    """Undisturbed raw output (n, 3) of a run for the intervals between ``n + 1`` times.

    Each axis is sampled behind its filters, which have settled in the standstill before the run.
    """
    samples = _wide_samples(model, run, times)
    behind = [axis for axis, own in enumerate(filters) if own]
    if behind:
        dense, rest = _dense_output(model, run, times), rest_output(model)
    for axis in behind:
        values, means = dense[:, :, axis], samples[:, axis]
        for one in filters[axis]:
            values, means = one.over_intervals(
                values, means, float(rest[axis]), _DENSE_STEPS * model.sensor.rate
            )
        samples[:, axis] = values[:, 0] if model.sensor.sampling == "none" else means
    return np.ascontiguousarray(samples)


def _wide_samples(model: VelocityScenario, run: TrueRun, times: Array) -> Array:
    gravity = model.gravity.local_gravity
    if model.sensor.sampling == "none":
        return raw_output(run.motion(times[:-1] + _JUST_BESIDE), model.calibration, gravity)
    motion, weights = run.within_intervals(times)
    flat = RunMotion(
        motion.velocity.ravel(),
        motion.acceleration.ravel(),
        motion.vertical.ravel(),
        motion.tilt.ravel(),
    )
    outputs = raw_output(flat, model.calibration, gravity).reshape(len(times) - 1, -1, 3)
    return np.einsum("nkc,k->nc", outputs, weights)


def _dense_output(model: VelocityScenario, run: TrueRun, times: Array) -> Array:
    """Raw output (n, k + 1, 3) at the ends of k steps in each interval between the times.

    At the ends of the intervals, where the acceleration may jump, it is the one inside.
    """
    steps = np.arange(_DENSE_STEPS + 1) / (_DENSE_STEPS * model.sensor.rate)
    inside = times[:-1, None] + steps
    inside[:, 0] += _JUST_BESIDE
    inside[:, -1] -= _JUST_BESIDE
    motion = run.motion(inside.ravel())
    output = raw_output(motion, model.calibration, model.gravity.local_gravity)
    return output.reshape(len(inside), -1, 3)


def rest_output(model: VelocityScenario) -> Array:
    """Undisturbed raw output (3,) at rest."""
    still = np.zeros(1)
    at_rest = RunMotion(still, still, still, np.full(1, model.trajectory.mounting_angle))
    (rest,) = raw_output(at_rest, model.calibration, model.gravity.local_gravity)
    return np.asarray(rest, float)


def raw_output(motion: RunMotion, calibration: Calibration, gravity: float) -> Array:
    """Undisturbed raw output (n, 3) in fractions of g, Eq. (2) and (6)-(7).

    The matrix M0 is the inverse of L; the row of L for y, which no equation uses, is (0, 1, 0).
    """
    upward = 1.0 + motion.vertical / gravity
    forward = motion.acceleration / gravity
    cos, sin = np.cos(motion.tilt), np.sin(motion.tilt)
    true = np.stack([forward * cos + upward * sin, 0.0 * upward, upward * cos - forward * sin])
    return raw_output_of(true.T, *correction_of(calibration))


def correction_of(calibration: Calibration) -> tuple[Array, Array]:
    """L (3, 3) and B (3,) of a calibration; the row of L for y is (0, 1, 0)."""
    c = calibration
    correction = np.array(
        [
            [c.lxx.estimate, c.lxy.estimate, c.lxz.estimate],
            [0.0, 1.0, 0.0],
            [c.lzx.estimate, c.lzy.estimate, c.lzz.estimate],
        ]
    )
    return correction, np.array([c.bx.estimate, c.by.estimate, c.bz.estimate])


def raw_output_of(true: Array, correction: Array, bias: Array) -> Array:
    """Raw output (n, 3) of true accelerations (n, 3), Eq. (2); all in fractions of g."""
    return np.linalg.solve(correction, true.T).T + bias
