"""Formats of logs, one file each; to add one is a file and a line in this list.

All that read measured values ask here: static logs, vibrations, tests of a bench, recorded drives.
"""

from __future__ import annotations

from pathlib import Path

from mcsim.errors import InputError
from mcsim.files import readable
from mcsim.logs.column_file import ColumnFile
from mcsim.logs.formats import csv, euroc, gnss_ins_sim, ros_bag
from mcsim.logs.formats.log_format import LogFormat
from mcsim.logs.model import ReadOptions
from mcsim.logs.table import Table, table_of
from mcsim.registry import Registry

LOG_FORMATS: Registry[LogFormat] = Registry(
    "log format", (csv.FORMAT, euroc.FORMAT, gnss_ins_sim.FORMAT, ros_bag.FORMAT)
)


def format_of(path: Path) -> LogFormat:
    """The format of a file or folder: the one that recognises it, for other files a table of text.

    Raises
    ------
    InputError
        Several formats recognise it, or it is a folder that none does.
    """
    found = recognising(path)
    if len(found) > 1:
        names = ", ".join(log_format.name for log_format in found)
        raise InputError(f"{path}: looks like several formats of logs ({names})")
    if found:
        return found[0]
    if path.is_dir():
        known = ", nor ".join(f.folder for f in LOG_FORMATS.values() if f.folder)
        raise InputError(f"{path}: holds no log that is known: neither {known}")
    return csv.FORMAT


def recognising(path: Path) -> list[LogFormat]:
    """The formats that recognise a file or folder; pipes and devices are not looked into.

    Raises
    ------
    InputError
        A format fails over it.
    """
    with readable(path):
        if not (path.is_file() or path.is_dir()):
            return []
    found = []
    for log_format in LOG_FORMATS.values():
        with readable(path, log_format.title):
            if log_format.recognises is not None and log_format.recognises(path):
                found.append(log_format)
    return found


def endings() -> tuple[str, ...]:
    """What the names of logs end with, unpacked."""
    return tuple(dict.fromkeys(e for f in LOG_FORMATS.values() for e in f.endings))


def open_log(path: Path, options: ReadOptions | None = None) -> ColumnFile:
    """The columns of a log of any format.

    Raises
    ------
    InputError
        It is of no known format, or cannot be read.
    """
    log_format = format_of(path)
    with readable(path, log_format.title):
        return log_format.columns(path, options or ReadOptions())


def read_table(path: Path, options: ReadOptions) -> Table:
    """Time, accelerations and angular rates of a log of any format.

    Raises
    ------
    InputError
        As ``open_log``; or a column has no unit, is not recognised, or holds no numbers.
    """
    log_format = format_of(path)
    if log_format.table is not None:
        with readable(path, log_format.title):
            return log_format.table(path, options)
    return table_of(open_log(path, options), options.columns, options.units)
