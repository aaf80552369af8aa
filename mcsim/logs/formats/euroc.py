"""EuRoC and TUM-VI: a folder with the samples of an IMU in ``data.csv``."""

from __future__ import annotations

from pathlib import Path

from mcsim.errors import InputError
from mcsim.logs.column_file import ColumnFile
from mcsim.logs.csv_file import open_csv
from mcsim.logs.formats.log_format import LogFormat
from mcsim.logs.inside import first_inside
from mcsim.logs.model import ReadOptions

#: Where the samples are kept, from any folder on the way.
_SAMPLES = ("data.csv", "imu0/data.csv", "mav0/imu0/data.csv")


def recognises(path: Path) -> bool:
    """Whether there are samples on the way down."""
    return path.is_dir() and first_inside(path, _SAMPLES) is not None


def columns(path: Path, options: ReadOptions) -> ColumnFile:
    """The columns of the samples.

    Raises
    ------
    InputError
        They are no table that can be read.
    """
    del options
    samples = first_inside(path, _SAMPLES)
    if samples is None:
        raise InputError(f"{path}: holds no {_SAMPLES[0]}")
    return open_csv(samples)


FORMAT = LogFormat(
    "euroc",
    "EuRoC or TUM-VI folder",
    recognises,
    columns,
    folder=f"{_SAMPLES[0]} (EuRoC, TUM-VI)",
)
