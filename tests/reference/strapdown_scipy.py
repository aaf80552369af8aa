"""Strapdown dead reckoning, slow and plain, one realization at a time, with scipy's Rotation.

Channels, here: specific force and turns about the forward, left and up axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tests.reference.random_numpy import constants, white_noise
from tests.strapdown import constants_of

#: From the kernel's order of channels to force and turn.
FORCE, TURN = [0, 1, 3], [4, 5, 2]
#: Of the filter in ``docs/examples/levelling_filter.py`` (s).
TIME_CONSTANT = 5.0


@dataclass(frozen=True)
class States:
    """One realization at every sample: (n + 1, 3) each, and the attitude."""

    position: np.ndarray
    velocity: np.ndarray
    attitude: Rotation


def integrate(force, turn, attitude, velocity, position, gravity, t, rule, share=0.5) -> States:
    """Integrate measured samples 0 ... n with one of the four rules, or with the filter's."""
    down = np.array([0.0, 0.0, -gravity])
    attitudes, velocities, positions = [attitude], [velocity], [position]
    for k in range(1, len(force)):
        if rule in ("rectangular", "levelling_filter"):
            pull = np.zeros(3)
            if rule == "levelling_filter":
                up = attitude.inv().apply([0.0, 0.0, 1.0])
                pull = t / TIME_CONSTANT * np.cross(force[k] / np.linalg.norm(force[k]), up)
            attitude = attitude * Rotation.from_rotvec(turn[k] + pull)
            velocity = velocity + t * (attitude.apply(force[k]) + down)
            position = position + t * velocity
        elif rule == "forward_euler":
            # The application note, with its sample k - 1.
            position = position + t * velocity
            velocity = velocity + t * (attitude.apply(force[k - 1]) + down)
            attitude = attitude * Rotation.from_rotvec(turn[k - 1])
        else:
            f = (1.0 - share) * force[k] + share * force[k - 1]
            w = (1.0 - share) * turn[k] + share * turn[k - 1]
            if rule == "two_sample":
                f = f + (np.cross(turn[k - 1], force[k]) + np.cross(force[k - 1], turn[k])) / 12
                w = w + np.cross(turn[k - 1], turn[k]) / 12
            a = (attitude * Rotation.from_rotvec(0.5 * w)).apply(f) + down
            attitude = attitude * Rotation.from_rotvec(w)
            position = position + t * velocity + 0.5 * t**2 * a
            velocity = velocity + t * a
        attitudes.append(attitude)
        velocities.append(velocity)
        positions.append(position)
    return States(np.array(positions), np.array(velocities), Rotation.concatenate(attitudes))


def reconstruct(problem, key: int, realization: int, rule: str) -> States:
    """One realization of a strapdown problem, from the same random numbers."""
    number = np.array([realization])
    n, d = problem.n_samples, constants_of(problem)
    z = np.concatenate([constants(key, number), constants(key, number, 17)])[:, 0] * d
    white = np.concatenate([white_noise(key, number, n), white_noise(key, number, n, 16)], axis=1)[
        :, :, 0
    ]
    offset = z[[0, 1, 2, 12, 13, 14]]
    first = z[[8, 9, 10, 20, 21, 22]]
    noise = problem.sensor_errors.white * white
    if rule == "forward_euler":
        # The kernel's draw for interval k belongs to sample k - 1.
        measured = problem.signals + offset
        measured[:-1] += noise
    else:
        measured = problem.signals + offset + np.concatenate([first[None], noise])
    truth = problem.truth
    roll, pitch = truth.attitude.roll[0] + z[15], truth.attitude.pitch[0] + z[16]
    if problem.levelled:
        f, g, h = problem.rest + offset[FORCE] + z[17:20]
        roll += np.arctan2(g, h) - truth.attitude.roll[0]
        pitch += np.arctan2(-f, np.hypot(g, h)) - truth.attitude.pitch[0]
    heading = truth.attitude.heading[0] + z[4] + z[5]
    turned = Rotation.from_euler("Z", z[4] + z[6]).apply(truth.velocity[:, 0])
    speed = np.linalg.norm(truth.velocity[:, 0])
    return integrate(
        measured[:, FORCE],
        measured[:, TURN],
        Rotation.from_euler("ZYX", [heading, pitch, roll]),
        turned * (speed + z[3]) / speed,
        truth.position[:, 0],
        problem.gravity,
        problem.interval,
        rule,
        problem.previous_share,
    )


def end_errors(problem, key: int, realizations, rule: str) -> np.ndarray:
    """along, across, height, position, roll, pitch, heading, course at the last sample, (8, r)."""
    truth = problem.truth
    angles = truth.attitude
    end = np.array([angles.heading[-1], angles.pitch[-1], angles.roll[-1]])
    columns = []
    for realization in realizations:
        states = reconstruct(problem, key, realization, rule)
        place = states.position[-1] - truth.position[:, -1]
        heading, pitch, roll = states.attitude[-1].as_euler("ZYX") - end
        vx, vy, _ = states.velocity[-1]
        course = np.arctan2(vy, vx) - truth.course[-1]
        turns = np.angle(np.exp(1j * np.array([roll, pitch, heading, course])))
        columns.append([*place, np.linalg.norm(place), *turns])
    return np.array(columns).T
