"""The strapdown reconstruction linearised around its undisturbed run.

To first order the end errors are a weighted sum of all disturbances.  A disturbed turn tilts
every later attitude by ``eps``, a rotation vector in the level frame, and with it every later
acceleration by ``eps x a``, gravity's reaction included: so does the initial attitude.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels.strapdown import (
    COURSE,
    DIRECTION,
    HEADING,
    PITCH,
    ROLL,
    SPEED,
    Motion,
    Strapdown,
)
from mcsim.simulation.linear_errors import Weights
from mcsim.trajectory.attitude import euler_angles, rotation_matrix

Array = NDArray[np.float64]

#: Channels of specific force and of turns about the forward, left and up axis.
_FORCE, _TURN = [0, 1, 3], [4, 5, 2]


@dataclass(frozen=True)
class _Interval:
    """What the integrator makes of the samples in each of n intervals.

    ``force`` and ``turn`` (n, 3); ``of_previous`` and ``of_own`` (n, 6, 6): derivatives of
    (force, turn) with respect to the previous and the own sample's.
    """

    force: Array
    turn: Array
    of_previous: Array
    of_own: Array


def linear_weights(
    signals: Array,
    start: Motion,
    rest: Array,
    levelled: bool,
    gravity: float,
    interval: float,
    rule: str,
    previous_share: float,
) -> Weights:
    """Weights of all disturbances.

    ``signals`` (n + 1, 6) as the rule takes them, ``start`` the motion at sample 0, ``rest`` (3,)
    the specific force at rest.
    """
    n = len(signals) - 1
    means = _means(signals, rule, previous_share)
    matrices = _attitudes(means.turn, start)
    acting, own = _acting(matrices, means.turn, rule)
    force = np.einsum("nij,nj->ni", acting, means.force)
    late = {"rectangular": 0.0, "forward_euler": 1.0}.get(rule, 0.5)
    # How long each interval's velocity acts on the position, in intervals.
    acts = n - np.arange(n) - late
    velocity = _velocity(start) + interval * np.sum(force, axis=0)
    velocity[2] -= interval * n * gravity

    after = matrices[1:] @ _jacobian(means.turn)
    moved = []
    for weight in (interval * np.ones(n), interval**2 * acts):
        of_force = weight[:, None, None] * acting
        pushes = weight[:, None] * force
        of_turn = -_skew(_later(pushes)) @ after - _skew(pushes) @ own
        moved.append(np.concatenate([of_force, of_turn], axis=2))
    tilted = np.concatenate([np.zeros((n, 3, 3)), after], axis=2)
    at_end = _EndErrors(velocity, matrices[-1])
    per_mean = at_end.of(moved[1], moved[0], tilted)  # (n, 7, 6)

    per_sample = np.zeros((n + 1, 7, 6))
    per_sample[1:] += per_mean @ means.of_own
    per_sample[:-1] += per_mean @ means.of_previous
    samples = np.zeros((7, n + 1, 6))
    samples[:, :, [*_FORCE, *_TURN]] = np.moveaxis(per_sample, 0, 1)

    constants = np.zeros((7, Strapdown.CONSTANTS))
    at_rest = np.zeros((7, 6))
    all_pushes = [interval * force.sum(axis=0), interval**2 * (acts[:, None] * force).sum(axis=0)]
    axes = _euler_axes(start.pitch, start.heading)
    by_tilt = at_end.of(-_skew(all_pushes[1]) @ axes, -_skew(all_pushes[0]) @ axes, axes)
    constants[:, [ROLL, PITCH, HEADING]] = by_tilt
    moving = _velocity_derivatives(start)
    by_start = at_end.of(moving * (n * interval), moving, np.zeros((3, 2)))
    constants[:, [SPEED, COURSE]] = by_start
    constants[:, DIRECTION] = by_start[:, 1] + by_tilt[:, 2]
    if levelled:
        at_rest[:, _FORCE] = by_tilt[:, :2] @ _levelling(rest)
    return Weights(samples, constants, at_rest)


def _means(signals: Array, rule: str, previous_share: float) -> _Interval:
    """Means over the intervals, with coning and sculling where the integrator has them."""
    share = 0.0 if rule in ("rectangular", "forward_euler") else previous_share
    force, turn = signals[:, _FORCE], signals[:, _TURN]
    n = len(signals) - 1
    both = np.broadcast_to(np.eye(6), (n, 6, 6))
    of_previous, of_own = share * both, (1.0 - share) * both
    mean_force = (1.0 - share) * force[1:] + share * force[:-1]
    mean_turn = (1.0 - share) * turn[1:] + share * turn[:-1]
    if rule == "two_sample":
        f0, f1, w0, w1 = force[:-1], force[1:], turn[:-1], turn[1:]
        mean_force = mean_force + (np.cross(w0, f1) + np.cross(f0, w1)) / 12.0
        mean_turn = mean_turn + np.cross(w0, w1) / 12.0
        of_own = of_own + _stacked(_skew(w0), _skew(f0), _skew(w0)) / 12.0
        of_previous = of_previous - _stacked(_skew(w1), _skew(f1), _skew(w1)) / 12.0
    return _Interval(mean_force, mean_turn, of_previous, of_own)


def _stacked(force_force: Array, force_turn: Array, turn_turn: Array) -> Array:
    """Matrices (n, 6, 6) of four blocks; the force never acts on the turn."""
    zero = np.zeros_like(turn_turn)
    return np.concatenate(
        [
            np.concatenate([force_force, force_turn], axis=2),
            np.concatenate([zero, turn_turn], axis=2),
        ],
        axis=1,
    )


def _attitudes(turn: Array, start: Motion) -> Array:
    """Matrices (n + 1, 3, 3) at the samples."""
    steps = _rotations(turn)
    matrices = np.empty((len(turn) + 1, 3, 3))
    matrices[0] = rotation_matrix(*np.array([start.roll, start.pitch, start.heading]))
    for i in range(len(turn)):
        matrices[i + 1] = matrices[i] @ steps[i]
    return matrices


def _acting(matrices: Array, turn: Array, rule: str) -> tuple[Array, Array]:
    """Matrices that turn each interval's force, and the tilt (n, 3, 3) of each by its own turn."""
    if rule == "rectangular":
        return matrices[1:], matrices[1:] @ _jacobian(turn)
    if rule == "forward_euler":
        return matrices[:-1], np.zeros_like(matrices[:-1])
    middle = matrices[:-1] @ _rotations(0.5 * turn)
    return middle, 0.5 * middle @ _jacobian(0.5 * turn)


def _rotations(turn: Array) -> Array:
    """Rotation matrices (n, 3, 3) of rotation vectors (n, 3): Rodrigues' formula."""
    skew = _skew(turn)
    angle = np.linalg.norm(turn, axis=1)[:, None, None]
    # sin(a) / a and (1 - cos(a)) / a^2, also for a = 0.
    first, second = np.sinc(angle / np.pi), 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    return np.eye(3) + first * skew + second * skew @ skew


def _jacobian(turn: Array) -> Array:
    """Right Jacobians (n, 3, 3): exp(turn + d) = exp(turn) exp(J d) to first order."""
    skew = _skew(turn)
    angle = np.linalg.norm(turn, axis=1)[:, None, None]
    half = 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    with np.errstate(invalid="ignore", divide="ignore"):
        third = np.where(angle > 1e-3, (1.0 - np.sinc(angle / np.pi)) / angle**2, 1 / 6)
    return np.eye(3) - half * skew + third * skew @ skew


def _skew(v: Array) -> Array:
    """Matrices (…, 3, 3) of the vector product: skew(v) u = v x u."""
    x, y, z = np.moveaxis(v, -1, 0)
    o = np.zeros_like(x)
    rows = [[o, -z, y], [z, o, -x], [-y, x, o]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _later(values: Array) -> Array:
    """Sum of all later values, for each."""
    return np.cumsum(values[::-1], axis=0)[::-1] - values


def _velocity(start: Motion) -> Array:
    speed, climb, course = start.speed, start.climb, start.course
    return speed * np.array(
        [np.cos(climb) * np.cos(course), np.cos(climb) * np.sin(course), np.sin(climb)]
    )


def _velocity_derivatives(start: Motion) -> Array:
    """Initial velocity (3, 2) per speed and per course error."""
    speed, climb, course = start.speed, start.climb, start.course
    c, s, k = np.cos(course), np.sin(course), np.cos(climb)
    return np.array([[k * c, -speed * k * s], [k * s, speed * k * c], [np.sin(climb), 0.0]])


def _euler_axes(pitch: float, heading: float) -> Array:
    """Tilt (3, 3) in the level frame per roll, pitch and heading."""
    cp, sp, ch, sh = np.cos(pitch), np.sin(pitch), np.cos(heading), np.sin(heading)
    return np.array([[ch * cp, -sh, 0.0], [sh * cp, ch, 0.0], [-sp, 0.0, 1.0]])


def levelled_by_force(constants: Array, rest: Array) -> Array:
    """Errors (7, 3) per mean specific force that levels, from those (7, k) of what is drawn once.

    A force moves the initial roll and pitch, whose weights are among the constants'.
    """
    return np.asarray(constants[:, [ROLL, PITCH]] @ _levelling(rest), float)


def _levelling(rest: Array) -> Array:
    """Roll and pitch (2, 3) per specific force at rest: forward, left, up."""
    f, g, h = rest
    across = np.hypot(g, h)
    if across == 0.0:
        return np.zeros((2, 3))  # the nose points straight up or down
    square = across**2 + f**2
    return np.array(
        [
            [0.0, h / across**2, -g / across**2],
            [-across / square, f * g / across / square, f * h / across / square],
        ]
    )


@dataclass(frozen=True)
class _EndErrors:
    """Turns small changes at the end into errors."""

    velocity: Array
    matrix: Array

    def of(self, position: Array, velocity: Array, tilt: Array) -> Array:
        """Errors (…, 7, k) of changes (…, 3, k) of position, velocity and attitude."""
        angles = euler_angles(self.matrix)
        axes = _euler_axes(float(angles.pitch), float(angles.heading))
        # At a pitch of ±90° roll and heading are one; the pseudo-inverse shares it out.
        turned = np.linalg.pinv(axes) @ tilt
        vx, vy = self.velocity[:2]
        square = vx * vx + vy * vy
        shape = np.broadcast_shapes(position.shape, turned.shape)
        course = np.zeros(shape[:-2] + shape[-1:])
        if square > 0.0:
            course = course + (vx * velocity[..., 1, :] - vy * velocity[..., 0, :]) / square
        return np.concatenate(
            [
                np.broadcast_to(position, shape),
                course[..., None, :],
                np.broadcast_to(turned, shape),
            ],
            axis=-2,
        )
