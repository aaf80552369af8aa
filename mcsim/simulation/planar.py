"""The planar algorithm on arrays: of the planar case, and of a vehicle that leans."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from mcsim.kernels import planar
from mcsim.scenario.case import CaseScenario
from mcsim.scenario.initial import Initial
from mcsim.sensor_terms.channel import ACCELEROMETER, GYROSCOPE, Channel
from mcsim.sensors.error_model import ChannelErrors
from mcsim.sensors.measurement import Measurement, NormalWeights
from mcsim.simulation.limits import angle_limits, rate_limits, sensor_limits, units_of
from mcsim.simulation.nets import net_normals
from mcsim.simulation.own import own_system
from mcsim.simulation.planar_linear import (
    ACROSS,
    ALONG,
    COURSE,
    HEADING,
    Weights,
    linear_model,
    linear_weights,
)
from mcsim.simulation.planar_samples import wrap
from mcsim.simulation.problem import Array, History, Limit, LinearModel, Sample
from mcsim.simulation.running import LinearWeights, Sensors, adjoint_weights, run
from mcsim.trajectory import Motion

#: Forward and left acceleration, yaw rate.
CHANNELS = (Channel(ACCELEROMETER, 0), Channel(ACCELEROMETER, 1), Channel(GYROSCOPE, 2))
RATES = (False, False, True)
SIGNAL_NAMES = ("forward acceleration", "left acceleration", "yaw rate")


@dataclass(frozen=True)
class PlanarProblem:
    """Arrays and numbers of the planar system; see ``mcsim.kernels.planar.Planar``.

    ``signals`` (n + 1, 3) and all sensor errors hold turns per interval in the place of yaw
    rates; further columns are channels that show in the three by misalignment; of each
    ``beyond_rate`` (c,) is the share of power that the rate does not hold.
    ``initial_deviations`` (4,) are those of speed, direction, heading and course; ``truth`` is
    the true motion at the samples 0 ... n.
    """

    signals: Array
    initial_deviations: Array
    sensor_errors: ChannelErrors
    truth: Motion
    interval: float
    rule: str
    previous_share: float
    missing: Mapping[str, str]
    beyond_rate: Array = field(default_factory=lambda: np.zeros(3))
    error_names: tuple[str, ...] = ("along", "across", "position", "heading", "course")
    percentiles: tuple[float, ...] = CaseScenario.PERCENTILES

    @property
    def n_samples(self) -> int:
        return len(self.signals) - 1

    @cached_property
    def weights(self) -> Weights:
        """First-order weights of all disturbances."""
        if self._own is not None:
            return self._own_weights()
        return linear_weights(
            self.signals,
            self.initial_deviations,
            self._start,
            self.interval,
            self.rule == "trapezoidal",
            self.previous_share,
        )

    @cached_property
    def measurement(self) -> Measurement:
        """The sensor errors as the kernel takes them."""
        return Measurement.of(self.sensor_errors, self.signals, self.interval)

    @cached_property
    def normal_weights(self) -> NormalWeights:
        """Linear errors per unit normal of the sensors' random numbers."""
        return self.measurement.fold(self.weights.samples, self.signals)

    @cached_property
    def control_covariance(self) -> Array:
        """Covariance (4, 4) of the linear errors that the controls hold."""
        initial = self.weights.initial
        return self.normal_weights.covariance + initial @ initial.T

    @cached_property
    def variances_by_source(self) -> Mapping[str, Array]:
        """Variance (4,) of the linear errors by source."""
        return {
            **self.measurement.variances(self.weights.samples, self.signals),
            **self.weights.initial_variances(),
        }

    @cached_property
    def linear(self) -> LinearModel:
        model = linear_model(
            self.control_covariance, self.variances_by_source, self.method_errors()
        )
        return replace(model, spike_events=self._spike_events)

    @cached_property
    def _spike_events(self) -> Array:
        """Spikes per realization (5,); those of the position are of the rarer component's."""
        along, across, heading, course = self.measurement.spike_events(self.weights.samples)
        return np.array([along, across, rarer(along, across), heading, course])

    def limits(self, key: int, count: int) -> tuple[Limit, ...]:
        errors, linear = self.sensor_errors, self.linear
        return (
            *sensor_limits(
                self.measurement,
                self.signals,
                units_of(errors, self.interval),
                self.interval,
                lambda m: self.measured_by(m).simulate(key, 0, count).errors,
            ),
            *rate_limits(self.beyond_rate, 1.0 / self.interval, SIGNAL_NAMES),
            *angle_limits(
                self.error_names, ("heading", "course"), self.method_errors(), linear.spread
            ),
        )

    def measured_by(self, measurement: Measurement) -> PlanarProblem:
        """The same problem with other sensors."""
        other = replace(self)
        other.__dict__["measurement"] = measurement
        return other

    @property
    def _own(self) -> type[Any] | None:
        """The system of a user's own rule."""
        return own_system("planar", self.rule)

    def _own_weights(self) -> Weights:
        """Weights from the rule's own steps, in the order along, across, heading, course."""
        system = self._system(Measurement.none(self.sensor_errors), disturbed=False)
        samples, constants = adjoint_weights(system, self.signals)
        rows = [0, 1, 3, 2]
        initial = constants[rows, 3:7] * self.initial_deviations
        return Weights(np.ascontiguousarray(samples[rows]), initial)

    @cached_property
    def _start(self) -> planar.Motion:
        return self._motion(0)

    def _motion(self, sample: int) -> planar.Motion:
        """The true motion at a sample."""
        t = self.truth
        rows = (t.along, t.across, t.speed, t.heading, t.course)
        return planar.Motion(*(float(row[sample]) for row in rows))

    def _system(self, m: Measurement, disturbed: bool) -> planar.Planar:
        """The numbers of the system, with a measurement's offsets."""
        end = self._motion(-1)
        if "course" in self.missing:
            end = end._replace(course=math.nan)
        initial = self.initial_deviations if disturbed else np.zeros(4)
        deviations = planar.Deviations(*map(float, (*m.offsets, *initial)))
        trapezoidal = self.rule == "trapezoidal"
        way = planar.way_of(
            trapezoidal, m.largest(self.signals, 2), offsets=bool(np.any(m.offsets))
        )
        kind: type[planar.Planar] = self._own or planar.Planar
        return kind(
            way=0 if self._own else way,
            interval=self.interval,
            previous_share=self.previous_share,
            # The trapezoidal rule uses the noise of sample 0, and so may others.
            draws=trapezoidal or bool(self._own) or any(deviations),
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
        """Controls (5, r) from linear errors (4, r)."""
        method = self.method_errors()
        along, across, course, heading = linear
        length = np.hypot(method[0] + along, method[1] + across)
        return np.stack([along, across, length - math.hypot(*method[:2]), heading, course])

    def history(self, key: int, first: int, count: int, net: int = 0) -> History:
        states = np.empty((planar.Planar.HISTORY, self.n_samples + 1, count))
        self._run(key, first, count, history=states, net=net)
        truth = self.truth
        along = states[0] - truth.along[:, None]
        across = states[1] - truth.across[:, None]
        course = np.arctan2(states[3], states[2]) - truth.course[:, None]
        course[truth.speed < _still(truth)] = np.nan
        if self.missing:
            course[-1] = np.nan
        return History(
            time=np.arange(self.n_samples + 1, dtype=float) * self.interval,
            tracks=states[:2],
            truth=np.stack([truth.along, truth.across]),
            errors=np.stack(
                [
                    along,
                    across,
                    np.hypot(along, across),
                    wrap(states[4] - truth.heading[:, None]),
                    wrap(course),
                ]
            ),
        )

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
        """Errors (5, count) and linear errors (4, count or 0)."""
        m = self.measurement if disturbed else Measurement.none(self.sensor_errors)
        return run(
            self._system(m, disturbed),
            key,
            first,
            count,
            Sensors(self.signals, m.white, m.terms),
            self._kernel_weights if with_linear else None,
            net_normals(key, first, count, net, self._drawn(m)) if net else None,
            history,
        )

    @staticmethod
    def _drawn(measurement: Measurement) -> int:
        """Normals that the kernel draws once per realization."""
        return -(-(planar.Planar.CONSTANTS + measurement.coefficients) // 4) * 4

    def mixing_normals(self, key: int, first: int, count: int, net: int = 0) -> Array:
        """The normals (m, count) of the mixing coefficients of some realizations."""
        from mcsim.kernels.constants import constants_of

        drawn = self._drawn(self.measurement)
        if net:
            normals = net_normals(key, first, count, net, drawn)
        else:
            normals = np.empty((drawn, count), np.float32)
            constants_of(np.uint64(key), np.uint64(first), normals)
        entries = len(self.sensor_errors.mixing)
        fixed = planar.Planar.CONSTANTS
        return normals[fixed : fixed + entries].astype(float)

    @cached_property
    def _kernel_weights(self) -> LinearWeights:
        """Weights of along, across, course and heading, laid out for the kernel."""
        fixed = planar.Planar.CONSTANTS
        rows = [ALONG, ACROSS, COURSE, HEADING]
        w = self.normal_weights
        # Sample 0 is among the constants.
        if self._own is None:
            nine = np.moveaxis(w.samples[rows[:3]], 0, 1).reshape(-1, 9)
            samples = np.column_stack([nine, w.samples[HEADING, :, 2]])
        else:
            samples = np.moveaxis(w.samples[rows], 0, 1).reshape(-1, 12)
        constants = np.zeros((4, fixed + w.mixing.shape[1]))
        constants[:, :3] = w.offsets[rows]
        constants[:, 3:7] = self.weights.initial[rows]
        constants[:, 8:11] = w.samples[rows, 0]
        constants[:, fixed:] = w.mixing[rows]
        return LinearWeights(samples, constants)


def initial_deviations(initial: Initial) -> Array:
    """Standard deviations (4,) of the initial speed, direction, heading and course."""
    return np.array(
        [
            initial.speed_error,
            initial.direction_error,
            initial.heading_error,
            initial.course_error,
        ]
    )


def rarer(*events: float) -> float:
    """The least number of spikes per realization of some components that have any."""
    return min((e for e in events if e > 0.0), default=0.0)


def _still(truth: Motion) -> float:
    """Speed below which a vehicle counts as standing."""
    return 1e-9 * float(np.max(truth.speed))
