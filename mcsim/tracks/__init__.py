"""The shapes of track: a module each, block and curve together, and a line here.

``mcsim.tracks.track`` tells what a shape must say.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Annotated

from mcsim.registry import Registry
from mcsim.scenario.idle import IdleKey
from mcsim.scenario.one_of import OneOf
from mcsim.tracks import curve, double_lane_change, lane_change, recorded, straight, waypoints
from mcsim.tracks.track import DrivenTrackBlock, Track, TrackBlock, along
from mcsim.trajectory.drive import Drive

__all__ = [
    "TRACKS",
    "DrivenTrackBlock",
    "Track",
    "TrackBlock",
    "Trajectory",
    "along",
    "drive_notes",
    "drive_of",
    "idle_keys",
]

TRACKS: Registry[Track] = Registry(
    "shape of track",
    (
        straight.TRACK,
        lane_change.HALF_COSINE,
        lane_change.QUINTIC,
        lane_change.NONIC,
        double_lane_change.TRACK,
        curve.TRACK,
        waypoints.TRACK,
        recorded.TRACK,
    ),
)

_ONE_OF_THEM = OneOf(TRACKS)
#: The trajectory block of scenarios: the block of one of the shapes.
Trajectory = Annotated[TrackBlock, _ONE_OF_THEM]


@lru_cache(maxsize=1024)
def drive_of(trajectory: TrackBlock, folder: Path) -> Drive:
    """The drive that a scenario describes; ``folder`` is where recorded files lie.

    Raises
    ------
    InputError
        A recorded file or way-points that cannot be used.
    """
    track: Track = _ONE_OF_THEM.part_of(trajectory)
    return Drive(track.manoeuvre(trajectory, folder), trajectory.lead)


def drive_notes(trajectory: object, folder: Path) -> tuple[str, ...]:
    """What a user should know of where the drive comes from; nothing of what is no track.

    Raises
    ------
    InputError
        As ``drive_of``.
    """
    if not isinstance(trajectory, TrackBlock):
        return ()
    return drive_of(trajectory, folder).manoeuvre.notes


def idle_keys(trajectory: object) -> tuple[IdleKey, ...]:
    """The keys of a track that change nothing in some scenarios; none of what is no track."""
    if not isinstance(trajectory, TrackBlock):
        return ()
    track: Track = _ONE_OF_THEM.part_of(trajectory)
    return track.idle
