"""ROS 1 and ROS 2 bags and MCAP files, through the optional package rosbags."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mcsim.errors import InputError
from mcsim.logs.column_file import ColumnFile
from mcsim.logs.formats.log_format import LogFormat
from mcsim.logs.held_columns import columns_of_table
from mcsim.logs.model import ACCELEROMETER, GYROSCOPE, SHORT, Array, ReadOptions
from mcsim.logs.names import CHANNELS, TIME
from mcsim.logs.table import Table

_ENDINGS = (".bag", ".mcap", ".db3")
_METADATA = "metadata.yaml"
_MESSAGE = "sensor_msgs/msg/Imu"
_ORDER = tuple(CHANNELS)
#: Units that the message type prescribes.
_UNITS = {"time": ("s",), ACCELEROMETER: ("m/s^2", "m/s²"), GYROSCOPE: ("rad/s",)}
#: Characters of a library's own words that a message shows.
_SHOWN = 160


@dataclass(frozen=True)
class _Messages:
    """Messages of one topic: stamps of the header and of the bag in ns, (n,), values (n, 6)."""

    topic: str
    header: Array
    bag: Array
    values: Array

    @property
    def lives(self) -> list[str]:
        """Elements whose axes are not all constant (zero, mostly: not measured)."""
        spans = np.ptp(self.values, axis=0).reshape(2, 3)
        return [e for e, span in zip((ACCELEROMETER, GYROSCOPE), spans, strict=True) if span.any()]


def recognises(path: Path) -> bool:
    """By its ending; a folder by its metadata."""
    return path.suffix.lower() in _ENDINGS or (path / _METADATA).is_file()


def columns(path: Path, options: ReadOptions) -> ColumnFile:
    """The messages of the topic as columns in SI units.

    Raises
    ------
    InputError
        As ``table``.
    """
    return columns_of_table(path, table(path, options))


def table(path: Path, options: ReadOptions) -> Table:
    """Read the messages sensor_msgs/Imu of one topic, or of an accelerometer's and a gyroscope's.

    Their units are SI.  ``options.topic`` names a topic, or two with a comma between;
    ``options.columns`` names the channels that are taken, ``time`` among them if the stamps are.

    Raises
    ------
    InputError
        rosbags is not installed, the bag is damaged, the topic is missing or open, or an option
        does not fit.
    """
    wanted = _wanted(path, options.columns)
    _check_units(path, options.units)
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputError(
            f"{path}: reading bags needs the package rosbags: pip install 'mcsim[bags]'"
        ) from None
    # The library lets through whatever its parts raise: sqlite, yaml, struct, decompressors, its
    # own errors of six kinds; damaged lengths end in OverflowError or MemoryError.
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            topics = _topics(reader, path, options.topic)
            messages = [_messages(reader, path, topic) for topic in topics]
    except InputError:
        raise
    except Exception as error:
        words = " ".join(str(error).split())[:_SHOWN] or type(error).__name__
        raise InputError(f"{path}: not a bag that can be read ({words})") from None
    if options.topic is None and len(messages) > 1:
        messages = _pair(path, messages)
    if len(messages) == 2 and messages[0].lives == [GYROSCOPE]:
        messages.reverse()
    return _table(path, messages, wanted)


def _wanted(path: Path, columns: str | None) -> list[str]:
    """Names of ``--columns``; all if absent."""
    if columns is None:
        return [TIME, *_ORDER]
    names = [name.strip() for name in columns.split(",") if name.strip() not in ("", "-")]
    for name in names:
        if name != TIME and name not in CHANNELS:
            raise InputError(
                f'{path}: --columns: "{name}" is none of time, {", ".join(_ORDER)}; of a bag it '
                "names those that are taken, such as --columns time,gyro_x,gyro_y,gyro_z"
            )
    if not set(names) - {TIME}:
        raise InputError(f"{path}: --columns names no channel; such as time,{','.join(_ORDER)}")
    return names


def _check_units(path: Path, units: str | None) -> None:
    """The message type prescribes its units; others are refused, the same may be said."""
    for part in (units or "").split(","):
        kind, separator, unit = (text.strip() for text in part.partition("="))
        known = {"accel": ACCELEROMETER, "gyro": GYROSCOPE}.get(kind, kind)
        if part.strip() and (not separator or unit not in _UNITS.get(known, ())):
            raise InputError(
                f'{path}: --units "{part.strip()}": sensor_msgs/Imu holds m/s^2, rad/s and s; '
                "leave --units out (a bag in other units must be converted to CSV)"
            )


def _topics(reader: Any, path: Path, given: str | None) -> list[str]:
    topics = sorted({c.topic for c in reader.connections if c.msgtype == _MESSAGE})
    if not topics:
        held = ", ".join(sorted({f"{c.topic} ({c.msgtype})" for c in reader.connections}))
        raise InputError(
            f"{path}: holds no sensor_msgs/Imu messages (it holds {held or 'nothing'})"
        )
    if given is None:
        return topics
    chosen = [topic.strip() for topic in given.split(",")]
    for topic in chosen:
        if topic not in topics:
            raise InputError(
                f'{path}: no IMU under "{topic}" (topics with one: {", ".join(topics)})'
            )
    if len(chosen) > 2:
        raise InputError(f"{path}: --topic takes one topic, or two: accelerometer and gyroscope")
    return chosen


def _messages(reader: Any, path: Path, topic: str) -> _Messages:
    connections = [c for c in reader.connections if c.topic == topic and c.msgtype == _MESSAGE]
    header, bag, rows = [], [], []
    for connection, arrival, raw in reader.messages(connections=connections):
        message = reader.deserialize(raw, connection.msgtype)
        a, w, stamp = message.linear_acceleration, message.angular_velocity, message.header.stamp
        header.append(stamp.sec * 1_000_000_000 + stamp.nanosec)
        bag.append(arrival)
        rows.append((a.x, a.y, a.z, w.x, w.y, w.z))
    if not rows:
        raise InputError(f"{path}: {topic} holds no messages")
    values = np.array(rows, float)
    bad = [name for name, column in zip(_ORDER, values.T, strict=True) if not _finite(column)]
    if bad:
        raise InputError(f"{path}: {topic}: {', '.join(bad)} hold values that are not finite")
    return _Messages(topic, _since(header, header[0]), _since(bag, header[0]), values)


def _since(stamps: Iterable[int], first: int) -> Array:
    """Stamps in ns less a first one; whole numbers of any size until then."""
    return np.array([stamp - first for stamp in stamps], float)


def _finite(column: Array) -> bool:
    return bool(np.all(np.isfinite(column)))


def _pair(path: Path, messages: list[_Messages]) -> list[_Messages]:
    """The topic of an accelerometer and that of a gyroscope, if there is one of each."""
    lives = [found.lives for found in messages]
    halves = {
        element: [m for m, life in zip(messages, lives, strict=True) if life == [element]]
        for element in (ACCELEROMETER, GYROSCOPE)
    }
    others = [m for m, life in zip(messages, lives, strict=True) if len(life) == 2]
    if not others and all(len(found) == 1 for found in halves.values()):
        return [halves[ACCELEROMETER][0], halves[GYROSCOPE][0]]
    names = [found.topic for found in messages]
    raise InputError(
        f"{path}: several topics hold an IMU; choose one: --topic {names[0]}, "
        f"{', '.join(names[1:])}; or an accelerometer's and a gyroscope's: --topic A,B"
    )


def _table(path: Path, messages: list[_Messages], wanted: list[str]) -> Table:
    first = messages[0]
    notes = [f"topic {' and '.join(found.topic for found in messages)}"]
    if len(messages) == 1:
        columns = dict(zip(_ORDER, first.values.T.copy(), strict=True))
        stamps, notes = _stamps(first, notes)
        lives = first.lives or [ACCELEROMETER, GYROSCOPE]
    else:
        columns, stamps, notes = _joined(path, messages, notes)
        lives = [ACCELEROMETER, GYROSCOPE]
    values = {}
    for name, column in columns.items():
        element = CHANNELS[name][0]
        if name in wanted and element in lives:
            values[name] = column
    absent = [element for element in (ACCELEROMETER, GYROSCOPE) if element not in lives]
    for element in absent:
        notes.append(f"{first.topic} holds no {element}: its values are constant")
    if not values:
        raise InputError(
            f"{path}: {first.topic} holds none of what --columns names "
            f"(its {', '.join(absent)} is constant)"
        )
    if TIME in wanted:
        values[TIME] = stamps * 1e-9
    else:
        notes.append("the time stamps are left out, as --columns says")
    return Table(values, tuple(notes))


def _stamps(found: _Messages, notes: list[str]) -> tuple[Array, list[str]]:
    """The stamps of the header (ns); the bag's own where the header has none."""
    if len(found.header) > 1 and np.ptp(found.header) == 0.0:
        told = "the stamps in the headers are all the same: those of the bag (arrival) are taken"
        return found.bag - found.bag[0], [*notes, told]
    return found.header, notes


def _joined(
    path: Path, messages: list[_Messages], notes: list[str]
) -> tuple[dict[str, Array], Array, list[str]]:
    """An accelerometer's and a gyroscope's messages, one beside the other.

    Sensors of one rate are paired sample by sample; else the slower one stands for itself, for
    interpolation would colour its noise.
    """
    accel, gyro = messages
    counts = len(accel.values), len(gyro.values)
    if abs(counts[0] - counts[1]) > max(2, 0.001 * max(counts)):
        told = " and ".join(f"{m.topic} ({len(m.values)} messages)" for m in messages)
        raise InputError(
            f"{path}: {told} differ in rate; read one after the other: --topic {accel.topic}, "
            f"then --topic {gyro.topic}"
        )
    n = min(counts)
    stamps, notes = _stamps(accel, notes)
    values = np.column_stack([accel.values[:n, :3], gyro.values[:n, 3:]])
    if counts[0] != counts[1]:
        notes.append(f"{abs(counts[0] - counts[1])} messages at the end have no partner: left out")
    notes.append(f"{SHORT[ACCELEROMETER]} from {accel.topic}, {SHORT[GYROSCOPE]} from {gyro.topic}")
    return dict(zip(_ORDER, values.T.copy(), strict=True)), stamps[:n], notes


FORMAT = LogFormat(
    "ros-bag",
    "ROS bag or MCAP file",
    recognises,
    columns,
    table,
    endings=_ENDINGS,
    folder=f"{_METADATA} (ROS 2 bag)",
)
