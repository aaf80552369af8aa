"""ROS 1 and ROS 2 bags and MCAP files, through the optional package rosbags."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mcsim.errors import InputError
from mcsim.logs.columns import TIME
from mcsim.logs.table import Table

ENDINGS = (".bag", ".mcap", ".db3")
_MESSAGE = "sensor_msgs/msg/Imu"


def read_bag(path: Path, topic: str | None) -> Table:
    """Read the messages sensor_msgs/Imu of one topic; their units are SI.

    Raises
    ------
    InputError
        rosbags is not installed, the bag is damaged, or the topic is missing or open.
    """
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputError(
            f"{path}: reading bags needs the package rosbags: pip install 'mcsim[bags]'"
        ) from None
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            return _messages(reader, path, topic)
    except (AnyReaderError, OSError, ValueError, KeyError, AssertionError) as error:
        raise InputError(f"{path}: not a bag that can be read ({error})") from None


def _messages(reader: Any, path: Path, topic: str | None) -> Table:
    topics = sorted({c.topic for c in reader.connections if c.msgtype == _MESSAGE})
    if not topics:
        held = ", ".join(sorted({f"{c.topic} ({c.msgtype})" for c in reader.connections}))
        raise InputError(
            f"{path}: holds no sensor_msgs/Imu messages (it holds {held or 'nothing'})"
        )
    if topic is None and len(topics) > 1:
        raise InputError(
            f"{path}: several topics hold an IMU; choose one: --topic {topics[0]}, "
            f"{', '.join(topics[1:])}"
        )
    chosen = topic or topics[0]
    if chosen not in topics:
        raise InputError(f'{path}: no IMU under "{chosen}" (topics with one: {", ".join(topics)})')
    connections = [c for c in reader.connections if c.topic == chosen and c.msgtype == _MESSAGE]
    stamps, rows = [], []
    for connection, _, raw in reader.messages(connections=connections):
        message = reader.deserialize(raw, connection.msgtype)
        a, w, stamp = message.linear_acceleration, message.angular_velocity, message.header.stamp
        stamps.append(stamp.sec * 1_000_000_000 + stamp.nanosec)
        rows.append((a.x, a.y, a.z, w.x, w.y, w.z))
    if not rows:
        raise InputError(f"{path}: {chosen} holds no messages")
    values = dict(
        zip(
            ("accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z"),
            np.array(rows, float).T.copy(),
            strict=True,
        )
    )
    bad = [name for name, column in values.items() if not np.all(np.isfinite(column))]
    if bad:
        raise InputError(f"{path}: {chosen}: {', '.join(bad)} hold values that are not finite")
    values[TIME] = (np.array(stamps) - stamps[0]) * 1e-9
    return Table(values, (f"topic {chosen}",))
