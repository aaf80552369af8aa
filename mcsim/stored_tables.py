"""Reading back what a run has stored: whole, of one run, and what it claims to be."""

from __future__ import annotations

import io
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcsim.errors import InputError
from mcsim.files import check_file, readable
from mcsim.over_time import TIME
from mcsim.provenance import PROVENANCE, mark_of
from mcsim.results import COLUMNS, coordinate_columns
from mcsim.scenario_file import Scenario

if TYPE_CHECKING:
    import pandas as pd

#: The largest files (bytes), and rows of a table, that are read.
_LARGEST_TABLE, _LARGEST_PROVENANCE, _MOST_ROWS = 1 << 32, 1 << 24, 50_000_000
_NUMBERS = ("value", "ci_low", "ci_high", "std", "share", TIME)
_TEXTS = ("error", "statistic", "unit", "source", "note")


def read_provenance(folder: Path) -> dict[str, Any]:
    """The provenance that lies in a folder.

    Raises
    ------
    InputError
        There is none, or it is damaged.
    """
    file = folder / PROVENANCE
    try:
        provenance = json.loads(_content(file, _LARGEST_PROVENANCE))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{file}: not the provenance of a result ({error})") from None
    if not isinstance(provenance, dict):
        raise InputError(f"{file}: not the provenance of a result (no block of keys)")
    return provenance


def read_table(file: Path, marks: Mapping[str, Any]) -> pd.DataFrame:
    """A stored table, CSV or Parquet; ``marks`` are those of its provenance, by file name.

    Raises
    ------
    InputError
        No such file, not a table, or not the one that the provenance tells of.
    """
    content = _content(file, _LARGEST_TABLE)
    _refuse_unmarked(file, content, marks)
    with readable(file, "table of results"):
        return _parsed(content, file.suffix == ".csv")


def refuse_mixed(folder: Path, marks: Mapping[str, Any]) -> None:
    """Refuse a folder that holds a table of another run than its provenance tells of.

    Raises
    ------
    InputError
        See above.
    """
    for file in sorted(folder.iterdir()):
        if file.name in marks:
            _refuse_unmarked(file, _content(file, _LARGEST_TABLE), marks)


def _refuse_unmarked(file: Path, content: bytes, marks: Mapping[str, Any]) -> None:
    if file.name in marks and marks[file.name] != mark_of(content):
        raise InputError(
            f"{file}: not the table that {PROVENANCE} beside it tells of: damaged, changed, or "
            "of another run that was stopped while it wrote; run the scenario again"
        )


def _content(file: Path, largest: int) -> bytes:
    check_file(file, largest, "stored result")
    with readable(file, "stored result"):
        return file.read_bytes()


def _parsed(content: bytes, csv: bool) -> pd.DataFrame:
    import pandas as pd
    import pyarrow.parquet as pq

    if csv:
        return _of_csv(content)
    try:
        if pq.ParquetFile(io.BytesIO(content)).metadata.num_rows > _MOST_ROWS:
            raise ValueError(f"more than {_MOST_ROWS:,} rows")
        return pd.read_parquet(io.BytesIO(content))
    except UnicodeDecodeError:
        raise ValueError("damaged: a name in it is no text") from None


def _of_csv(content: bytes) -> pd.DataFrame:
    """A table as it was before it was written: floats to the last bit, empty texts as such."""
    import pyarrow as pa
    from pyarrow import csv

    # A column without any value would tell of no type, and of a wrong one.
    types = {**dict.fromkeys(_NUMBERS, pa.float64()), **dict.fromkeys(_TEXTS, pa.string())}
    options = csv.ConvertOptions(column_types=types, null_values=[""])
    table = csv.read_csv(io.BytesIO(content), convert_options=options)
    if table.num_rows > _MOST_ROWS:
        raise ValueError(f"more than {_MOST_ROWS:,} rows")
    return table.to_pandas()


def refuse_unfit(file: Path, table: pd.DataFrame, columns: Iterable[str] = COLUMNS) -> None:
    """Refuse a table that lacks rows or columns, or has text where numbers belong.

    Raises
    ------
    InputError
        See above.
    """
    import pandas as pd

    missing = [name for name in columns if name not in table.columns]
    if missing:
        raise InputError(f"{file}: not a table of results (no column {', '.join(missing)})")
    if not table.columns.is_unique:
        raise InputError(f"{file}: not a table of results (a column occurs twice)")
    if not len(table):
        raise InputError(f"{file}: holds no rows; run the scenario again")
    for name in _NUMBERS:
        if name not in columns or table[name].isna().all():
            continue
        if not pd.api.types.is_numeric_dtype(table[name]):
            raise InputError(f"{file}: not a table of results (`{name}` holds no numbers)")


def refuse_others(file: Path, table: pd.DataFrame, scenario: Scenario) -> None:
    """Refuse a table whose errors or swept values are not those of the scenario.

    Raises
    ------
    InputError
        See above.
    """
    of_columns: dict[str, set[Any]] = {"error": set(scenario.base.ERRORS)}
    of_columns |= {axis.column: set(axis.values) for axis in scenario.axes}
    for name, known in of_columns.items():
        others = [value for value in table[name].unique().tolist() if value not in known]
        if others:
            raise InputError(
                f"{file}: not of the scenario in {PROVENANCE} beside it "
                f"(`{name}` is {others[0]} somewhere); run the scenario again"
            )


def columns_of(name: str, scenario: Scenario) -> tuple[str, ...]:
    """The columns that one of a run's tables must have."""
    swept = [axis.column for axis in scenario.axes]
    return {
        "table": (*coordinate_columns(scenario), *COLUMNS),
        "budget": (*coordinate_columns(scenario), "error", "source", "std", "share", "unit"),
        "history": (*swept, TIME, "error", "statistic", "value", "unit", "realizations"),
        "tracks": (*swept, "realization", TIME),
    }[name]
