"""The look of all figures, and how they are written."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator
from numpy.typing import NDArray

from mcsim.writing import Writer, readable_errors, write_together

#: Decades that a range must span to be drawn on a logarithmic axis.
LOG_DECADES = 1.3
#: Logarithmic axes of fewer decades carry plain numbers at 1, 2 and 5.
_PLAIN_DECADES = 2.5
MARKERS = "osD^vPX<>*"
LINE_STYLES = ("-", "--", ":", "-.")
_CURVE_COLOURS = ("#1b4965", "#2a9d8f", "#e9a03b", "#d1495b", "#7b4ea3", "#5c677d")
_RC: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#d9dde2",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.3,
    "lines.markersize": 4.0,
    "errorbar.capsize": 2.0,
    "svg.fonttype": "path",
    "text.parse_math": False,
    "svg.hashsalt": "mcsim",
}
_DPI = 130
#: Longer legends stand beside the figure.
_MOST_LEGEND_ROWS = 4


@contextmanager
def house_style() -> Iterator[None]:
    """Drawing inside looks like mcsim, and touches no setting of the caller."""
    with mpl.rc_context(_RC):
        yield


def curve_colour(index: int, count: int) -> object:
    """Colour of one of ``count`` curves; distinguishable without colour vision too."""
    if count <= len(_CURVE_COLOURS):
        return _CURVE_COLOURS[index]
    return mpl.colormaps["viridis"](index / (count - 1) * 0.92)


def spans_decades(values: Sequence[float] | NDArray[np.float64]) -> bool:
    """Whether positive values range over more than ``LOG_DECADES``."""
    finite = np.asarray([v for v in values if np.isfinite(v)])
    if len(finite) < 2 or np.any(finite <= 0.0):
        return False
    return bool(np.log10(finite.max() / finite.min()) > LOG_DECADES)


def printed(figure: Figure, name: str) -> dict[str, Writer]:
    """What writes ``name.svg`` and ``name.png``, without a date inside, by the files' names."""
    # Arranged once, and drawn once for each format: ``savefig`` would do both again.
    with house_style():
        if (layout := figure.get_layout_engine()) is not None:
            layout.execute(figure)
            figure.set_layout_engine("none")
    return {f"{name}.svg": partial(_print_svg, figure), f"{name}.png": partial(_print_png, figure)}


def write_figure(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write ``name.png`` and ``name.svg`` into ``folder``, whole or not at all.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    files = {folder / file: write for file, write in printed(figure, name).items()}
    with readable_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        svg, png = write_together(files)
    return [png, svg]


def _print_svg(figure: Figure, path: Path) -> None:
    canvas: Any = FigureCanvasSVG(figure)
    with house_style():
        canvas.print_svg(path, metadata={"Date": None, "Creator": None})


def _print_png(figure: Figure, path: Path) -> None:
    figure.set_dpi(_DPI)
    canvas: Any = FigureCanvasAgg(figure)
    with house_style():
        canvas.print_png(path, metadata={"Software": None})


def log_scale(axes: Axes, which: Literal["x", "y"], values: Sequence[float]) -> None:
    """Make an axis logarithmic; its ticks carry plain numbers, or powers over many decades."""
    axes.set(**{f"{which}scale": "log"})
    axis = axes.xaxis if which == "x" else axes.yaxis
    finite = np.asarray([v for v in values if np.isfinite(v) and v > 0.0])
    if len(finite) and np.log10(finite.max() / finite.min()) < _PLAIN_DECADES:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:.10g}"))
        axis.set_minor_locator(NullLocator())
    else:
        # Ticks are what drawing spends its time on; two between powers say enough.
        axis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda x, _: _power_of_ten(x)))
    axis.set_minor_formatter(NullFormatter())


def _power_of_ten(x: float) -> str:
    """``10⁻³`` in plain signs."""
    exponent = str(round(np.log10(x))) if x > 0.0 else ""
    return "10" + exponent.translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def legend_outside(figure: Figure, axes: Axes, title: str | None = None) -> None:
    """One legend for the whole figure, under it or beside it: it can cover no data."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        # As many columns as fit: a sign is about 0.075 inch wide, a handle 0.55 inch.
        width = 0.075 * max(map(len, labels)) + 0.55
        columns = max(1, min(len(labels), 5, int(figure.get_figwidth() / width)))
        where: Literal["outside lower center", "outside right upper"] = "outside lower center"
        if len(labels) > _MOST_LEGEND_ROWS * columns:
            where, columns = "outside right upper", 1
            figure.set_figwidth(figure.get_figwidth() + width)
        figure.legend(handles, labels, title=title, loc=where, ncols=columns)


def set_title(figure: Figure, title: str) -> None:
    """A title over the whole figure, broken into lines that fit."""
    signs = int(11.0 * figure.get_figwidth())
    lines = [line for part in title.splitlines() for line in textwrap.wrap(part, signs)]
    figure.suptitle("\n".join(lines), fontsize=11)
