"""The list of dialects: another one is a file with a ``DIALECT`` and a line here."""

from __future__ import annotations

import textwrap
from dataclasses import replace
from pathlib import Path

from mcsim.dialects import gnss_ins_sim, imu_utils, kalibr, kf_gins, matlab, own
from mcsim.dialects.description import Assumptions, Description, Reading
from mcsim.dialects.dialect import Dialect
from mcsim.errors import InputError
from mcsim.registry import Registry
from mcsim.scenario.document import Genre, read_text

DIALECTS: Registry[Dialect] = Registry(
    "dialect",
    (
        own.DIALECT,
        own.DATA_SHEET,
        own.ALLAN,
        kalibr.DIALECT,
        matlab.DIALECT,
        gnss_ins_sim.DIALECT,
        kf_gins.DIALECT,
        imu_utils.DIALECT,
    ),
)
_COMMENT_WIDTH = 96
_GENRE = Genre("parameter", "is written in one of the dialects")


def readable() -> tuple[str, ...]:
    """Names of the dialects that are read."""
    return tuple(d.name for d in DIALECTS.values() if d.read is not None)


def writable() -> tuple[str, ...]:
    """Names of the dialects that are written."""
    return tuple(d.name for d in DIALECTS.values() if d.write is not None)


def endings() -> tuple[str, ...]:
    """What the names of such files end with."""
    return (*dict.fromkeys(d.ending for d in DIALECTS.values()), ".yml")


def recognise(text: str, source: str) -> Dialect:
    """The dialect that a text is written in.

    Raises
    ------
    InputError
        None, or more than one: ``--from`` decides.
    """
    found = [d for d in DIALECTS.values() if d.recognises is not None and d.recognises(text)]
    if len(found) == 1:
        return found[0]
    what = "looks like several dialects" if found else "is in none of the known dialects"
    known = ", ".join(d.name for d in found or DIALECTS.values() if d.read is not None)
    raise InputError(
        f"{source}: {what}; say which with --from ({known}), or write its figures, each with its "
        "unit, into a sensor file (gyroscope: angle_random_walk: 0.2 °/√h)"
    )


def read_sensor(text: str, source: str, name: str | None, assumptions: Assumptions) -> Reading:
    """Read a sensor in the dialect ``name``, or in the one it is recognised by.

    The rate is that of the text, or the one assumed.

    Raises
    ------
    InputError
        Unknown, not to be read, wrong in itself, of another rate than the one assumed, or
        with a question unanswered.
    """
    dialect = DIALECTS.find(name) if name is not None else recognise(text, source)
    if dialect.read is None:
        raise InputError(f"{dialect.name} is a way to write; read it with --from mcsim")
    reading = dialect.read(text, source, assumptions)
    given, assumed = reading.description.rate, assumptions.rate
    if given is not None and assumed is not None and given != assumed:
        raise InputError(
            f"{source}: its rate is {given:g} Hz, and --rate says {assumed:g} Hz; "
            "leave --rate out, or mend the file"
        )
    return replace(
        reading, description=replace(reading.description, rate=given if given else assumed)
    )


def read_file(path: Path, name: str | None, assumptions: Assumptions) -> Reading:
    """Read a sensor's file, as ``read_sensor`` does its text.

    Raises
    ------
    InputError
        Not a readable text, or what ``read_sensor`` refuses.
    """
    return read_sensor(read_text(path, _GENRE), str(path), name, assumptions)


def write_sensor(sensor: Description, name: str, assumptions: Assumptions) -> str:
    """The sensor in a dialect, its convention spelled out in a comment.

    Raises
    ------
    InputError
        The dialect cannot hold this sensor, or is not to be written.
    """
    dialect = DIALECTS.find(name)
    if dialect.write is None:
        raise InputError(f"{dialect.name} is not written: its numbers do not say what they are")
    body = dialect.write(sensor, assumptions)
    head = textwrap.wrap(
        f"{dialect.title}: {dialect.convention}.",
        _COMMENT_WIDTH,
        initial_indent=f"{dialect.comment} ",
        subsequent_indent=f"{dialect.comment} ",
    )
    return "\n".join([*head, body])
