"""The planar reconstruction linearised around its undisturbed run.

Every disturbance is a standard normal times its deviation; to first order the end
errors are a weighted sum of them all.  The weights follow from Eq. (2) and (3): an
acceleration acts on velocity from its sample on and on position ever after; a turn
of the heading turns every later acceleration.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.planar import Motion, Planar
from mcsim.simulation.linear_errors import Weights

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def linear_weights(
    signals: Array,
    start: Motion,
    interval: float,
    trapezoidal: bool,
    previous_share: float,
) -> Weights:
    """Weights of all disturbances.

    ``signals`` (n + 1, 3) have turns per interval, ``start`` is the motion at sample 0.
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
    constants = np.zeros((4, Planar.CONSTANTS))
    # Offsets come first, then speed, direction, heading and course.
    constants[:, 3:7] = np.stack([speed, heading + course, heading, course], axis=1)
    return Weights.without_rest(per_sample, constants)


def _later(values: Complex) -> Complex:
    """Sum of all later values, for each."""
    return np.cumsum(values[::-1])[::-1] - values


def _end_errors(position: Complex, velocity: Complex, heading: Array, end: complex) -> Array:
    """Along, across, course and heading errors (4, …) of small changes at the end."""
    course = (velocity / end).imag if end != 0.0 else np.zeros(velocity.shape)
    return np.stack(
        [position.real, position.imag, course, np.broadcast_to(heading, position.shape)]
    )
