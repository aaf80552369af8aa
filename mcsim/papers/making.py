"""Making figures: their sweeps are run, drawn while the next ones run, and composed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from mcsim.errors import InputError
from mcsim.papers import FIGURES, PaperFigure
from mcsim.papers.drawing import Drawing
from mcsim.provenance import provenance_of
from mcsim.results import Results
from mcsim.scenario_file import Scenario

#: Runs a scenario, and draws its results with what it is given.
Run = Callable[[Scenario, Callable[[Results, Path], object]], Results]
_ALL = "all"


def figures_named(names: Sequence[str]) -> list[PaperFigure]:
    """The figures of these names, each once; all of them if none is named.

    Raises
    ------
    InputError
        Not the name of a figure.
    """
    for name in names:
        if name != _ALL and name not in FIGURES:
            raise InputError(f'figures: "{name}" is not one of {", ".join(FIGURES)}, {_ALL}')
    wanted = tuple(FIGURES) if not names or _ALL in names else dict.fromkeys(names)
    return [FIGURES[name] for name in wanted]


def make_figures(
    figures: Sequence[PaperFigure], output: Path, drawing: Drawing, run: Run
) -> tuple[list[Path], list[str]]:
    """Make figures in folders of ``output``; their pictures, and the points that failed.

    Parameters
    ----------
    figures : sequence of PaperFigure
    output : Path
    drawing : Drawing
    run : callable
        ``run(scenario, draw) -> Results`` writes the results into a folder of ``output`` that is
        named after the scenario.

    Raises
    ------
    InputError
        A folder that cannot be written, or what ``run`` raises.
    """
    pictures: list[Path] = []
    failures: list[str] = []
    for figure in figures:
        scenarios = figure.scenarios()
        composed = figure.composed and len(scenarios) > 1
        # Parts of one figure are drawn side by side, and not each alone as well.
        draw = _leave_undrawn if composed else drawing.one
        for scenario in scenarios:
            failures += run(scenario, lambda _, folder, draw=draw: draw(folder)).failures  # type: ignore[misc]
        folders = [output / scenario.name for scenario in scenarios]
        own = output / figure.own_folder
        if composed:
            _compose(figure, scenarios, folders, own, drawing)
        pictures += [folder / "figure.png" for folder in ([own] if composed else folders)]
        if figure.make is not None:
            pictures += figure.make(own)
    return pictures, failures


def _leave_undrawn(folder: Path) -> None:
    del folder


def _compose(
    figure: PaperFigure,
    scenarios: Sequence[Scenario],
    folders: list[Path],
    own: Path,
    drawing: Drawing,
) -> None:
    parts = [scenario.name for scenario in scenarios]
    provenance = provenance_of(f"figures {figure.name}", options={"parts": parts})
    drawing.side_by_side(folders, scenarios[0].base.title or "", own, provenance)
