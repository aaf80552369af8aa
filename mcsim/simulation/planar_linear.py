"""The planar reconstruction linearised around its undisturbed run.

Every disturbance is a standard normal times its deviation; to first order the end
errors are a weighted sum of them all.  The weights follow from Eq. (2) and (3): an
acceleration acts on velocity from its sample on and on position ever after; a turn
of the heading turns every later acceleration.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.planar import Motion
from mcsim.simulation.lengths import length_quantile, mean_length
from mcsim.simulation.problem import LinearModel

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: Rows of the weights: along, across, heading, course.
ALONG, ACROSS, HEADING, COURSE = range(4)
#: Row of the position error among the errors that are reported.
POSITION = 2
#: Columns of the constants that the kernel draws (see ``mcsim.kernels.planar``).
_SPEED, _DIRECTION, _HEADING, _COURSE = 3, 4, 5, 6
_INITIAL = {
    "initial speed error": _SPEED,
    "initial direction error": _DIRECTION,
    "initial heading error": _HEADING,
    "initial course error": _COURSE,
}


@dataclass(frozen=True)
class Weights:
    """Errors (4: along, across, heading, course) per unit of every disturbance.

    ``samples`` (4, n + 1, 3) per unit of each channel's error at each sample (m/s^2, and
    radian per interval); ``initial`` (4, 4) per unit normal of the initial errors of speed,
    direction, heading and course.
    """

    samples: Array
    initial: Array

    def initial_variances(self) -> Mapping[str, Array]:
        """Variance (4,) of the linear errors by source among the initial errors."""
        return {
            source: self.initial[:, column - _SPEED] ** 2 for source, column in _INITIAL.items()
        }


def linear_weights(
    signals: Array,
    deviations: Array,
    start: Motion,
    interval: float,
    trapezoidal: bool,
    previous_share: float,
) -> Weights:
    """Weights of all disturbances.

    ``signals`` (n + 1, 3) have turns per interval, ``start`` is the motion at sample 0,
    ``deviations`` (4,) those of the initial errors of speed, direction, heading, course.
    """
    n = len(signals) - 1
    share = previous_share if trapezoidal else 0.0
    own_turn = 0.5 if trapezoidal else 1.0
    means = (1.0 - share) * signals[1:] + share * signals[:-1]
    turned = start.heading + np.cumsum(means[:, 2]) - (1.0 - own_turn) * means[:, 2]
    rotation = np.exp(1j * turned)
    acceleration = rotation * (means[:, 0] + 1j * means[:, 1])
    # How long each sample's velocity acts on the position, in intervals.
    acts = n - np.arange(n) - (0.5 if trapezoidal else 0.0)
    direction = np.exp(1j * start.course)
    velocity = start.speed * direction + interval * np.sum(acceleration)

    # Velocity and position at the end per unit mean forward, left acceleration and turn.
    velocity_of = np.empty((n, 3), complex)
    position_of = np.empty((n, 3), complex)
    velocity_of[:, 0] = interval * rotation
    position_of[:, 0] = interval**2 * acts * rotation
    for of in (velocity_of, position_of):
        of[:, 1] = 1j * of[:, 0]
    for of, weight in ((velocity_of, interval), (position_of, interval**2 * acts)):
        turning = 1j * weight * acceleration
        of[:, 2] = _later(turning) + own_turn * turning

    per_mean = _end_errors(position_of, velocity_of, np.array([0.0, 0.0, 1.0]), velocity)
    # A sample counts in the mean of its own interval and of the next.
    per_sample = np.zeros((4, n + 1, 3))
    per_sample[:, 1:] += (1.0 - share) * per_mean
    per_sample[:, :-1] += share * per_mean

    moved = np.array([direction, 1j * start.speed * direction], complex)
    speed, course = _end_errors(moved * complex(n * interval), moved, np.zeros(2), velocity).T
    all_turned = 1j * interval * np.sum(acceleration)
    all_moved = 1j * interval**2 * np.sum(acts * acceleration)
    (heading,) = _end_errors(np.array([all_moved]), np.array([all_turned]), np.ones(1), velocity).T
    initial = np.stack([speed, heading + course, heading, course], axis=1) * deviations
    return Weights(per_sample, initial)


def _later(values: Complex) -> Complex:
    """Sum of all later values, for each."""
    return np.cumsum(values[::-1])[::-1] - values


def _end_errors(position: Complex, velocity: Complex, heading: Array, end: complex) -> Array:
    """Along, across, heading and course errors (4, …) of small changes at the end."""
    course = (velocity / end).imag if end != 0.0 else np.zeros(velocity.shape)
    return np.stack(
        [position.real, position.imag, np.broadcast_to(heading, position.shape), course]
    )


def linear_model(covariance: Array, by_source: Mapping[str, Array], method: Array) -> LinearModel:
    """Moments of the linear along, across, position, heading and course errors.

    ``covariance`` (4, 4) is that of the controls, ``by_source`` the variances (4,) of all that
    disturbs, controlled or not.  The control of the position error is the length of (method
    error + linear error) less that of the method error; its moments follow from the exact
    distribution.
    """
    mean, second = _moments(covariance, method)
    everything = covariance + beyond_controls(covariance, by_source)
    all_mean, all_second = _moments(everything, method)
    centre, plane = np.asarray(method[:2]), everything[:2, :2]
    return LinearModel(
        mean=all_mean,
        second_moment=all_second,
        control_mean=mean,
        control_second_moment=second,
        variances={
            source: np.array([v[ALONG], v[ACROSS], v[ALONG] + v[ACROSS], v[HEADING], v[COURSE]])
            for source, v in by_source.items()
        },
        quantiles={POSITION: lambda p: length_quantile(centre, plane, p)},
    )


def beyond_controls(covariance: Array, by_source: Mapping[str, Array]) -> Array:
    """What the sources have beyond the controls' covariance; taken as uncorrelated."""
    total = np.sum(list(by_source.values()), axis=0)
    beyond = total - np.diag(covariance)
    return np.diag(np.where(beyond > 1e-9 * total, beyond, 0.0))


def _moments(covariance: Array, method: Array) -> tuple[Array, Array]:
    """Mean and second moment (5,) of the reported errors less the method's."""
    mean, second = np.zeros(5), np.empty(5)
    second[[0, 1, 3, 4]] = np.diag(covariance)[[ALONG, ACROSS, HEADING, COURSE]]
    plane = covariance[:2, :2]
    offset = float(np.hypot(method[0], method[1]))
    length = mean_length(method[:2], plane)
    mean[POSITION] = length - offset
    second[POSITION] = 2.0 * offset**2 + np.trace(plane) - 2.0 * offset * length
    return mean, second
