"""Dead reckoning at intervals that vary, slow and plain: numpy, scipy's Rotation, one loop each.

All take signals per second: accelerations (m/s^2) and angular rates (rad/s), with the intervals (s)
before the samples; an interval of nan is a sample that is lost.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tests.reference.random_numpy import normal_pair, stream_words, white_noise, xoshiro


def planar(signals, intervals, place, velocity, heading, rule):
    """Complex place and velocity, and heading, after each sample; signals (n + 1, 3)."""
    states = [(place, velocity, heading)]
    before = signals[0]
    for now, t in zip(signals[1:], intervals[1:], strict=True):
        if not np.isnan(t):
            forward, left, rate = now if rule == "rectangular" else 0.5 * (now + before)
            turned = heading + t * rate
            middle = turned if rule == "rectangular" else heading + 0.5 * t * rate
            moved = velocity + t * (forward + 1j * left) * np.exp(1j * middle)
            if rule == "rectangular":
                place = place + t * moved
            else:
                place = place + 0.5 * t * (velocity + moved)
            velocity, heading, before = moved, turned, now
        states.append((place, velocity, heading))
    return states


def midpoint(signals, intervals, place, velocity, heading):
    """The example of a rule of one's own: each sample for its interval."""
    for (forward, left, rate), t in zip(signals[1:], intervals[1:], strict=True):
        if np.isnan(t):
            continue
        moved = velocity + t * (forward + 1j * left) * np.exp(1j * (heading + 0.5 * t * rate))
        place, velocity = place + 0.5 * t * (velocity + moved), moved
        heading = heading + t * rate
    return place, velocity, heading


def strapdown(force, rate, intervals, attitude, velocity, position, gravity, rule):
    """Position, velocity (3,) and attitude after the last sample; force and rate (n + 1, 3)."""
    down = np.array([0.0, 0.0, -gravity])
    f0, w0 = force[0], rate[0]
    for f1, w1, t in zip(force[1:], rate[1:], intervals[1:], strict=True):
        if np.isnan(t):
            continue
        if rule == "rectangular":
            attitude = attitude * Rotation.from_rotvec(t * w1)
            velocity = velocity + t * (attitude.apply(f1) + down)
            position = position + t * velocity
        elif rule == "forward_euler":
            position = position + t * velocity
            velocity = velocity + t * (attitude.apply(f0) + down)
            attitude = attitude * Rotation.from_rotvec(t * w0)
        else:
            f, turn = 0.5 * (f0 + f1), 0.5 * t * (w0 + w1)
            if rule == "two_sample":
                f = f + t * (np.cross(w0, f1) + np.cross(f0, w1)) / 12
                turn = turn + t**2 * np.cross(w0, w1) / 12
            a = (attitude * Rotation.from_rotvec(0.5 * turn)).apply(f) + down
            attitude = attitude * Rotation.from_rotvec(turn)
            position = position + t * velocity + 0.5 * t**2 * a
            velocity = velocity + t * a
        f0, w0 = f1, w1
    return position, velocity, attitude


def instants(key, realizations, samples):
    """Normals (n + 1, r) of the instants: one of each two words of the events' stream."""
    state, rows = stream_words(key, realizations, 2, 0), []
    for _ in range(samples + 1):
        a, state = xoshiro(state)
        b, state = xoshiro(state)
        rows.append(normal_pair(a, b)[0])
    return np.array(rows)


def arrivals(key, realizations, samples):
    """Normals of the stamps (n + 1, r), and of the losses (n + 1, r), which sample 0 has not."""
    drawn = white_noise(key, realizations, samples, 4)
    stamps = np.concatenate([drawn[:1, 2], drawn[:, 0]])
    return stamps, np.concatenate([np.full_like(drawn[:1, 1], np.inf), drawn[:, 1]])


def passed(stamped, lost, nominal=None):
    """Intervals (n + 1,) since the last sample that arrived, of stamps (n + 1,); nan where lost."""
    intervals, last = np.full(len(stamped), np.nan), stamped[0]
    for i in np.flatnonzero(~lost)[1:]:
        intervals[i] = stamped[i] - last if nominal is None else nominal
        last = stamped[i]
    return intervals
