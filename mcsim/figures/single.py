"""The figure of a single run: its estimates with their intervals."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcsim.figures import labels
from mcsim.figures.style import MARKERS, curve_colour, house_style
from mcsim.results import Results, at_the_end, summarised
from mcsim.scenario.error_quantities import SIGNS, UNITS


def draw_single(results: Results) -> Figure:
    """The statistics of a summary of each error; a panel for each unit."""
    shown = summarised(results.scenario.base)
    markers = [*MARKERS[: len(shown) - 1], "x"]
    errors = results.scenario.base.ERRORS
    units = dict.fromkeys(UNITS[name] for name in errors)
    groups = [[name for name in errors if UNITS[name] == unit] for unit in units]
    table = at_the_end(results.table)
    with house_style():
        figure = Figure(figsize=(9.2, 3.6), layout="constrained")
        panels = figure.subplots(1, len(groups), squeeze=False)[0]
        for axes, names in zip(panels, groups, strict=True):
            for k, (statistic, words) in enumerate(shown.items()):
                rows = table[table["statistic"] == statistic].set_index("error")
                rows = rows.loc[names]
                value = rows["value"].to_numpy(float)
                bars = [
                    np.nan_to_num(value - rows["ci_low"].to_numpy(float)),
                    np.nan_to_num(rows["ci_high"].to_numpy(float) - value),
                ]
                axes.errorbar(
                    np.arange(len(names)) + 0.12 * (k - 0.5 * (len(shown) - 1)),
                    value,
                    yerr=np.maximum(bars, 0.0),
                    fmt=markers[k],
                    color=curve_colour(k, len(shown)),
                    label=words,
                )
            axes.axhline(0.0, color="#6b7280", linewidth=0.8, zorder=1.5)
            axes.set_xticks(range(len(names)), [name.replace("_", " ") for name in names])
            axes.set_ylabel(f"at the end [{SIGNS[UNITS[names[0]]]}]")
        handles, texts = axes.get_legend_handles_labels()
        figure.legend(handles, texts, loc="outside lower center", ncols=5)
        sigmas = results.scenario.base.monte_carlo.confidence
        title = results.scenario.base.figure.title or results.scenario.base.title
        figure.suptitle(
            f"{title or results.scenario.name} – "
            f"bars: {labels.confidence_words(sigmas)} bootstrap intervals",
            fontsize=10.5,
        )
    return figure
