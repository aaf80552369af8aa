"""All pictures of a result, in its folder."""

from __future__ import annotations

from pathlib import Path

from mcsim.figures import PICTURES
from mcsim.figures.style import write_figure
from mcsim.results import Results


def save_figures(results: Results, folder: Path) -> list[Path]:
    """Write every picture that the results have enough for, as PNG and SVG; the files.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    return [
        file
        for picture in PICTURES.values()
        if picture.wants(results)
        for file in write_figure(picture.paint(results), folder, picture.name)
    ]
