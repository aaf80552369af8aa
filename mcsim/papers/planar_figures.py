"""Figures 1 to 5 of the planar paper: sweeps, of which two are composed; and interpolation."""

from __future__ import annotations

from functools import partial

from mcsim.papers import PaperFigure
from mcsim.papers.shipped import scenarios_of


def _figure(number: int) -> PaperFigure:
    # Parts of a composed figure carry a letter after its number.
    scenarios = partial(scenarios_of, "paper", f"figure{number}[!0-9]*yaml")
    return PaperFigure(str(number), scenarios, composed=True)


FIGURE_1, FIGURE_2, FIGURE_3, FIGURE_4, FIGURE_5 = map(_figure, range(1, 6))
#: What the paper's conclusions say of Figure 5: interpolation "may partly compensate" the rate.
INTERPOLATION = PaperFigure("interpolation", partial(scenarios_of, "paper", "interpolation_*.yaml"))
