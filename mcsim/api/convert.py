"""``mcsim.convert`` and its kin: sensors and noise figures from one dialect to the others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mcsim import catalogue
from mcsim.api.found import Found
from mcsim.dialects import (
    Assumptions,
    Description,
    Reading,
    describe_file,
    read_file,
    writable,
    write_sensor,
)
from mcsim.dialects.quantity import Conversion
from mcsim.dialects.quantity import convert_quantity as conversion_of
from mcsim.errors import InputError
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.scenario.document import Document
from mcsim.scenario.sensor_file import SensorFile
from mcsim.scenario.validation import validate
from mcsim.version import __version__


@dataclass(frozen=True)
class Translation:
    """A sensor in other dialects.

    Attributes
    ----------
    sensor : mcsim.dialects.Description
        In SI units, by mcsim's keys.
    texts : mapping
        By dialect, the text of its file.
    refused : mapping
        By dialect, why the sensor cannot be written so.
    notes : tuple of str
        What was noticed while a file was read.
    """

    sensor: Description
    texts: Mapping[str, str]
    refused: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Parameters(Found):
    """Ready parameters of a sensor as a sensor file.

    Attributes
    ----------
    sensor : str
        The sensor file (YAML) that scenarios take, with Allan's coefficients.
    convention : str
        What its numbers mean.
    notes : tuple of str
        What was noticed while they were read.
    origin : mapping
        Where it comes from: the provenance of its files.
    """

    sensor: str
    convention: str
    notes: tuple[str, ...]
    origin: Mapping[str, Any]

    def report(self) -> Report:
        """File ``sensor.yaml``."""
        return Report(self.origin, texts={"sensor.yaml": self.sensor}, obsolete=("allan", "psd"))


def convert(
    sensor: str | Path,
    to: str | None = None,
    *,
    source: str | None = None,
    assume: Mapping[str, str] | None = None,
    rate: float | None = None,
    axis: str | None = None,
) -> Translation:
    """A sensor's file, or a built-in sensor, in the dialect ``to``, or in all of them.

    Parameters
    ----------
    sensor : path or str
        A file in any dialect, or the name of a built-in sensor.
    to : str, optional
        One of ``mcsim.dialects.writable()``; where it is not given, what a dialect cannot hold is
        told in ``refused``.
    source : str, optional
        One of ``mcsim.dialects.readable()``; recognised if absent.
    assume : mapping, optional
        Answers to what a file leaves open, by key.
    rate : float, optional
        Sampling rate (Hz), where it is needed.
    axis : str, optional
        ``x``, ``y``, ``z`` or ``largest``, for tools with one value for all axes.

    Returns
    -------
    Translation
        ``texts`` and ``refused`` by dialect, ``sensor`` in SI units, ``notes``.

    Raises
    ------
    InputError
        A file that cannot be read, no such sensor, a question unanswered, or a dialect that
        cannot hold the sensor.
    """
    assumptions = Assumptions(dict(assume or {}), rate, axis)
    if is_file(sensor):
        reading = read_file(Path(sensor), source, assumptions)
        description, notes = reading.description, tuple(reading.notes)
    else:
        description, notes = _built_in(str(sensor)), ()
    if to is not None:
        return Translation(
            description, {to: write_sensor(description, to, assumptions)}, notes=notes
        )
    texts, refused = {}, {}
    for name in writable():
        try:
            texts[name] = write_sensor(description, name, assumptions)
        except InputError as error:
            refused[name] = str(error)
    return Translation(description, texts, refused, notes)


def convert_quantity(
    quantity: str, to: str | None = None, *, role: str | None = None, rate: float | None = None
) -> Conversion:
    """A noise figure such as ``0.2 °/√h`` in all units and dialects, or in the dialect ``to``.

    Parameters
    ----------
    quantity : str
        Number and unit.
    to : str, optional
        One of the dialects.
    role : str, optional
        What it is, where its unit does not say: ``bias_instability``, ``allan_minimum``, ….
    rate : float, optional
        Sampling rate (Hz), where it is needed.

    Returns
    -------
    Conversion
        ``meaning``, what the figure was taken for, and ``rows``, its forms with their conventions.

    Raises
    ------
    InputError
        No such unit or role, or a dialect that has no such figure.
    """
    conversion = conversion_of(quantity, role, rate)
    return conversion if to is None else conversion.only(to)


def read_parameters(
    file: str | Path,
    *,
    source: str | None = None,
    assume: Mapping[str, str] | None = None,
    rate: float | None = None,
) -> Parameters:
    """Ready parameters in any dialect, as a sensor file with Allan's coefficients.

    Parameters
    ----------
    file : path
        In any dialect of ``mcsim.dialects.READABLE``.
    source, assume, rate
        As of ``convert``.

    Returns
    -------
    Parameters
        ``sensor`` (the text of a sensor file), ``convention``, ``notes``, and ``write(folder)``.

    Raises
    ------
    InputError
        As ``convert``.
    """
    if rate is not None and not 0.0 < rate < float("inf"):
        raise InputError(f"--rate {rate:g} must be above zero")
    path, assumptions = Path(file), Assumptions(dict(assume or {}), rate)
    reading = read_file(path, source, assumptions)
    text = write_sensor(reading.description, "allan", assumptions)
    told = {"from": source, "rate": rate, "assume": dict(assume) if assume else None}
    return Parameters(
        sensor=_with_origin(text, reading, path),
        convention=" ".join(line[2:] for line in text.splitlines() if line.startswith("# ")),
        notes=tuple(reading.notes),
        origin=provenance_of("characterise", [path], told),
    )


def is_file(given: str | Path) -> bool:
    """Whether there is something of that name; what can be no name is none."""
    try:
        return Path(given).exists()
    except OSError:
        return False


def _built_in(name: str) -> Description:
    known = {sensor.casefold() for sensor in catalogue.sensors()}
    if any(sign in name for sign in "/\\.") and name.casefold() not in known:
        raise InputError(f"{name}: no such file")
    sensor = catalogue.find(name)
    tree = {"name": sensor.name, **dict.fromkeys(sensor.elements, sensor.name)}
    return describe_file(validate(Document(tree, sensor.name), SensorFile))


def _with_origin(text: str, reading: Reading, file: Path) -> str:
    """The sensor file with a line for each note and where it comes from."""
    head = [f"Written by mcsim {__version__}.", *(f"Note: {note}" for note in reading.notes)]
    source = file.name.replace("\\", "\\\\").replace('"', '\\"')
    return "".join(f"# {line}\n" for line in head) + text + f'source: "parameters of {source}"\n'
