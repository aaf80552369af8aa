"""How a static log is read: the same options wherever one is."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from mcsim.cli.dialect_options import Hertz

if TYPE_CHECKING:
    from mcsim.api.characterise import LogOptions

F = TypeVar("F", bound=Callable[..., Any])

_OPTIONS = (
    click.option(
        "--rate",
        type=Hertz(),
        metavar="HZ",
        help="Sampling rate of a log without time, or whose time stamps are no use.",
    ),
    click.option(
        "--columns",
        help="What the columns are: time, accel_x … gyro_z in order (- skips one), or "
        "accel_x=TITLE,….",
    ),
    click.option(
        "--units",
        help="Units in the order of the columns, or accelerometer=g,gyroscope=deg/s,time=ms; "
        "counts: accelerometer=16384 counts/g.",
    ),
    click.option("--topic", help="Topic of the IMU in a bag."),
    click.option("--start", type=float, metavar="S", help="Leave out what lies before (s)."),
    click.option("--end", type=float, metavar="S", help="Leave out what lies after (s)."),
)


def log_options(command: F) -> F:
    """Add them to a command."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def read_options(given: dict[str, Any]) -> LogOptions:
    """What was given of them, taken out of ``given``."""
    read: Any = {
        key: given.pop(key) for key in ("rate", "columns", "units", "topic", "start", "end")
    }
    options: LogOptions = read
    return options
