"""What a file of a log format must say of it: one object, listed in ``mcsim.logs.formats``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mcsim.logs.column_file import ColumnFile
from mcsim.logs.model import ReadOptions
from mcsim.logs.table import Table


@dataclass(frozen=True)
class LogFormat:
    """How one kind of file or folder holds measured values.

    Parameters
    ----------
    name : str
    title : str
        What one of them is, for messages: ``"ROS bag"``.
    recognises : callable or None
        Whether a file or folder that exists is one; None: all files that no other recognises.
    columns : callable
        Opens it: its columns with titles and units (``mcsim.log_columns`` makes them of arrays).
    table : callable, optional
        Time, accelerations and angular rates, of a format that says which of its numbers they
        are; else the titles of the columns, ``--columns`` and ``--units`` say it.
    endings : tuple of str
        What names of such files end with, for the names of results.
    folder : str
        By what a folder is known to be one, for messages; '' where it is a file.
    """

    name: str
    title: str
    recognises: Callable[[Path], bool] | None
    columns: Callable[[Path, ReadOptions], ColumnFile]
    table: Callable[[Path, ReadOptions], Table] | None = None
    endings: tuple[str, ...] = ()
    folder: str = ""
