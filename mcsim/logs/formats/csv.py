"""Tables of text, plain or packed: CSV and its kin, whatever no other format recognises."""

from __future__ import annotations

from pathlib import Path

from mcsim.logs.column_file import ColumnFile
from mcsim.logs.csv_file import open_csv
from mcsim.logs.formats.log_format import LogFormat
from mcsim.logs.model import ReadOptions


def columns(path: Path, options: ReadOptions) -> ColumnFile:
    """The columns of the table.

    Raises
    ------
    InputError
        See ``open_csv``.
    """
    del options
    return open_csv(path)


FORMAT = LogFormat("csv", "table", None, columns, endings=(".csv", ".txt"))
