"""A drive in space: a plane track in the plane of its road, and the attitude of the body.

The body's matrix is ``road Rz(heading) Ry(pitch) Rx(roll)``: the road's plane, the track's
heading in it, and how the body leans against the road.  The road's plane is
``Ry(-grade) Rx(bank)``; it does not turn with the road, so that a banked curve is not in it.
The sensors sit in the point whose track is given.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from mcsim.scenario.response import Response
from mcsim.systems.strapdown.scenario import Body, StrapdownScenario
from mcsim.tracks import drive_of
from mcsim.trajectory.attitude import EulerAngles, euler_angles, rotation_matrix
from mcsim.trajectory.curves import Array
from mcsim.trajectory.drive import Drive
from mcsim.trajectory.lean import (
    Lean,
    constant_lean,
    leaning,
    recorded_lean,
    refuse_jumps,
    refuse_long,
)


@dataclass(frozen=True)
class SpatialMotion:
    """True motion in the level frame at k times.

    ``position`` and ``velocity`` (3, k): along, across, height, in m and m/s.
    """

    position: Array
    velocity: Array
    attitude: EulerAngles

    @property
    def course(self) -> Array:
        """Direction of the horizontal velocity (rad)."""
        return np.arctan2(self.velocity[1], self.velocity[0])


@dataclass(frozen=True, eq=False)
class SpatialDrive:
    """A plane drive, the road's plane (3, 3), and the body's lean in it."""

    drive: Drive
    road: Array
    roll: Lean
    pitch: Lean
    gravity: float

    def motion(self, t: Array) -> SpatialMotion:
        """The motion at times ``t`` (k,)."""
        plane = self.drive.motion(t)
        level = np.zeros_like(t)
        body = rotation_matrix(self.roll.angle(t), self.pitch.angle(t), plane.heading)
        return SpatialMotion(
            position=self.road @ np.stack([plane.along, plane.across, level]),
            velocity=self.road @ np.stack([plane.velocity_along, plane.velocity_across, level]),
            attitude=euler_angles(self.road @ body),
        )

    def signals(self, t: Array, width: float = 0.0) -> Array:
        """What ideal sensors measure at times ``t`` (k,): channels (6, k).

        Specific force ``R^T (a + g)`` and body rates, in the order forward, left, yaw, up,
        roll, pitch; ``width`` as for ``Drive.signals``.
        """
        forward, left, yaw = self.drive.signals(t, width)
        up_x, up_y, up_z = _upwards(self.road, self.drive.heading(t))
        forward = forward + self.gravity * up_x
        left = left + self.gravity * up_y
        up = self.gravity * up_z
        roll, pitch = self.roll.angle(t), self.pitch.angle(t)
        roll_rate, pitch_rate = self.roll.rate(t, width), self.pitch.rate(t, width)
        cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
        # Without the pitch first, then without the roll.
        forward, up = cp * forward - sp * up, sp * forward + cp * up
        left, up = cr * left + sr * up, cr * up - sr * left
        return np.stack(
            [
                forward,
                left,
                cr * cp * yaw - sr * pitch_rate,
                up,
                roll_rate - sp * yaw,
                cr * pitch_rate + sr * cp * yaw,
            ]
        )

    def at_rest(self, t: float) -> Array:
        """Specific force (3,) of a vehicle that stands in the attitude of time ``t``."""
        attitude = self.motion(np.array([t])).attitude
        body = rotation_matrix(attitude.roll, attitude.pitch, attitude.heading)[0]
        return self.gravity * body[2]


def _upwards(road: Array, heading: Array) -> tuple[Array, Array, Array]:
    """The vertical in axes that lie in the road's plane and turn with the heading."""
    x, y, z = road[2]
    c, s = np.cos(heading), np.sin(heading)
    return c * x + s * y, c * y - s * x, np.broadcast_to(z, heading.shape)


def spatial_drive(model: StrapdownScenario, folder: Path) -> SpatialDrive:
    """The drive of a scenario; ``folder`` is where recorded files lie.

    Raises
    ------
    InputError
        A track that cannot be built, or a body that cannot follow it at once.
    """
    drive = drive_of(model.trajectory, folder)
    body = model.body
    if drive.manoeuvre.attitude is not None:
        roll, pitch = (recorded_lean(angle) for angle in drive.manoeuvre.attitude)
        return SpatialDrive(drive, np.eye(3), roll, pitch, body.local_gravity)
    return _leaning_drive(drive, body)


def check_lean(model: StrapdownScenario, drive: Drive) -> None:
    """Refuse a body that cannot follow its drive, or takes too long to, before it is tried.

    Raises
    ------
    InputError
        See above.
    """
    body = model.body
    if model.records_attitude:
        return
    for axis, (response, sign) in enumerate(_responses(body)):
        if response.gradient == 0.0:
            continue
        refuse_long(drive.duration, response.natural_frequency)
        if response.natural_frequency == 0.0:
            refuse_jumps(*_driven(drive, _road(body), body.local_gravity, axis, response, sign))


def _responses(body: Body) -> tuple[tuple[Response, float], tuple[Response, float]]:
    """Pitch under forward force, which lifts the nose, and roll under that to the left."""
    return (body.pitch, -1.0), (body.roll, 1.0)


def _road(body: Body) -> Array:
    zero = np.array(0.0)
    uphill = rotation_matrix(zero, np.array(-body.grade), zero)
    return uphill @ rotation_matrix(np.array(body.bank), zero, zero)


@lru_cache(maxsize=64)
def _leaning_drive(drive: Drive, body: Body) -> SpatialDrive:
    road = _road(body)
    pitch, roll = (
        _lean(drive, road, body.local_gravity, axis, response, sign)
        for axis, (response, sign) in enumerate(_responses(body))
    )
    return SpatialDrive(drive, road, roll, pitch, body.local_gravity)


def _lean(
    drive: Drive, road: Array, gravity: float, axis: int, response: Response, sign: float
) -> Lean:
    """The lean under the specific force in the road's plane: forward (axis 0) or left (1)."""
    if response.gradient == 0.0:
        return constant_lean(0.0)
    refuse_long(drive.duration, response.natural_frequency)
    driven = _driven(drive, road, gravity, axis, response, sign)
    return leaning(*driven, response.natural_frequency, response.damping)


def _driven(
    drive: Drive, road: Array, gravity: float, axis: int, response: Response, sign: float
) -> tuple[Callable[[Array], Array], float, float, tuple[float, ...], float]:
    """What drives a lean: the force, its values before and after, its breaks, the gain."""

    def force(t: Array) -> Array:
        return drive.signals(t)[axis] + gravity * _upwards(road, drive.heading(t))[axis]

    end = drive.manoeuvre.duration
    breaks = (0.0, *sorted(drive.manoeuvre.jumps), end)
    before, after = force(np.array([-1.0, end + 1.0])).tolist()
    return force, before, after, breaks, sign * response.gradient
