"""``mcsim.table``: a printed table of a source beside what mcsim computes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcsim.api.found import Found
from mcsim.errors import InputError
from mcsim.papers import TABLES, Computed, PaperTable, Setting
from mcsim.provenance import provenance_of
from mcsim.registry import suggest
from mcsim.report import Report
from mcsim.writing import csv_writer, readable_errors, write_whole

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Table(Found):
    """A table of a source, printed and computed.

    Attributes
    ----------
    part : mcsim.papers.PaperTable
    computed : mcsim.papers.Computed
    settings : mapping
        What was chosen for it.
    """

    part: PaperTable
    computed: Computed
    settings: Mapping[str, Any]

    @property
    def tables(self) -> Mapping[str, pd.DataFrame]:
        """By the names of their files, without ending; units stand in the columns' names."""
        return self.computed.tables

    @property
    def text(self) -> str:
        """The table as a terminal shows it, with what it says."""
        return self.computed.text

    def report(self) -> Report:
        """One file per table."""
        options = dict(self.settings)
        seed = options.pop("seed", None)
        return Report(
            provenance=provenance_of(f"table {self.part.name}", options=options, seed=seed),
            tables=self.tables,
            nine_digits=self.computed.nine_digits,
        )

    def write_csv(self, file: str | Path) -> Path:
        """Write the only table, floats exactly, into a file of any name.

        Raises
        ------
        InputError
            There are several tables, or the file cannot be written.
        """
        path, tables = Path(file), list(self.tables.values())
        if len(tables) != 1:
            raise InputError(f"{self.part.name}: has {len(tables)} tables; write them to a folder")
        with readable_errors(path.parent):
            return write_whole(path, csv_writer(tables[0]))


def table(name: str, **settings: int | str) -> Table:
    """Compute a table of a source.

    Parameters
    ----------
    name : str
        One of ``mcsim.papers.TABLES``: ``velocity``, ``repeated-runs``, ``sensors``,
        ``stationary``, ``bias-tracking``, ``gravity-leakage`` …
    **settings
        The table's own, as its command has them: ``seed``, ``noise``, ``duration``.

    Returns
    -------
    Table
        ``tables`` by the names of their files, ``text`` as a terminal shows it, and
        ``write(folder)``.

    Raises
    ------
    InputError
        No such table or setting, or a value that it cannot have.
    """
    part = TABLES.find(name)
    known = {setting.name: setting for setting in part.settings}
    for given, value in settings.items():
        if given not in known:
            raise InputError(
                f'{name}: "{given}" is not a setting of this table '
                f"(known: {', '.join(known) or 'none'}){suggest(given, known)}"
            )
        _refuse_unfit(name, known[given], value)
    chosen = {setting.name: setting.default for setting in part.settings} | settings
    return Table(part, part.compute(**chosen), chosen)


def _refuse_unfit(table: str, setting: Setting, value: int | str) -> None:
    where = f"{table}: {setting.name}"
    if isinstance(value, bool) or not isinstance(value, type(setting.default)):
        kind = "a whole number" if isinstance(setting.default, int) else "a text"
        raise InputError(f"{where}: {kind} is needed, not {value!r}")
    if setting.choices and value not in setting.choices:
        raise InputError(f'{where}: "{value}" is not one of {", ".join(setting.choices)}')
    if setting.least is not None and isinstance(value, int) and value < setting.least:
        raise InputError(f"{where}: must be at least {setting.least}, not {value}")
