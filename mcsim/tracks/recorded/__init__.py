"""A recorded drive, read from a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcsim.scenario.idle import IdleKey
from mcsim.tracks.recorded.block import Recorded
from mcsim.tracks.track import Track

if TYPE_CHECKING:
    from mcsim.tracks.recorded.manoeuvre import RecordedManoeuvre


def _manoeuvre(block: Recorded, folder: Path) -> RecordedManoeuvre:
    from mcsim.tracks.recorded.manoeuvre import load_manoeuvre

    return load_manoeuvre(block, folder)


def _has_no_angles(model: Any) -> bool:
    columns = model.trajectory.columns
    return columns.course is None and columns.heading is None


TRACK = Track(
    "recorded",
    Recorded,
    _manoeuvre,
    idle=(
        IdleKey(
            "trajectory.angles",
            ("trajectory.columns",),
            _has_no_angles,
            "no recorded angle is used",
        ),
    ),
)
