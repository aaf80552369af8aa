"""The shipped vibrations, simulated and analysed: by their own sensor, and by all of the platform.

The latter is what Figures 5.6 and 5.7 of the vibration thesis show of the elevator.
"""

from __future__ import annotations

from pathlib import Path

from mcsim.api.sensor_comparison import compare_vibrations
from mcsim.api.vibration import analyse_vibration
from mcsim.papers import PaperFigure
from mcsim.papers.shipped import shipped_scenarios
from mcsim.vibration.platform import PLATFORM


def _make(folder: Path) -> list[Path]:
    pictures: list[Path] = []
    for path in sorted((shipped_scenarios() / "vibration").glob("*.yaml")):
        alone = analyse_vibration(path)
        beside = compare_vibrations([path], sensors=PLATFORM)
        files = alone.write(folder / path.stem) + beside.write(folder / beside.name)
        pictures += [file for file in files if file.suffix == ".png"]
    return pictures


VIBRATION = PaperFigure("vibration", make=_make, folder="vibration")
