"""Results of runs on disk: written by one hand, and read back whole and of one run."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcsim.errors import InputError
from mcsim.files import readable
from mcsim.provenance import MARKS, PROVENANCE
from mcsim.report import Report
from mcsim.results import Results
from mcsim.scenario_file import Scenario
from mcsim.stored_tables import (
    columns_of,
    read_provenance,
    read_table,
    refuse_mixed,
    refuse_others,
    refuse_unfit,
)

if TYPE_CHECKING:
    import pandas as pd

TABLE = "table"
#: Tables beside the main one.
_EXTRA_TABLES = ("budget", "history", "tracks")
#: Written, but not read back: a log for other commands.
_LOG = "runs"
#: Formats of a run's tables, and of those that are read, the quickest first.
FORMATS = ("csv", "parquet")
_READ = ("parquet", "csv")


def save(
    results: Results,
    folder: Path,
    formats: tuple[str, ...] = FORMATS,
    pictures: Collection[str] = (),
) -> list[Path]:
    """Write the tables and the provenance of a run into ``folder``; return the files.

    What an earlier run left and this one does not have is removed, and so are its ``pictures``
    (names without ending), which would not belong to the new tables.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    extras = {name: getattr(results, name) for name in (*_EXTRA_TABLES, _LOG)}
    kept = {name: table for name, table in extras.items() if table is not None}
    return Report(
        provenance=results.provenance,
        tables={TABLE: results.table, **kept},
        formats=formats,
        obsolete=(*_EXTRA_TABLES, _LOG, *pictures),
    ).write(folder)


def load(path: str | Path) -> pd.DataFrame:
    """The table of a stored result.

    Parameters
    ----------
    path : path
        The folder that a run has written, or one of the tables in it (CSV or Parquet).

    Returns
    -------
    DataFrame
        As it was written: one row per point, error and statistic; swept columns have their unit in
        brackets, the column ``unit`` is that of the value.

    Raises
    ------
    InputError
        There is no result at that place, it is damaged, or it is not of the run that the
        provenance beside it tells of.
    """
    file = _table_file(Path(path))
    marks: Mapping[str, Any] = {}
    if (file.parent / PROVENANCE).exists():
        marks = _marks(read_provenance(file.parent))
    table = read_table(file, marks)
    if file.stem == TABLE:
        refuse_unfit(file, table)
    return table


def load_results(path: str | Path) -> Results:
    """A stored result with its scenario, so that it can be drawn again.

    Raises
    ------
    InputError
        There is no result at that place, or parts of it are damaged or of another run.
    """
    file = _table_file(Path(path))
    folder = file.parent
    provenance = read_provenance(folder)
    scenario = _scenario(provenance, folder)
    refuse_mixed(folder, _marks(provenance))
    extras = {name: _stored(folder, name) for name in _EXTRA_TABLES}
    files = {TABLE: file, **{name: part for name, part in extras.items() if part is not None}}
    tables = {name: _checked(part, name, scenario, provenance) for name, part in files.items()}
    return Results(scenario, tables.pop(TABLE), provenance, **tables)


def _scenario(provenance: Mapping[str, Any], folder: Path) -> Scenario:
    try:
        name = Path(provenance["name"]).name
        for key in ("remarks", "failures"):
            list(provenance[key])
        return Scenario.from_dict(dict(provenance["scenario"]), name, folder)
    except (ValueError, LookupError, TypeError, AttributeError, InputError) as error:
        raise InputError(
            f"{folder / PROVENANCE}: not the provenance of a result ({error})"
        ) from None


def _checked(
    file: Path, name: str, scenario: Scenario, provenance: Mapping[str, Any]
) -> pd.DataFrame:
    table = read_table(file, _marks(provenance))
    # A budget has no rows where nothing disturbs.
    if name != "budget" or len(table):
        with readable(file, "table of results"):
            refuse_unfit(file, table, columns_of(name, scenario))
            if name != "tracks":
                refuse_others(file, table, scenario)
    return table


def _marks(provenance: Mapping[str, Any]) -> Mapping[str, Any]:
    """Digests of the tables by file name; results of earlier versions have none."""
    marks = provenance.get(MARKS, {})
    return marks if isinstance(marks, dict) else {}


def _table_file(path: Path) -> Path:
    if path.is_file():
        return path
    file = _stored(path, TABLE)
    if file is not None:
        return file
    what = "holds no table.csv" if path.is_dir() else "no such result"
    raise InputError(f"{path}: {what}; name the folder that `mcsim run` wrote")


def _stored(folder: Path, name: str) -> Path | None:
    """The file of a table, in the format that is read the quickest."""
    files = (folder / f"{name}.{ending}" for ending in _READ)
    return next((file for file in files if file.exists()), None)
