"""Folders that hold one log: EuRoC and TUM-VI, gnss-ins-sim."""

from __future__ import annotations

from pathlib import Path

from mcsim.errors import InputError
from mcsim.logs.model import Array
from mcsim.logs.names import TIME
from mcsim.logs.table import Table, not_used, read_part, read_table, read_time

#: Where EuRoC and TUM-VI keep the samples, from any folder on the way.
_EUROC = ("data.csv", "imu0/data.csv", "mav0/imu0/data.csv")
#: gnss-ins-sim: the first run of each sensor.
_GNSS_INS_SIM = ("accel-0.csv", "gyro-0.csv")
_ENDINGS = ("", ".gz", ".xz")


def is_bag(folder: Path) -> bool:
    """Whether the folder is a ROS 2 bag."""
    return (folder / "metadata.yaml").is_file()


def read_folder(folder: Path, columns: str | None, units: str | None) -> Table:
    """Read a EuRoC, TUM-VI or gnss-ins-sim folder.

    Raises
    ------
    InputError
        None of these, or a file in it is at fault.
    """
    euroc = _first(folder, _EUROC)
    if euroc is not None:
        return read_table(euroc, columns, units)
    parts = [file for name in _GNSS_INS_SIM if (file := _first(folder, (name,))) is not None]
    if parts:
        return _read_gnss_ins_sim(folder, parts, columns, units)
    raise InputError(
        f"{folder}: holds no log that is known: neither {_EUROC[0]} (EuRoC, TUM-VI), nor "
        f"{' or '.join(_GNSS_INS_SIM)} (gnss-ins-sim), nor metadata.yaml (ROS 2 bag)"
    )


def _read_gnss_ins_sim(
    folder: Path, parts: list[Path], columns: str | None, units: str | None
) -> Table:
    values: dict[str, Array] = {}
    notes: list[str] = []
    stated: dict[str, tuple[str, float]] = {}
    matched: list[set[str]] = []
    for part in parts:
        table, unmatched = read_part(part, columns, units)
        matched.append(set(unmatched))
        values |= table.values
        notes += table.notes
        stated |= table.units
    if unmatched_by_all := sorted(set.intersection(*matched)):
        raise InputError(f"{folder}: {not_used(unmatched_by_all)}")
    time = _first(folder, ("time.csv",))
    if time is not None:
        values[TIME] = read_time(time)
    lengths = {len(column) for column in values.values()}
    if len(lengths) > 1:
        raise InputError(
            f"{folder}: its files differ in length "
            f"({', '.join(f'{name}: {len(column)}' for name, column in values.items())} rows)"
        )
    runs = len(list(folder.glob("accel-*.csv*")))
    if runs > 1:
        notes.append(f"the first of {runs} runs is used")
    return Table(values, tuple(notes), stated)


def _first(folder: Path, names: tuple[str, ...]) -> Path | None:
    for name in names:
        for ending in _ENDINGS:
            if (folder / f"{name}{ending}").is_file():
                return folder / f"{name}{ending}"
    return None
