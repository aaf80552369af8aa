"""Figures 3.2 to 3.7 of the vibration thesis: the Allan deviation of each term."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from mcsim.papers import PaperFigure


def _terms(folder: Path) -> list[Path]:
    from mcsim.api.allan import curves
    from mcsim.figures.allan_terms import draw_terms
    from mcsim.figures.style import printed
    from mcsim.provenance import provenance_of

    found = curves()
    replace(
        found.report(),
        provenance=provenance_of("figures allan"),
        tables={"table": found.table},
        pictures=printed(draw_terms(found.panels, found.title), "figure"),
        nine_digits=("table",),
    ).write(folder)
    return [folder / "figure.png"]


FIGURE = PaperFigure("allan", make=_terms, folder="allan")
