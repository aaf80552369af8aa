"""The shipped vibrations, simulated and analysed."""

from __future__ import annotations

from pathlib import Path

from mcsim.api.vibration import analyse_vibration
from mcsim.papers import PaperFigure
from mcsim.papers.shipped import shipped_scenarios


def _make(folder: Path) -> list[Path]:
    pictures = []
    for path in sorted((shipped_scenarios() / "vibration").glob("*.yaml")):
        analyse_vibration(path).write(folder / path.stem)
        pictures.append(folder / path.stem / "figure.png")
    return pictures


VIBRATION = PaperFigure("vibration", make=_make, folder="vibration")
