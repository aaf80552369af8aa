"""The velocity case: a scenario's point as arrays for the velocity kernel."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mcsim.cases.nets import net_normals
from mcsim.cases.problem import Array, History, LinearModel, Sample
from mcsim.cases.velocity_linear import VelocityWeights, velocity_linear_model, velocity_weights
from mcsim.errors import InputError
from mcsim.scenario import VelocityScenario
from mcsim.scenario.velocity import Bias, Calibration, Number
from mcsim.trajectory.straight_run import RunMotion, run_motion, within_intervals

#: Errors per instant: velocity of a run, of the mean, standard deviation of the runs.
PER_INSTANT = 3
_MOST_STEPS = 20_000_000
_MOST_TRACKS = 1000
#: Beyond a jump of the acceleration (s).
_JUST_AFTER = 1e-7
_TILT_ORDERS = ("first", "second", "exact")
_NOTHING = np.zeros((0, 0))
_NONE_GIVEN = np.zeros((0, 0), np.float32)
_NO_CURVES = np.zeros((0, 0, 0))


@dataclass(frozen=True)
class VelocityProblem:
    """Arrays and numbers of the velocity kernel; see ``mcsim.kernels.velocity.simulate``.

    ``raw`` (n, 3) holds the undisturbed raw output at the steps, ``truth`` (n + 1,) the true
    velocity before each step and after the last; ``steps`` (k,) how many steps each asked
    instant takes.
    """

    raw: Array
    truth: Array
    inputs: Array
    uncertainties: Array
    white: Array
    interval: float
    time_error: float
    stamps: bool
    tilt_order: int
    runs: int
    steps: NDArray[np.int64]
    error_names: tuple[str, ...]
    percentiles: tuple[float, ...] = VelocityScenario.PERCENTILES

    @classmethod
    def from_model(cls, model: VelocityScenario) -> VelocityProblem:
        """Truth, calibration and errors of one point.

        Raises
        ------
        InputError
            An instant earlier than the first sample, or an absurdly long run.
        """
        sensor, gravity = model.sensor, model.gravity
        n = step_count(model)
        interval = 1.0 / sensor.rate
        times = np.arange(n + 1, dtype=float) / sensor.rate
        motion = run_motion(model.trajectory, times)
        at_rest = RunMotion(*(np.zeros(1),) * 3, np.full(1, model.trajectory.mounting_angle))
        raw = _samples(model, times)
        (rest,) = raw_output(at_rest, model.calibration, gravity.estimate)
        white = np.array([sensor.noise.x, sensor.noise.y, sensor.noise.z])
        samples = max(1, math.floor(model.trajectory.rest * sensor.rate * (1.0 + 1e-12)))
        c = model.calibration
        numbers: list[Number | Bias] = [
            *(c.lxx, c.lxy, c.lxz, c.lzx, c.lzy, c.lzz),
            *(c.bx, c.by, c.bz),
        ]
        return cls(
            raw=np.ascontiguousarray(raw),
            truth=motion.velocity,
            inputs=np.array([*(q.estimate for q in numbers), *rest, 0.0, gravity.estimate]),
            uncertainties=np.array(
                [
                    *(q.uncertainty for q in numbers),
                    *white / math.sqrt(samples),
                    model.tilt.change,
                    gravity.uncertainty,
                ]
            ),
            white=white,
            interval=interval,
            time_error=sensor.time_error,
            stamps=sensor.time_errors == "stamps",
            tilt_order=_TILT_ORDERS.index(model.tilt.order),
            runs=model.runs,
            steps=np.array([_steps_until(t, sensor.rate) for t in model.reported]),
            error_names=tuple(row.label for row in model.error_rows),
        )

    @property
    def n_samples(self) -> int:
        return len(self.raw) * self.runs

    @property
    def missing(self) -> Mapping[str, str]:
        if self.runs > 1:
            return {}
        reason = "a single run has no scatter; raise `runs`"
        return dict.fromkeys(self.error_names[2::PER_INSTANT], reason)

    @cached_property
    def weights(self) -> VelocityWeights:
        """First-order weights of all disturbances."""
        return velocity_weights(
            self.raw,
            self.inputs,
            self.uncertainties,
            self.white,
            self.interval,
            self.time_error,
            self.stamps,
            self.tilt_order,
            self.steps,
        )

    @cached_property
    def linear(self) -> LinearModel:
        return velocity_linear_model(self.weights, self.runs)

    @cached_property
    def _method_errors(self) -> Array:
        still = replace(
            self, uncertainties=0.0 * self.uncertainties, white=0.0 * self.white, time_error=0.0
        )
        return still._run(0, 0, 1)[0][:, 0]

    def method_errors(self) -> Array:
        return self._method_errors

    def simulate(
        self, key: int, first: int, count: int, controls: bool = False, net: int = 0
    ) -> Sample:
        return Sample(*self._run(key, first, count, controls, net))

    def velocities(self, key: int, first: int, count: int) -> Array:
        """Velocities (n, runs, count) of every run of some groups after every step, in m/s."""
        at_all = replace(self, steps=np.arange(1, len(self.raw) + 1))
        curves = np.empty((len(self.raw), self.runs, count))
        at_all._run(key, first, count, curves=curves)
        return curves

    def errors_over_time(self, key: int, first: int, count: int) -> Array:
        """The three errors (3, n + 1, count) before the first step and after every one."""
        at_all = replace(self, steps=np.arange(1, len(self.raw) + 1))
        errors, _ = at_all._run(key, first, count)
        over_time = errors.reshape(len(self.raw), PER_INSTANT, count).swapaxes(0, 1)
        return np.concatenate([np.zeros((PER_INSTANT, 1, count)), over_time], axis=1)

    def history(self, key: int, first: int, count: int) -> History:
        runs = min(count, _MOST_TRACKS)
        curves = self.velocities(key, first, -(-runs // self.runs))
        # Runs of the first group, then of the next.
        tracks = curves.transpose(0, 2, 1).reshape(len(self.raw), -1)[:, :runs]
        return History(
            time=np.arange(len(self.truth), dtype=float) * self.interval,
            tracks=np.concatenate([np.zeros((1, runs)), tracks])[None],
            truth=self.truth[None],
            errors=self.errors_over_time(key, first, count),
            coordinates=("velocity [m/s]",),
        )

    def _run(
        self,
        key: int,
        first: int,
        count: int,
        controls: bool = False,
        net: int = 0,
        curves: Array = _NO_CURVES,
    ) -> tuple[Array, Array]:
        """Errors (3 k, count) and linear errors of the same shape or (3 k, 0)."""
        from mcsim.kernels.velocity import DRAWN, simulate

        rows = PER_INSTANT * len(self.steps)
        errors = np.empty((rows, count))
        linear = np.empty((rows, count if controls else 0))
        simulate(
            np.uint64(key),
            np.uint64(first),
            count,
            self.runs,
            self.raw,
            self.inputs,
            self.uncertainties,
            self.white,
            self.interval,
            self.time_error,
            self.stamps,
            self.tilt_order,
            self.steps,
            self.truth[self.steps],
            self.weights.steps if controls else _NOTHING,
            self.weights.group if controls else _NOTHING,
            net_normals(key, first, count, net, DRAWN) if net else _NONE_GIVEN,
            errors,
            linear,
            curves,
        )
        if self.runs == 1:
            errors[2::PER_INSTANT] = np.nan
        return errors, linear


def _samples(model: VelocityScenario, times: Array) -> Array:
    """Undisturbed raw output (n, 3) for the intervals between ``n + 1`` times."""
    run, gravity = model.trajectory, model.gravity.estimate
    if model.sensor.sampling == "none":
        return raw_output(run_motion(run, times[:-1] + _JUST_AFTER), model.calibration, gravity)
    motion, weights = within_intervals(run, times)
    flat = RunMotion(
        motion.velocity.ravel(),
        motion.acceleration.ravel(),
        motion.vertical.ravel(),
        motion.tilt.ravel(),
    )
    outputs = raw_output(flat, model.calibration, gravity).reshape(len(times) - 1, -1, 3)
    return np.einsum("nkc,k->nc", outputs, weights)


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


def step_count(model: VelocityScenario) -> int:
    """Steps of a run.

    Raises
    ------
    InputError
        An instant earlier than the first sample, or an absurdly long run.
    """
    rate = model.sensor.rate
    if model.trajectory.rest * rate < 1.0 - 1e-9:
        raise InputError(
            f"trajectory.rest: {model.trajectory.rest:g} s hold no sample; the initial tilt needs "
            f"at least one sampling interval, {1.0 / rate:.4g} s"
        )
    for instant in model.instants or ():
        steps = instant * rate
        if abs(steps - round(steps)) > 1e-6 * max(steps, 1.0):
            raise InputError(
                f"instants: {instant:g} s is not a multiple of the sampling interval; the nearest "
                f"are {math.floor(steps) / rate:.6g} s and {math.ceil(steps) / rate:.6g} s"
            )
    if _steps_until(model.reported[0], rate) < 1:
        raise InputError(
            f"sensor.rate: {model.reported[0]:g} s after the start is less than one sampling "
            f"interval; use a rate above {1.0 / model.reported[0]:.4g} Hz"
        )
    n = _steps_until(model.trajectory.duration, rate)
    if n * model.runs > _MOST_STEPS:
        raise InputError(
            f"runs: {model.runs} runs of {n:,} samples are more than mcsim can hold; "
            "shorten `trajectory.duration` or lower `sensor.rate` or `runs`"
        )
    return n


def _steps_until(time: float, rate: float) -> int:
    return math.floor(time * rate * (1.0 + 1e-12) + 1e-9)
