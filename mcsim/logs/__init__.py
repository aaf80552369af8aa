"""Static logs of inertial sensors: files of many kinds to arrays in SI units."""

from mcsim.logs.model import Channel, Log, ReadOptions, Timing
from mcsim.logs.reader import read_log

__all__ = ["Channel", "Log", "ReadOptions", "Timing", "read_log"]
