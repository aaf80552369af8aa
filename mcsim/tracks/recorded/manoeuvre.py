"""A recorded drive from a CSV file, smoothed into a truth that is consistent in itself.

Positions (or velocities) and headings carry measurement noise and repeat between
fixes; a truth must be smooth.  Cubic smoothing splines over time make it so: the
accelerations and yaw rate of the truth are the splines' own derivatives, so that
the undisturbed reconstruction returns to the smoothed track, not to the raw fixes.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_smoothing_spline

from mcsim.errors import InputError
from mcsim.tracks.recorded.block import Recorded
from mcsim.tracks.recorded.record import FEWEST_ROWS, STANDSTILL, Record, known_rows, read_record
from mcsim.trajectory.curves import Array
from mcsim.trajectory.drive import Manoeuvre, Motion

#: What rounding makes of a difference of time stamps, as a share of the largest one.
_STAMP_ROUNDING = 4 * float(np.finfo(float).eps)
#: Points at which the course is looked at, at most.
_MOST_COURSES = 200_000
#: Fixes that repeat the last position are dropped, but one is kept this often (s).
_REPEATED_FIX = 0.5
#: Below this speed the course is bridged; above the second one it is fully trusted (m/s).
_MOVING, _SURE_COURSE = 1.0, 5.0


class RecordedManoeuvre(Manoeuvre):
    """The smoothed drive, turned so that ``along`` is the initial direction of movement.

    ``notes`` tell how the file was read.
    """

    def __init__(self, record: Record, smoothing: float) -> None:
        self.duration = float(record.time[-1])
        if record.x is not None and record.y is not None:
            keep = fresh_fixes(record.time, record.x, record.y)
            fixes = record.time[keep]
            x = _smooth(fixes, record.x[keep], smoothing)
            y = _smooth(fixes, record.y[keep], smoothing)
            self._velocity = x.derivative(), y.derivative()
            self._position = x, y
        else:
            assert record.velocity_x is not None
            assert record.velocity_y is not None
            self._velocity = (
                _smooth(record.time, record.velocity_x, smoothing),
                _smooth(record.time, record.velocity_y, smoothing),
            )
            self._position = tuple(v.antiderivative() for v in self._velocity)
        self._acceleration = tuple(v.derivative() for v in self._velocity)
        self._heading = self._heading_spline(record, smoothing)
        self._yaw_rate = self._heading.derivative()
        if record.roll is not None and record.pitch is not None:
            self.attitude = (
                _smooth(record.time, np.unwrap(record.roll), smoothing),
                _smooth(record.time, np.unwrap(record.pitch), smoothing),
            )
        self._set_frame()
        ends = np.array([self.duration])
        vx, vy = (float(v(ends)[0]) for v in self._velocity)
        self.stops = math.hypot(vx, vy) < STANDSTILL

    def _heading_spline(self, record: Record, smoothing: float):  # type: ignore[no-untyped-def]
        if record.heading is not None:
            return _smooth(record.time, np.unwrap(record.heading), smoothing)
        # The course, trusted where the vehicle moves and bridged where it stands.
        step = min(smoothing / 4.0, self.duration / 16.0)
        step = max(step, self.duration / _MOST_COURSES)
        t = np.linspace(0.0, self.duration, math.ceil(self.duration / step) + 1)
        vx, vy = (v(t) for v in self._velocity)
        speed = np.hypot(vx, vy)
        # The noise of a course goes with 1 / speed, so its weight with speed squared.
        weight = np.clip(speed / _SURE_COURSE, 1e-2, 1.0) ** 2
        course = np.arctan2(vy, vx)
        moving = speed > min(_MOVING, 0.5 * float(speed.max()))
        if speed.max() < STANDSTILL:
            raise InputError("trajectory.file: the vehicle never moves in this record")
        unwrapped = np.interp(t, t[moving], np.unwrap(course[moving]))
        return _smooth(t, unwrapped, smoothing / 2.0, weight)

    def _set_frame(self) -> None:
        """Origin and direction of the road frame: where and whither the drive begins."""
        t = np.linspace(0.0, self.duration, 4096)
        vx, vy = (v(t) for v in self._velocity)
        first = int(np.argmax(np.hypot(vx, vy) > STANDSTILL))
        self._turn = math.atan2(float(vy[first]), float(vx[first]))
        zero = np.array([0.0])
        self._origin = tuple(float(p(zero)[0]) for p in self._position)

    def motion(self, t: Array) -> Motion:
        c, s = math.cos(self._turn), math.sin(self._turn)
        x, y = (p(t) - o for p, o in zip(self._position, self._origin, strict=True))
        vx, vy = (v(t) for v in self._velocity)
        ax, ay = (a(t) for a in self._acceleration)
        heading = self._heading(t)
        ch, sh = np.cos(heading), np.sin(heading)
        return Motion(
            along=c * x + s * y,
            across=c * y - s * x,
            velocity_along=c * vx + s * vy,
            velocity_across=c * vy - s * vx,
            heading=heading - self._turn,
            forward=ch * ax + sh * ay,
            left=ch * ay - sh * ax,
            yaw_rate=self._yaw_rate(t),
        )


def load_manoeuvre(shape: Recorded, folder: Path) -> RecordedManoeuvre:
    """The manoeuvre of a recorded track.

    Raises
    ------
    InputError
        The file cannot be read, lacks a column, holds text, runs backwards, or is too short.
    """
    path = folder / shape.file
    compass, nose_up = shape.angles == "compass", shape.pitch_positive == "nose_up"
    record = read_record(path, shape.columns, compass, nose_up, shape.unknown)
    t = record.time - record.time[0]
    # Differences of stamps carry the rounding of the stamps: a row on an end is inside.
    rounding = _STAMP_ROUNDING * max(1.0, float(np.max(np.abs(record.time))))
    keep = t >= shape.start - rounding
    if shape.duration is not None:
        keep &= t <= shape.start + shape.duration + rounding
    if np.count_nonzero(keep) < FEWEST_ROWS:
        raise InputError(
            f"{path}: {np.count_nonzero(keep)} rows between `start` and the end of `duration`; "
            f"at least {FEWEST_ROWS} are needed (the record lasts {t[-1]:.6g} s)"
        )
    cut, unknown = known_rows(path, record.cut(keep))
    manoeuvre = RecordedManoeuvre(replace(cut, time=cut.time - cut.time[0]), shape.smoothing)
    manoeuvre.notes = (*record.notes, *unknown)
    return manoeuvre


def fresh_fixes(time: Array, x: Array, y: Array) -> NDArray[np.bool_]:
    """Rows whose position is news: a receiver repeats its last fix between updates."""
    keep = np.zeros(len(time), bool)
    last = -1
    for i in range(len(time)):
        moved = last < 0 or x[i] != x[last] or y[i] != y[last]
        if moved or time[i] - time[last] >= _REPEATED_FIX:
            keep[i] = True
            last = i
    keep[-1] = True
    return keep


def _smooth(t: Array, y: Array, time_constant: float, weight: Array | None = None):  # type: ignore[no-untyped-def]
    """Smoothing spline whose transfer function is 1 / (1 + (omega tau)^4).

    Minimises ``rho integral (y - f)^2 + lam integral f''^2`` with rho rows per
    second, so ``lam = rho tau^4``.
    """
    density = (len(t) - 1) / (t[-1] - t[0])
    if len(t) < 5:
        raise InputError("trajectory.file: fewer than 5 distinct positions; too few for a track")
    return make_smoothing_spline(t, y, w=weight, lam=density * time_constant**4)
