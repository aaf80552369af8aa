"""Results on disk: whole files or none, all of one run, and reading them back."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcsim.checkpoints import Checkpoint
from mcsim.errors import InputError
from mcsim.files import readable
from mcsim.results import Results
from mcsim.scenario_file import Scenario
from mcsim.stored_tables import (
    MARKS,
    PROVENANCE,
    columns_of,
    mark_of,
    read_provenance,
    read_table,
    refuse_mixed,
    refuse_others,
    refuse_unfit,
)
from mcsim.writing import (
    csv_writer,
    parquet_writer,
    readable_errors,
    remove_stale,
    write_table,
    write_text,
    write_whole,
)

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "Checkpoint",
    "load",
    "load_results",
    "readable_errors",
    "remove_figures",
    "save",
    "write_provenance",
    "write_table",
    "write_text",
    "write_whole",
]

TABLE = "table"
#: Tables beside the main one; each as CSV and Parquet.
_EXTRA_TABLES = ("budget", "history", "tracks")
_PICTURES = ("png", "svg")


def save(results: Results, folder: Path) -> list[Path]:
    """Write the tables and the provenance of a run into ``folder``; return the files.

    Each file appears whole or not at all.  The provenance comes last and holds the digests of
    the tables: of a run that is stopped in between nothing is taken for the other's.  Files
    that an earlier run left and this one does not have are removed, and so are its pictures.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    tables = {
        TABLE: results.table,
        "budget": results.budget,
        "history": results.history,
        "tracks": results.tracks,
    }
    remove_figures(folder)
    written: list[Path] = []
    marks: dict[str, str] = {}
    with readable_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name, table in tables.items():
            if table is None:
                _remove(folder, name, ("csv", "parquet", *_PICTURES))
                continue
            for ending, writer in (("csv", csv_writer), ("parquet", parquet_writer)):
                file = folder / f"{name}.{ending}"
                written.append(write_whole(file, _marked(writer(table), file.name, marks)))
    written.append(write_provenance({**results.provenance, MARKS: marks}, folder))
    return written


def _marked(
    write: Callable[[Path], None], name: str, marks: dict[str, str]
) -> Callable[[Path], None]:
    """Writes a file, and notes its digest under its name."""

    def write_and_mark(path: Path) -> None:
        write(path)
        marks[name] = mark_of(path.read_bytes())

    return write_and_mark


def write_provenance(provenance: Mapping[str, Any], folder: Path) -> Path:
    """Write where results come from into ``folder``, whole or not at all.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    text = json.dumps(provenance, indent=2, ensure_ascii=False) + "\n"
    return write_text(text, folder, PROVENANCE)


def remove_figures(folder: Path) -> None:
    """Remove the pictures of an earlier run, which would not belong to new tables.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    with readable_errors(folder):
        for name in ("figure", "tracks"):
            _remove(folder, name, _PICTURES)


def _remove(folder: Path, name: str, endings: tuple[str, ...]) -> None:
    for ending in endings:
        file = folder / f"{name}.{ending}"
        file.unlink(missing_ok=True)
        remove_stale(file)


def load(path: str | Path) -> pd.DataFrame:
    """The table of a stored result; ``path`` is its folder or one of its tables.

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
    files = {
        name: folder / f"{name}.parquet"
        for name in _EXTRA_TABLES
        if (folder / f"{name}.parquet").exists()
    }
    tables = {
        name: _checked(part, name, scenario, provenance)
        for name, part in {TABLE: file, **files}.items()
    }
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
    for ending in ("parquet", "csv"):
        if (path / f"{TABLE}.{ending}").exists():
            return path / f"{TABLE}.{ending}"
    what = "holds no table.csv" if path.is_dir() else "no such result"
    raise InputError(f"{path}: {what}; name the folder that `mcsim run` wrote")
