"""Logs of sensors: files of many formats to columns, and of static ones to arrays in SI units."""

from mcsim.logs.formats import LOG_FORMATS, open_log
from mcsim.logs.formats.log_format import LogFormat
from mcsim.logs.held_columns import log_columns
from mcsim.logs.model import Channel, Log, ReadOptions, Timing
from mcsim.logs.reader import read_log

__all__ = [
    "LOG_FORMATS",
    "Channel",
    "Log",
    "LogFormat",
    "ReadOptions",
    "Timing",
    "log_columns",
    "open_log",
    "read_log",
]
