"""Tables and figures of the sources: what they print beside what mcsim computes.

Another table is a file with a ``PaperTable`` and a line in ``TABLES``; ``mcsim table NAME`` and
``mcsim.table`` follow from it.  Another figure is a ``PaperFigure`` and a line in ``FIGURES``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from mcsim.registry import Registry

if TYPE_CHECKING:
    import pandas as pd

    from mcsim.scenario_file import Scenario


@dataclass(frozen=True)
class Computed:
    """What a table holds.

    Attributes
    ----------
    tables : mapping
        By the names of their files, without ending.
    text : str
        The table as a terminal shows it, with what it says.
    nine_digits : collection of str
        Tables whose floats are written with nine digits.
    """

    tables: Mapping[str, pd.DataFrame]
    text: str
    nine_digits: Collection[str] = ()


@dataclass(frozen=True)
class Setting:
    """Something that may be chosen for a table: an option of its command.

    Attributes
    ----------
    name : str
        Of the option and of the argument.
    default : int or str
        Where nothing is chosen; it also says which of the two it is.
    help : str, optional
        Of the option.
    choices : tuple of str
        What it may be, if that is a list.
    metavar : str, optional
        What stands for it in the help.
    least : int, optional
        Of a number.
    """

    name: str
    default: int | str
    help: str | None = None
    choices: tuple[str, ...] = ()
    metavar: str | None = None
    least: int | None = None


@dataclass(frozen=True)
class PaperTable:
    """A printed table beside what mcsim computes.

    Attributes
    ----------
    name : str
        What ``mcsim table`` calls it.
    title : str
        One sentence for people.
    compute : callable
        ``compute(**settings) -> Computed``.
    files : tuple of str
        Names of its tables, without ending.
    settings : tuple of Setting
        What may be chosen for it; they arrive as keywords of ``compute``.
    folder : str
        Made inside the folder of results for them; none if empty.
    output : str, optional
        Folder of results where the user names none; nothing is then written if None.
    """

    name: str
    title: str
    compute: Callable[..., Computed]
    files: tuple[str, ...]
    settings: tuple[Setting, ...] = ()
    folder: str = ""
    output: str | None = None


def _no_scenarios() -> Sequence[Scenario]:
    return ()


@dataclass(frozen=True)
class PaperFigure:
    """A figure, or a group of them, that shipped scenarios or models of a paper give.

    Attributes
    ----------
    name : str
        What ``mcsim figures`` calls it.
    scenarios : callable
        The sweeps that are run for it; each is drawn in its own folder, unless the figure is
        ``composed`` and there are several.
    composed : bool
        Whether several sweeps are drawn side by side, in a folder of the figure's own.
    make : callable, optional
        ``make(folder) -> pictures`` writes what no run gives into the figure's own folder.
    folder : str
        Of the figure's own; ``figure<name>`` if empty.
    """

    name: str
    scenarios: Callable[[], Sequence[Scenario]] = _no_scenarios
    composed: bool = False
    make: Callable[[Path], Sequence[Path]] | None = None
    folder: str = field(default="")

    @property
    def own_folder(self) -> str:
        """The figure's own folder inside that of all results."""
        return self.folder or f"figure{self.name}"


TABLES: Registry[PaperTable] = Registry(
    "table",
    later={
        "allan-errors": "mcsim.papers.allan_errors:TABLE",
        "allan-recovery": "mcsim.papers.allan_recovery:TABLE",
        "attitude-drift": "mcsim.papers.attitude_drift:TABLE",
        "bias-tracking": "mcsim.papers.bias_tracking:TABLE",
        "gravity-leakage": "mcsim.papers.gravity_leakage:TABLE",
        "planar-sensors": "mcsim.papers.planar_sensors:TABLE",
        "repeated-runs": "mcsim.papers.repeated_runs:TABLE",
        "sensors": "mcsim.papers.sensor_deviations:TABLE",
        "stationary": "mcsim.papers.stationary_data:TABLE",
        "velocity": "mcsim.papers.velocity_tables:TABLE",
    },
)
FIGURES: Registry[PaperFigure] = Registry(
    "figure",
    later={
        "1": "mcsim.papers.planar_figures:FIGURE_1",
        "2": "mcsim.papers.planar_figures:FIGURE_2",
        "3": "mcsim.papers.planar_figures:FIGURE_3",
        "4": "mcsim.papers.planar_figures:FIGURE_4",
        "5": "mcsim.papers.planar_figures:FIGURE_5",
        "10": "mcsim.papers.velocity_figures:FIGURE_10",
        "11": "mcsim.papers.velocity_figures:FIGURE_11",
        "12": "mcsim.papers.velocity_figures:FIGURE_12",
        "13": "mcsim.papers.velocity_figures:FIGURE_13",
        "14": "mcsim.papers.velocity_figures:FIGURE_14",
        "allan": "mcsim.papers.allan_figures:FIGURE",
        "attitude-drift": "mcsim.papers.attitude_drift:FIGURE",
        "braking": "mcsim.papers.braking:FIGURE",
        "repeated-runs": "mcsim.papers.repeated_runs:FIGURE",
        "interpolation": "mcsim.papers.planar_figures:INTERPOLATION",
        "strapdown": "mcsim.papers.shipped_sweeps:STRAPDOWN",
        "velocity": "mcsim.papers.shipped_sweeps:VELOCITY",
        "vibration": "mcsim.papers.shipped_vibrations:VIBRATION",
    },
)
