"""The strapdown case: a scenario's point as arrays for the strapdown strapdown."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from mcsim.kernels import strapdown
from mcsim.sensor_terms.channel import ACCELEROMETER, GYROSCOPE, Channel
from mcsim.sensors.error_model import ChannelErrors, channel_errors, per_interval
from mcsim.sensors.measurement import AtRest, Measurement, NormalWeights
from mcsim.simulation.limits import (
    angle_limits,
    duration_limits,
    passing,
    pitch_limits,
    rate_limits,
    sensor_limits,
    tilt_limits,
    units_of,
)
from mcsim.simulation.nets import net_normals
from mcsim.simulation.own import own_system
from mcsim.simulation.planar import CHANNELS as PLANAR_CHANNELS
from mcsim.simulation.planar import SIGNAL_NAMES, rarer
from mcsim.simulation.planar_samples import course_missing, wrap
from mcsim.simulation.problem import Array, History, Limit, LinearModel, Sample
from mcsim.simulation.running import LinearWeights, Sensors, adjoint_weights, run
from mcsim.systems.strapdown.constants import (
    DEVIATIONS,
    FIRST,
    FORCE,
    OFFSETS,
    REST,
    initial_deviations,
    signals_at_rest,
)
from mcsim.systems.strapdown.linear import Weights, linear_model, linear_weights
from mcsim.systems.strapdown.samples import sampled
from mcsim.systems.strapdown.scenario import StrapdownScenario
from mcsim.systems.strapdown.truth import SpatialMotion, spatial_drive

#: The planar case's channels, then those that it does not have: up, roll rate, pitch rate.
CHANNELS = (
    *PLANAR_CHANNELS,
    Channel(ACCELEROMETER, 2),
    Channel(GYROSCOPE, 0),
    Channel(GYROSCOPE, 1),
)
RATES = (False, False, True, False, True, True)
_SIGNAL_NAMES = (*SIGNAL_NAMES, "upward acceleration", "roll rate", "pitch rate")
_STILL = 1e-9


@dataclass(frozen=True)
class StrapdownProblem:
    """Arrays and numbers of the strapdown system; see ``mcsim.kernels.strapdown.Strapdown``.

    ``signals`` (n + 1, 6) are true samples, with turns per interval in the place of rates, as
    in all sensor errors; ``initial_deviations`` (24,) are those of initial errors, in the
    places of the kernel's constants; ``beyond_rate`` (6,) is the share of each signal's power
    that the rate does not hold; ``truth`` is the true motion at the samples 0 ... n.
    """

    signals: Array
    sensor_errors: ChannelErrors
    initial_deviations: Array
    truth: SpatialMotion
    rest: Array
    levelled: bool
    gravity: float
    interval: float
    rule: str
    previous_share: float
    missing: Mapping[str, str]
    beyond_rate: Array = field(default_factory=lambda: np.zeros(6))
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
        rest = drive.at_rest(-drive.drive.lead)
        levelling = model.initial.levelling
        errors = channel_errors(
            sensors,
            CHANNELS,
            drive.drive.duration,
            signals_at_rest(rest),
            levelling=levelling.duration if levelling is not None else 0.0,
        )
        samples = sampled(drive, sensors.rate, sensors.sampling, errors.bandwidths)
        errors = per_interval(errors, RATES, 1.0 / sensors.rate)
        return cls(
            signals=samples.signals,
            sensor_errors=errors,
            initial_deviations=initial_deviations(model),
            truth=samples.truth,
            rest=rest,
            levelled=levelling is not None,
            gravity=model.body.gravity,
            interval=1.0 / sensors.rate,
            rule=model.reconstruction.integration,
            previous_share=0.0 if sensors.sampling == "average" else 0.5,
            missing=course_missing(drive.drive),
            beyond_rate=samples.beyond_rate,
        )

    @property
    def n_samples(self) -> int:
        return len(self.signals) - 1

    @cached_property
    def weights(self) -> Weights:
        """First-order weights of all disturbances."""
        if self._own is not None:
            return self._own_weights()
        return linear_weights(
            self._rows,
            self._start,
            self.rest,
            self.levelled,
            self.gravity,
            self.interval,
            self.rule,
            self.previous_share,
        )

    @cached_property
    def measurement(self) -> Measurement:
        """The sensor errors as the kernel takes them."""
        first = 1 if self.rule == "forward_euler" else 0
        return Measurement.of(self.sensor_errors, self._rows, self.interval, first=first)

    @cached_property
    def _at_rest(self) -> AtRest:
        return AtRest(self.weights.at_rest, signals_at_rest(self.rest))

    @cached_property
    def normal_weights(self) -> NormalWeights:
        """Linear errors per unit normal of the sensors' random numbers."""
        return self.measurement.fold(self.weights.samples, self._rows, self._at_rest)

    @cached_property
    def linear(self) -> LinearModel:
        weights = self.weights
        by_source = {
            **self.measurement.variances(weights.samples, self._rows, self._at_rest),
            **weights.variances(self.initial_deviations),
            "levelling noise": self.measurement.levelling_noise(self._at_rest),
        }
        initial = weights.initial * self.initial_deviations
        covariance = self.normal_weights.covariance + initial @ initial.T
        model = linear_model(covariance, by_source, self.method_errors())
        return replace(model, spike_events=self._spike_events, flips=self._flips(model))

    def _flips(self, model: LinearModel) -> Array:
        """Share (8,) of realizations whose pitch passes 90°: roll and heading jump there."""
        names, pitch = self.error_names, float(self.truth.attitude.pitch[-1])
        flips = np.zeros(len(names))
        deviation = float(model.spread[names.index("pitch")])
        beyond = passing(0.5 * np.pi, pitch, deviation)
        flips[[names.index("roll"), names.index("heading")]] = beyond
        return flips

    @cached_property
    def _spike_events(self) -> Array:
        """Spikes per realization (8,); those of the position are of the rarest component's."""
        along, across, height, course, *angles = self.measurement.spike_events(self.weights.samples)
        place = (along, across, height)
        return np.array([*place, rarer(*place), *angles, course])

    def limits(self, key: int, count: int) -> tuple[Limit, ...]:
        errors, spread = self.sensor_errors, self.linear.spread
        method, names = self.method_errors(), self.error_names
        pitch = self.truth.attitude.pitch
        ends = pitch[-1] + self.simulate(key, 0, count).errors[names.index("pitch")]
        level = float(np.max(errors.offsets[:2])) / self.gravity if self.levelled else 0.0
        return (
            *sensor_limits(
                self.measurement,
                self._rows,
                units_of(errors, self.interval),
                self.interval,
                lambda m: self.measured_by(m).simulate(key, 0, count).errors,
            ),
            *rate_limits(self.beyond_rate, 1.0 / self.interval, _SIGNAL_NAMES),
            *duration_limits(self.n_samples * self.interval),
            *tilt_limits(level),
            *pitch_limits(pitch, ends, float(spread[names.index("pitch")])),
            *angle_limits(names, ("roll", "heading", "course"), method, spread),
        )

    def measured_by(self, measurement: Measurement) -> StrapdownProblem:
        """The same problem with other sensors."""
        other = replace(self)
        other.__dict__["measurement"] = measurement
        return other

    @cached_property
    def _rows(self) -> Array:
        """The samples as the integrator takes them: the forward Euler rule is one behind."""
        if self.rule != "forward_euler":
            return self.signals
        return np.concatenate([self.signals[:1], self.signals[:-1]])

    @property
    def _own(self) -> type[Any] | None:
        """The system of a user's own rule."""
        return own_system("strapdown", self.rule)

    def _own_weights(self) -> Weights:
        """Weights from the rule's own steps; what levels is taken from the motion it makes."""
        system = self._system(Measurement.none(self.sensor_errors), disturbed=False)
        samples, constants = adjoint_weights(system, self._rows)
        return Weights(samples, constants, np.zeros((len(samples), samples.shape[2])))

    @cached_property
    def _start(self) -> strapdown.Motion:
        return self._motion(0)

    def _motion(self, sample: int) -> strapdown.Motion:
        """The true motion at a sample."""
        truth = self.truth
        along, across, height = map(float, truth.position[:, sample])
        horizontal = float(np.hypot(*truth.velocity[:2, sample]))
        upwards = float(truth.velocity[2, sample])
        return strapdown.Motion(
            along,
            across,
            height,
            math.hypot(horizontal, upwards),
            math.atan2(upwards, horizontal),
            *(float(angles[sample]) for angles in (*_angles(truth), truth.course)),
        )

    def _system(self, m: Measurement, disturbed: bool) -> strapdown.Strapdown:
        """The numbers of the system, with a measurement's offsets."""
        end = self._motion(-1)
        if "course" in self.missing:
            end = end._replace(course=math.nan)
        fixed = self._deviations(m) if disturbed else np.zeros(strapdown.Strapdown.CONSTANTS)
        deviations = strapdown.Deviations(*map(float, fixed[DEVIATIONS]))
        second_order = self.rule in ("trapezoidal", "two_sample")
        turns = [m.largest(self.signals, turn) for turn in strapdown.TURNS]
        kind: type[strapdown.Strapdown] = self._own or strapdown.Strapdown
        return kind(
            way=0 if self._own else strapdown.way_of(self.rule, float(np.linalg.norm(turns))),
            interval=self.interval,
            gravity=self.gravity,
            previous_share=self.previous_share if second_order else 0.0,
            coning=1.0 / 12.0 if self.rule == "two_sample" else 0.0,
            draws=self.levelled or bool(self._own) or bool(np.any(fixed)),
            levelled=self.levelled,
            rest=strapdown.Force(*map(float, self.rest)),
            deviations=deviations,
            start=self._start,
            end=end,
        )

    @cached_property
    def _method_errors(self) -> Array:
        errors, _ = self._run(0, 0, 1, disturbed=False)
        return errors[:, 0]

    def method_errors(self) -> Array:
        return self._method_errors

    def simulate(
        self, key: int, first: int, count: int, controls: bool = False, net: int = 0
    ) -> Sample:
        errors, linear = self._run(key, first, count, with_linear=controls, net=net)
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

    def history(self, key: int, first: int, count: int, net: int = 0) -> History:
        states = np.empty((strapdown.Strapdown.HISTORY, self.n_samples + 1, count))
        self._run(key, first, count, history=states, net=net)
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
        net: int = 0,
    ) -> tuple[Array, Array]:
        """Errors (8, count) and linear errors (7, count or 0)."""
        m = self.measurement if disturbed else Measurement.none(self.sensor_errors)
        drawn = strapdown.Strapdown.CONSTANTS + -(-m.coefficients // 4) * 4
        return run(
            self._system(m, disturbed),
            key,
            first,
            count,
            Sensors(self._rows, m.white, m.terms),
            self._kernel_weights if with_linear else None,
            net_normals(key, first, count, net, drawn) if net else None,
            history,
        )

    def _deviations(self, m: Measurement) -> Array:
        """Standard deviations (24,) of the constants, in the kernel's order."""
        deviations = self.initial_deviations.copy()
        deviations[OFFSETS] = m.offsets
        if self.rule != "forward_euler":
            deviations[FIRST] = m.white
        deviations[REST] = [m.means[channel].deviation for channel in FORCE]
        return deviations

    @cached_property
    def _kernel_weights(self) -> LinearWeights:
        """Weights laid out for the kernel: four errors of all channels, three of the turns."""
        w = self.normal_weights
        if self._own is None:
            channels = np.moveaxis(w.samples[:4], 0, 1).reshape(-1, 24)
            turns = np.moveaxis(w.samples[4:][:, :, strapdown.TURNS], 0, 1).reshape(-1, 9)
            samples = np.column_stack([channels, turns])
        else:
            samples = np.moveaxis(w.samples, 0, 1).reshape(-1, 42)
        fixed = strapdown.Strapdown.CONSTANTS
        constants = np.zeros((7, fixed + w.mixing.shape[1]))
        constants[:, :fixed] = self.weights.initial * self.initial_deviations
        constants[:, OFFSETS] = w.offsets
        constants[:, FIRST] = w.samples[:, 0]
        constants[:, REST] = w.levelling[:, FORCE]
        constants[:, fixed:] = w.mixing
        return LinearWeights(samples, constants)


def _angles(truth: SpatialMotion) -> Array:
    attitude = truth.attitude
    return np.stack([attitude.roll, attitude.pitch, attitude.heading])
