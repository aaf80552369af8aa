"""The main figure of a run, and several of them side by side."""

from __future__ import annotations

from matplotlib.figure import Figure

from mcsim.figures import Picture
from mcsim.figures.single import draw_single
from mcsim.figures.sweeps import Column, draw_columns, draw_sweep
from mcsim.results import Results


def draw(results: Results) -> Figure:
    """The main figure of a run: curve families of a sweep, or the estimates of a single run."""
    return draw_sweep(results) if results.scenario.axes else draw_single(results)


def draw_side_by_side(parts: list[Results], title: str) -> Figure:
    """Several sweeps as columns of one figure."""
    return draw_columns(
        [Column(part, title=part.scenario.base.figure.title or "") for part in parts], title
    )


PICTURE = Picture("figure", wants=lambda _: True, paint=draw)
