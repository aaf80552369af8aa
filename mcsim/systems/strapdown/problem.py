"""The strapdown case: a scenario's point as arrays for the strapdown kernel."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from mcsim.kernels import strapdown
from mcsim.sensor_terms.channel import ACCELEROMETER, GYROSCOPE, Channel
from mcsim.sensors.error_model import channel_errors, per_interval
from mcsim.sensors.measurement import AtRest, Measurement, NormalWeights
from mcsim.simulation.limits import duration_limits, passing, pitch_limits, tilt_limits
from mcsim.simulation.linear_errors import Weights
from mcsim.simulation.own import own_system
from mcsim.simulation.planar import CHANNELS as PLANAR_CHANNELS
from mcsim.simulation.planar import SIGNAL_NAMES
from mcsim.simulation.planar_samples import course_missing, wrap
from mcsim.simulation.problem import Array, History, Limit, LinearModel
from mcsim.simulation.reckoning import Description, Reckoning
from mcsim.systems.strapdown.constants import (
    DEVIATIONS,
    FORCE,
    INITIAL,
    REST,
    initial_deviations,
    signals_at_rest,
)
from mcsim.systems.strapdown.linear import linear_weights
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
_STILL = 1e-9
#: Linear errors that all channels act on; the others, of the attitude, have turns alone.
_MOVED = 4
DESCRIPTION = Description(
    errors=StrapdownScenario.ERRORS,
    signals=(*SIGNAL_NAMES, "upward acceleration", "roll rate", "pitch rate"),
    lengths={"position": ("along", "across", "height")},
    wrapping=("roll", "heading", "course"),
    initial=INITIAL,
)


@dataclass(frozen=True, kw_only=True)
class StrapdownProblem(Reckoning):
    """The strapdown system; see ``mcsim.kernels.strapdown.Strapdown``.

    ``truth`` is the true motion at the samples 0 ... n, ``rest`` (3,) the specific force at rest
    (m/s^2), from which roll and pitch are ``levelled``.
    """

    truth: SpatialMotion
    rest: Array
    levelled: bool
    gravity: float
    rule: str
    previous_share: float

    @property
    def description(self) -> Description:
        return DESCRIPTION

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
        samples = sampled(drive, sensors.rate, sensors.sampling, errors.filters)
        errors = per_interval(errors, RATES, 1.0 / sensors.rate)
        return cls(
            signals=errors.with_columns(samples.signals),
            sensor_errors=errors,
            initial_deviations=initial_deviations(model),
            truth=samples.truth,
            rest=rest,
            levelled=levelling is not None,
            gravity=model.body.local_gravity,
            interval=1.0 / sensors.rate,
            rule=model.reconstruction.integration,
            previous_share=0.0 if sensors.sampling == "average" else 0.5,
            missing=course_missing(drive.drive),
            beyond_rate=samples.beyond_rate,
        )

    @property
    def _own(self) -> type[Any] | None:
        """The system of a user's own rule."""
        return own_system("strapdown", self.rule)

    @property
    def kernel(self) -> Any:
        return self._own or strapdown.Strapdown

    @cached_property
    def weights(self) -> Weights:
        if self._own is not None:
            # What levels is taken from the motion that the rule makes.
            return super().weights
        return linear_weights(
            self.rows,
            self._start,
            self.rest,
            self.levelled,
            self.gravity,
            self.interval,
            self.rule,
            self.previous_share,
        )

    def laid_out(self, samples: Array) -> Array:
        """All channels act on place and course, turns alone on the attitude."""
        if self._own is not None:
            return super().laid_out(samples)
        turns = samples[_MOVED:][:, :, strapdown.TURNS]
        return np.column_stack([super().laid_out(samples[:_MOVED]), super().laid_out(turns)])

    @cached_property
    def at_rest(self) -> AtRest:
        return AtRest(self.weights.at_rest)

    @cached_property
    def rows(self) -> Array:
        """The samples as the integrator takes them: the forward Euler rule is one behind."""
        if self.rule != "forward_euler":
            return self.signals
        return np.concatenate([self.signals[:1], self.signals[:-1]])

    @property
    def first(self) -> int:
        return 1 if self.rule == "forward_euler" else 0

    @cached_property
    def linear(self) -> LinearModel:
        model = super().linear
        return replace(model, flips=self._flips(model))

    def _flips(self, model: LinearModel) -> Array:
        """Share (8,) of realizations whose pitch passes 90°: roll and heading jump there."""
        names, pitch = self.error_names, float(self.truth.attitude.pitch[-1])
        flips = np.zeros(len(names))
        deviation = float(model.spread[names.index("pitch")])
        beyond = passing(0.5 * np.pi, pitch, deviation)
        flips[[names.index("roll"), names.index("heading")]] = beyond
        return flips

    def further_limits(self, key: int, count: int) -> Iterator[Limit]:
        place = self.error_names.index("pitch")
        pitch = self.truth.attitude.pitch
        ends = pitch[-1] + self.simulate(key, 0, count).errors[place]
        offsets = self.sensor_errors.offsets
        level = float(np.max(offsets[:2])) / self.gravity if self.levelled else 0.0
        yield from duration_limits(self.n_samples * self.interval)
        yield from tilt_limits(level)
        yield from pitch_limits(pitch, ends, float(self.linear.spread[place]))

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

    def system(self, measurement: Measurement, disturbed: bool) -> Any:
        m, end = measurement, self._motion(-1)
        if "course" in self.missing:
            end = end._replace(course=math.nan)
        fixed = self.deviations(m, disturbed)
        second_order = self.rule in ("trapezoidal", "two_sample")
        turns = [m.largest(self.signals, turn) for turn in strapdown.TURNS]
        return self.kernel(
            way=0 if self._own else strapdown.way_of(self.rule, float(np.linalg.norm(turns))),
            interval=self.interval,
            gravity=self.gravity,
            previous_share=self.previous_share if second_order else 0.0,
            coning=1.0 / 12.0 if self.rule == "two_sample" else 0.0,
            draws=self.levelled or bool(self._own) or bool(np.any(fixed)),
            levelled=self.levelled,
            rest=strapdown.Force(*map(float, self.rest)),
            deviations=strapdown.Deviations(*map(float, fixed[DEVIATIONS])),
            start=self._start,
            end=end,
        )

    def deviations(self, measurement: Measurement, disturbed: bool) -> Array:
        deviations = super().deviations(measurement, disturbed)
        if disturbed:
            if self.rule != "forward_euler":
                deviations[self.first_noise] = measurement.white
            deviations[REST] = [measurement.means[channel].deviation for channel in FORCE]
        return deviations

    def add_levelling(self, weights: NormalWeights, constants: Array) -> None:
        constants[:, REST] = weights.levelling[:, FORCE]

    def history(self, key: int, first: int, count: int, net: int = 0) -> History:
        states, truth = self.states(key, first, count, net), self.truth
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


def _angles(truth: SpatialMotion) -> Array:
    attitude = truth.attitude
    return np.stack([attitude.roll, attitude.pitch, attitude.heading])
