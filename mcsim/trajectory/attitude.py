"""Rotation matrices and Euler angles (heading, pitch, roll: Z-Y-X), vectorised over time.

Axes are forward, left, up and along, across, height; roll is positive with the left side up,
pitch with the nose down (ISO 8855).  A matrix turns body vectors into the level frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcsim.trajectory.curves import Array

#: Below this cosine of the pitch, roll and heading are one rotation (see ``euler_angles``);
#: the strapdown kernel draws the same line.
_LOCKED = 1e-6


@dataclass(frozen=True)
class EulerAngles:
    """Roll, pitch and heading (rad), arrays of one shape."""

    roll: Array
    pitch: Array
    heading: Array


def rotation_matrix(roll: Array, pitch: Array, heading: Array) -> Array:
    """Matrices (…, 3, 3) ``Rz(heading) Ry(pitch) Rx(roll)``."""
    cr, sr = np.cos(roll), np.sin(roll)
    cp, sp = np.cos(pitch), np.sin(pitch)
    ch, sh = np.cos(heading), np.sin(heading)
    rows = [
        [ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr],
        [sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def euler_angles(matrix: Array) -> EulerAngles:
    """Euler angles of matrices (…, 3, 3).

    At a pitch of ±90° only the sum or difference of roll and heading is defined: the
    convention is no roll, and a heading that turns it all.
    """
    forward = np.hypot(matrix[..., 0, 0], matrix[..., 1, 0])
    locked = forward < _LOCKED
    heading = np.arctan2(matrix[..., 1, 0], matrix[..., 0, 0])
    turned = np.arctan2(-matrix[..., 0, 1], matrix[..., 1, 1])
    return EulerAngles(
        roll=np.where(locked, 0.0, np.arctan2(matrix[..., 2, 1], matrix[..., 2, 2])),
        pitch=np.arctan2(-matrix[..., 2, 0], np.where(locked, 0.0, forward)),
        heading=np.where(locked, turned, heading),
    )
