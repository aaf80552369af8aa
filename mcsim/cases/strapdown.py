"""The strapdown case: a scenario's point as arrays for the strapdown kernel."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from mcsim.cases.planar import course_missing, sample_count, wrap
from mcsim.cases.problem import Array, History, LinearModel, Sample
from mcsim.cases.strapdown_linear import Weights, linear_model, linear_weights
from mcsim.kernels import strapdown as kernel
from mcsim.scenario import StrapdownScenario
from mcsim.sensors.error_model import channel_errors
from mcsim.sensors.sampling import sample
from mcsim.trajectory.spatial import SpatialDrive, SpatialMotion, spatial_drive

#: Standard deviations that bound the rates of practically all realizations.
_WIDE = 7.0
#: From the three channels of the planar case to all six (see ``mcsim.kernels.strapdown``).
_LIKE_PLANAR = [0, 1, 2, 0, 2, 2]
_TURNS = [2, 4, 5]
_METHODS = {
    "rectangular": kernel.RECTANGULAR,
    "forward_euler": kernel.FORWARD_EULER,
    "trapezoidal": kernel.TRAPEZOIDAL,
    "two_sample": kernel.TWO_SAMPLE,
}
_STILL = 1e-9


@dataclass(frozen=True)
class StrapdownProblem:
    """Arrays and numbers of the strapdown kernel; see ``mcsim.kernels.strapdown.simulate``.

    ``signals`` (n + 1, 6) are true samples, with turns per interval in the place of rates;
    ``truth`` is the true motion at the samples 0 ... n.
    """

    signals: Array
    white: Array
    deviations: Array
    truth: SpatialMotion
    rest: Array
    levelled: bool
    gravity: float
    interval: float
    method: int
    previous_share: float
    missing: Mapping[str, str]
    error_names: tuple[str, ...] = StrapdownScenario.ERRORS
    percentiles: tuple[float, ...] = StrapdownScenario.PERCENTILES

    @classmethod
    def from_model(cls, model: StrapdownScenario, folder: Path) -> StrapdownProblem:
        """Truth, sampling and error model of one point.

        Raises
        ------
        InputError
            No such track, or one that is shorter than a sample or absurdly long.
        """
        drive = spatial_drive(model, folder)
        sensors = model.sensors
        samples = sampled(drive, sensors.rate, sensors.sampling)
        return cls(
            signals=samples.signals,
            white=white_deviations(model),
            deviations=constant_deviations(model),
            truth=samples.truth,
            rest=drive.at_rest(-drive.drive.lead),
            levelled=model.initial.levelling is not None,
            gravity=model.body.gravity,
            interval=1.0 / sensors.rate,
            method=_METHODS[model.reconstruction.integration],
            previous_share=0.0 if sensors.sampling == "average" else 0.5,
            missing=course_missing(drive.drive),
        )

    @property
    def n_samples(self) -> int:
        return len(self.signals) - 1

    @cached_property
    def weights(self) -> Weights:
        """First-order weights of all disturbances."""
        return linear_weights(
            self._rows,
            self.white,
            self.deviations,
            self._start,
            self.rest,
            self.levelled,
            self.gravity,
            self.interval,
            self.method,
            self.previous_share,
        )

    @cached_property
    def linear(self) -> LinearModel:
        return linear_model(self.weights, self.method_errors())

    @cached_property
    def _rows(self) -> Array:
        """The samples as the integrator takes them: the forward Euler rule is one behind."""
        if self.method != kernel.FORWARD_EULER:
            return self.signals
        return np.concatenate([self.signals[:1], self.signals[:-1]])

    @cached_property
    def _start(self) -> Array:
        truth = self.truth
        horizontal, upwards = np.hypot(*truth.velocity[:2, 0]), truth.velocity[2, 0]
        attitude = truth.attitude
        return np.array(
            [
                *truth.position[:, 0],
                math.hypot(horizontal, upwards),
                math.atan2(upwards, horizontal),
                attitude.roll[0],
                attitude.pitch[0],
                attitude.heading[0],
                truth.course[0],
            ]
        )

    @cached_property
    def _end(self) -> Array:
        attitude = self.truth.attitude
        course = math.nan if "course" in self.missing else self.truth.course[-1]
        angles = (attitude.roll[-1], attitude.pitch[-1], attitude.heading[-1], course)
        return np.array([*self.truth.position[:, -1], *angles])

    @cached_property
    def _method_errors(self) -> Array:
        errors, _ = self._run(0, 0, 1, disturbed=False)
        return errors[:, 0]

    def method_errors(self) -> Array:
        return self._method_errors

    def simulate(self, key: int, first: int, count: int, controls: bool = False) -> Sample:
        errors, linear = self._run(key, first, count, with_linear=controls)
        if not controls:
            return Sample(errors, linear)
        return Sample(errors, self._controls(linear))

    def _controls(self, linear: Array) -> Array:
        """Controls (8, r) from linear errors (7, r)."""
        method = self.method_errors()[:3]
        along, across, height, course, roll, pitch, heading = linear
        length = np.sqrt(np.sum((method[:, None] + linear[:3]) ** 2, axis=0))
        position = length - np.linalg.norm(method)
        return np.stack([along, across, height, position, roll, pitch, heading, course])

    def history(self, key: int, first: int, count: int) -> History:
        states = np.empty((kernel.HISTORY_ROWS, self.n_samples + 1, count))
        self._run(key, first, count, history=states)
        truth = self.truth
        errors = states[:3] - truth.position[:, :, None]
        return History(
            time=np.arange(self.n_samples + 1, dtype=float) * self.interval,
            tracks=states[:2],
            truth=truth.position[:2],
            errors=np.concatenate(
                [
                    errors,
                    np.sqrt(np.sum(errors**2, axis=0))[None],
                    wrap(states[6:9] - _angles(truth)[:, :, None]),
                    self._course_errors(states)[None],
                ]
            ),
        )

    def _course_errors(self, states: Array) -> Array:
        course = np.arctan2(states[4], states[3]) - self.truth.course[:, None]
        speed = np.hypot(*self.truth.velocity[:2])
        course[speed <= _STILL * np.max(speed)] = np.nan
        if "course" in self.missing:
            course[-1] = np.nan
        return wrap(course)

    def _run(
        self,
        key: int,
        first: int,
        count: int,
        disturbed: bool = True,
        with_linear: bool = False,
        history: Array | None = None,
    ) -> tuple[Array, Array]:
        """Errors (8, count) and linear errors (7, count or 0)."""
        errors = np.empty((kernel.ERRORS, count))
        linear = np.empty((kernel.LINEAR_ERRORS, count if with_linear else 0))
        samples, constants = self._kernel_weights if with_linear else (_NOTHING, _NOTHING)
        factor = 1.0 if disturbed else 0.0
        kernel.simulate(
            np.uint64(key),
            np.uint64(first),
            count,
            self._rows,
            factor * self.white,
            factor * self.deviations,
            self._start,
            self._end,
            self.rest,
            self.levelled,
            self.gravity,
            self.interval,
            self.method,
            self.previous_share,
            self._largest_turn(factor),
            samples,
            constants,
            errors,
            linear,
            np.empty((0, 0, 0)) if history is None else history,
        )
        return errors, linear

    @cached_property
    def _kernel_weights(self) -> tuple[Array, Array]:
        """Weights laid out for the kernel: four errors of all channels, three of the turns."""
        weights = self.weights
        channels = np.moveaxis(weights.samples[:4], 0, 1).reshape(-1, 24)
        turns = np.moveaxis(weights.samples[4:, :, _TURNS], 0, 1).reshape(-1, 9)
        return np.column_stack([channels, turns]), weights.constants

    def _largest_turn(self, factor: float) -> float:
        """A bound of the rotation per sample that practically no realization exceeds."""
        spread = np.hypot(self.white[_TURNS], self.deviations[_OFFSETS_OF_TURNS])
        turns = np.max(np.abs(self.signals[:, _TURNS]), axis=0) + _WIDE * factor * spread
        return float(np.linalg.norm(turns))


_NOTHING = np.zeros((0, 0))
_OFFSETS_OF_TURNS = [2, kernel.SPATIAL + 1, kernel.SPATIAL + 2]


def _angles(truth: SpatialMotion) -> Array:
    attitude = truth.attitude
    return np.stack([attitude.roll, attitude.pitch, attitude.heading])


def _per_interval(rate: float) -> Array:
    """Factors (6,) from rates to turns per interval."""
    factors = np.ones(kernel.CHANNELS)
    factors[_TURNS] = 1.0 / rate
    return factors


def white_deviations(model: StrapdownScenario) -> Array:
    """Standard deviation (6,) of the white noise of one sample, turns per interval."""
    errors = channel_errors(model.sensors)
    return errors.white[_LIKE_PLANAR] * _per_interval(model.sensors.rate)


def constant_deviations(model: StrapdownScenario) -> Array:
    """Standard deviations (24,) of the constants, in the kernel's order."""
    sensors, initial = model.sensors, model.initial
    errors = channel_errors(sensors)
    white = white_deviations(model)
    offsets = errors.miscalibration[_LIKE_PLANAR] * _per_interval(sensors.rate)
    deviations = np.zeros(kernel.N_CONSTANTS)
    deviations[:3], deviations[kernel.SPATIAL : kernel.SPATIAL + 3] = offsets[:3], offsets[3:]
    deviations[kernel.SPEED] = initial.speed_error
    deviations[kernel.DIRECTION] = initial.direction_error
    deviations[kernel.HEADING] = initial.heading_error
    deviations[kernel.COURSE] = initial.course_error
    deviations[kernel.ROLL] = math.hypot(initial.tilt_error, initial.roll_error)
    deviations[kernel.PITCH] = math.hypot(initial.tilt_error, initial.pitch_error)
    if initial.levelling is not None:
        averaged = max(1, round(initial.levelling.duration * sensors.rate))
        deviations[kernel.REST : kernel.REST + 3] = white[[0, 1, 3]] / math.sqrt(averaged)
    if model.reconstruction.integration != "forward_euler":
        deviations[kernel.FIRST_PLANAR : kernel.FIRST_PLANAR + 3] = white[:3]
        deviations[kernel.FIRST_SPATIAL : kernel.FIRST_SPATIAL + 3] = white[3:]
    return deviations


@dataclass(frozen=True)
class Samples:
    """Ideal samples (n + 1, 6), rates as turns per interval, and the truth at their times."""

    signals: Array
    truth: SpatialMotion


@lru_cache(maxsize=64)
def sampled(drive: SpatialDrive, rate: float, method: str) -> Samples:
    """What does not change while only sensor errors are swept."""
    plane = drive.drive
    count = sample_count(plane, rate)
    signals = sample(drive.signals, -plane.lead, rate, count, method).T
    truth = drive.motion(-plane.lead + np.arange(count + 1) / rate)
    return Samples(np.ascontiguousarray(signals * _per_interval(rate)), truth)
