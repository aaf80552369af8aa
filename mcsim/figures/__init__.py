"""Pictures of results."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from mcsim.figures.single import draw_single
from mcsim.figures.style import write_figure
from mcsim.figures.sweeps import Column, draw_columns, draw_sweep
from mcsim.figures.tracks import draw_over_time
from mcsim.results import Results

__all__ = ["draw", "draw_over_time", "draw_side_by_side", "save_figures", "write_figure"]


def draw(results: Results) -> Figure:
    """The main figure of a run: curve families of a sweep, or the estimates of a single run."""
    return draw_sweep(results) if results.scenario.axes else draw_single(results)


def draw_side_by_side(parts: list[Results], title: str) -> Figure:
    """Several sweeps as columns of one figure."""
    return draw_columns(
        [Column(part, title=part.scenario.base.figure.title or "") for part in parts], title
    )


def save_figures(results: Results, folder: Path) -> list[Path]:
    """Write ``figure`` and, if the run kept tracks or histories, ``tracks`` as PNG and SVG."""
    written = write_figure(draw(results), folder, "figure")
    over_time = draw_over_time(results)
    if over_time is not None:
        written += write_figure(over_time, folder, "tracks")
    return written
