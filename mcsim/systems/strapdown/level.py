"""The planar algorithm on a vehicle that leans: three channels, taken for level.

It is the planar case's own kernel on the strapdown case's truth, so that both algorithms
reconstruct the same drive from the same random numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from mcsim.sensor_terms.mechanisms.mixing import Mixing
from mcsim.sensors.error_model import channel_errors, per_interval
from mcsim.simulation.lengths import length_quantile
from mcsim.simulation.limits import duration_limits
from mcsim.simulation.linear_errors import beyond_controls, length_moments
from mcsim.simulation.planar import CHANNELS, PlanarProblem, initial_deviations
from mcsim.simulation.planar_samples import course_missing, planned, wrap
from mcsim.simulation.problem import Array, History, Limit, LinearModel, Sample
from mcsim.systems.strapdown.constants import signals_at_rest, tilt_deviations
from mcsim.systems.strapdown.problem import CHANNELS as ALL_CHANNELS
from mcsim.systems.strapdown.problem import RATES as ALL_RATES
from mcsim.systems.strapdown.samples import sampled
from mcsim.systems.strapdown.scenario import StrapdownScenario
from mcsim.systems.strapdown.truth import SpatialMotion, spatial_drive
from mcsim.trajectory import Motion

#: Places of the planar errors (along, across, position, heading, course) among the eight.
_PLANAR = [0, 1, 3, 6, 7]
_POSITION = 3
#: The channel of the force upwards, and the name of an unknown tilt in budgets.
_UP, TILT = 3, "initial tilt error"
#: Places of roll and pitch among the eight errors.
_ANGLES = [4, 5]
#: Which of the unseen errors (height, roll, pitch) goes with the gravity that the forward and
#: the left channel see, and its sign: the left side up is felt to the left, the nose down
#: backwards, and the algorithm takes both for zero.
_ERROR_BY_TILT = {0: (2, 1.0), 1: (1, -1.0)}


@dataclass(frozen=True)
class LevelProblem:
    """A planar problem, and the attitude and height that it knows nothing of.

    Roll and pitch are taken for zero, the height for that of the start; ``truth`` is the true
    motion at the samples 0 ... n.  The vehicle may be tilted beyond that, unknown to anybody:
    then its sensors show gravity, as a coefficient of the force upwards.
    """

    planar: PlanarProblem
    truth: SpatialMotion
    error_names: tuple[str, ...] = StrapdownScenario.ERRORS
    percentiles: tuple[float, ...] = StrapdownScenario.PERCENTILES

    @classmethod
    def from_model(cls, model: StrapdownScenario, folder: Path) -> LevelProblem:
        """Truth, sampling and error model of one point.

        Raises
        ------
        InputError
            No such track, or one that is shorter than a sample or absurdly long.
        """
        drive = spatial_drive(model, folder)
        sensors = model.sensors
        duration, further = drive.drive.duration, ALL_CHANNELS[len(CHANNELS) :]
        at_rest = signals_at_rest(drive.at_rest(-drive.drive.lead))
        errors = channel_errors(sensors, CHANNELS, duration, at_rest, further)
        errors = replace(errors, mixing=(*_tilts(model), *errors.mixing))
        everything = channel_errors(sensors, ALL_CHANNELS, duration, at_rest)
        errors = per_interval(errors, ALL_RATES, 1.0 / sensors.rate)
        plan = planned(drive.drive, sensors, folder, model.reconstruction.intervals)
        errors = replace(errors, schedule=plan)
        samples = sampled(
            drive,
            sensors.rate,
            sensors.sampling,
            everything.filters,
            plan.instants,
            sensors.time.latency,
        )
        planar = PlanarProblem(
            # The algorithm reads three channels; the others show in them by misalignment.
            signals=errors.with_columns(samples.signals),
            sensor_errors=errors,
            initial_deviations=initial_deviations(model.initial),
            truth=_flat(samples.truth, samples.signals),
            interval=1.0 / sensors.rate,
            rule=model.reconstruction.integration,
            previous_share=0.0 if sensors.sampling == "average" else 0.5,
            missing=course_missing(drive.drive),
            beyond_rate=samples.beyond_rate[: len(CHANNELS)],
        )
        return cls(planar, samples.truth)

    @property
    def missing(self) -> Mapping[str, str]:
        return self.planar.missing

    @property
    def n_samples(self) -> int:
        return self.planar.n_samples

    @cached_property
    def _unseen(self) -> Array:
        """Errors (3, n + 1) of height, roll and pitch: what the algorithm takes for zero."""
        height = self.truth.position[2]
        attitude = self.truth.attitude
        return np.stack([height[0] - height, -attitude.roll, -attitude.pitch])

    def method_errors(self) -> Array:
        return self._complete(self.planar.method_errors()[:, None], self._unseen[:, -1:])[:, 0]

    @staticmethod
    def _complete(planar: Array, unseen: Array) -> Array:
        """Eight errors from the planar five and the three unseen ones."""
        errors = np.empty((len(StrapdownScenario.ERRORS), *planar.shape[1:]))
        errors[_PLANAR] = planar
        errors[[2, 4, 5]] = unseen
        errors[_POSITION] = np.sqrt(errors[0] ** 2 + errors[1] ** 2 + errors[2] ** 2)
        return errors

    def _tilted(self, key: int, first: int, count: int, net: int = 0) -> Array:
        """What the unknown tilt of each realization adds to the unseen errors (3, count)."""
        added = np.zeros((3, count))
        mixing = self.planar.sensor_errors.mixing
        if not any(m.term == TILT for m in mixing):
            return added
        normals = self.planar.mixing_normals(key, first, count, net)
        for entry, normal in zip(mixing, normals, strict=True):
            if entry.term == TILT:
                row, sign = _ERROR_BY_TILT[entry.target]
                added[row] += sign * entry.deviation * normal
        return added

    def simulate(
        self, key: int, first: int, count: int, controls: bool = False, net: int = 0
    ) -> Sample:
        sample = self.planar.simulate(key, first, count, controls, net)
        tilted = self._tilted(key, first, count, net)
        errors = self._complete(sample.errors, self._unseen[:, -1:] + tilted)
        errors[_ANGLES] = wrap(errors[_ANGLES])
        if not controls:
            return Sample(errors, sample.controls)
        method = self.method_errors()
        linear = np.zeros_like(errors)
        linear[_PLANAR] = sample.controls
        linear[_ANGLES] = tilted[1:]
        place = method[:3, None] + linear[:3]
        linear[_POSITION] = np.sqrt(np.sum(place**2, axis=0)) - method[_POSITION]
        return Sample(errors, linear)

    @cached_property
    def linear(self) -> LinearModel:
        planar, method = self.planar.linear, self.method_errors()
        controls = self.planar.control_covariance
        everything = controls + beyond_controls(controls, self.planar.variances_by_source)
        place = _in_space(everything)
        mean, second = _complete_moments(planar.mean, planar.second_moment, method, place)
        of_tilt = self._tilt_variances()
        second[_ANGLES] = of_tilt
        control_mean, control_second = _complete_moments(
            planar.control_mean, planar.control_second_moment, method, _in_space(controls)
        )
        control_second[_ANGLES] = of_tilt
        variances = {source: np.zeros(8) for source in planar.variances}
        for source, variance in planar.variances.items():
            variances[source][_PLANAR] = variance
        if TILT in variances:
            variances[TILT][_ANGLES] = of_tilt
        return LinearModel(
            mean,
            second,
            control_mean,
            control_second,
            variances,
            {_POSITION: lambda p: length_quantile(method[:3], place, p)},
            spike_events=self._complete_events(),
        )

    def _tilt_variances(self) -> Array:
        """Variances (2,) of the errors of roll and pitch by the unknown tilt."""
        variances = np.zeros(3)
        for entry in self.planar.sensor_errors.mixing:
            if entry.term == TILT:
                variances[_ERROR_BY_TILT[entry.target][0]] += entry.deviation**2
        return variances[1:]

    def _complete_events(self) -> Array:
        events = np.zeros(8)
        events[_PLANAR] = self.planar.linear.spike_events
        return events

    def limits(self, key: int, count: int) -> tuple[Limit, ...]:
        duration = self.n_samples * self.planar.interval
        return (*self.planar.limits(key, count), *duration_limits(duration))

    def history(self, key: int, first: int, count: int, net: int = 0) -> History:
        history = self.planar.history(key, first, count, net)
        unseen = self._unseen[:, :, None] + self._tilted(key, first, count, net)[:, None, :]
        errors = self._complete(history.errors, unseen)
        errors[_ANGLES] = wrap(errors[_ANGLES])
        return History(history.time, history.tracks, history.truth, errors)


def _tilts(model: StrapdownScenario) -> list[Mixing]:
    """What an unknown tilt of the vehicle, which is taken for level, makes of the force upwards."""
    roll, pitch = tilt_deviations(model)
    tilts = [Mixing(0, _UP, pitch, TILT), Mixing(1, _UP, roll, TILT)]
    return [tilt for tilt in tilts if tilt.deviation > 0.0]


def _in_space(covariance: Array) -> Array:
    """Covariance (3, 3) of along, across and height, which no sensor disturbs."""
    place = np.zeros((3, 3))
    place[:2, :2] = covariance[:2, :2]
    return place


def _complete_moments(
    mean: Array, second: Array, method: Array, place: Array
) -> tuple[Array, Array]:
    """Moments (8,) from those of the five planar errors; the position's are in space."""
    means, seconds = np.zeros(8), np.zeros(8)
    means[_PLANAR], seconds[_PLANAR] = mean, second
    means[_POSITION], seconds[_POSITION] = length_moments(method[:3], place)
    return means, seconds


def _flat(truth: SpatialMotion, signals: Array) -> Motion:
    """The level frame's motion as the planar case holds it."""
    heading = np.unwrap(wrap(truth.attitude.heading))
    return Motion(
        along=truth.position[0],
        across=truth.position[1],
        velocity_along=truth.velocity[0],
        velocity_across=truth.velocity[1],
        heading=heading,
        forward=signals[:, 0],
        left=signals[:, 1],
        yaw_rate=signals[:, 2],
    )
