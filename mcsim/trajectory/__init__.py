"""Trajectories: the vehicle's true motion, from a scenario's track."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from mcsim.scenario.tracks import Recorded, Trajectory
from mcsim.trajectory.drive import CurveManoeuvre, Drive, Motion

__all__ = ["CurveManoeuvre", "Drive", "Motion", "drive_notes", "drive_of"]


@lru_cache(maxsize=1024)
def drive_of(trajectory: Trajectory, folder: Path) -> Drive:
    """The drive that a scenario describes; ``folder`` is where recorded files lie.

    Raises
    ------
    InputError
        A recorded file or way-points that cannot be used.
    """
    if isinstance(trajectory, Recorded):
        from mcsim.trajectory.recorded import load_drive

        return Drive(load_drive(trajectory, folder), trajectory.lead)
    from mcsim.trajectory.shapes import curve_of

    manoeuvre = CurveManoeuvre(
        curve_of(trajectory),
        trajectory.speed,
        trajectory.deceleration,
        trajectory.side_slip,
        trajectory.side_slip_profile == "bump",
    )
    return Drive(manoeuvre, trajectory.lead)


def drive_notes(trajectory: object, folder: Path) -> tuple[str, ...]:
    """How a recorded drive was read: its columns, what is unknown; nothing of other tracks.

    Raises
    ------
    InputError
        As ``drive_of``.
    """
    if not isinstance(trajectory, Recorded):
        return ()
    return tuple(getattr(drive_of(trajectory, folder).manoeuvre, "notes", ()))
