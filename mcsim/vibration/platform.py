"""Sensors on one platform: each sees the same vibration, at its own rate and bandwidth."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim import catalogue
from mcsim.errors import InputError
from mcsim.scenario.run import LARGEST_SEED
from mcsim.scenario.sensor_block import is_file
from mcsim.sensor_terms.mechanisms import LowPass
from mcsim.vibration.excitations import acceleration
from mcsim.vibration.log import Log
from mcsim.vibration.scenario import VibrationScenario, read_vibration
from mcsim.vibration.simulation import AXES, errors_of, simulate

Array = NDArray[np.float64]

#: The reference of the source, against which the others are held where none is named.
REFERENCE = "MTN-1100"
#: Words for several sensors: every built-in one with noise, and those of the source's platform.
ALL, PLATFORM = "all", "platform"
_ELEMENT = "accelerometer"
_OF_PLATFORM = "thesis-table-5.2"
_FEWEST = 64


@dataclass(frozen=True)
class Seen:
    """What one sensor logged of the vibration, along its one axis.

    ``log`` has one channel; ``time`` (n,) are its samples' times (s) on the clock that all
    sensors share; ``ideal`` (n,) is the excitation's acceleration (m/s²) at those times, None
    where nobody knows it; ``bandwidth`` in Hz, nan if unknown or unlimited; ``lag`` (s)
    is by how much its own clock was behind, nan if that was not looked for.
    """

    name: str
    log: Log
    time: Array
    ideal: Array | None = None
    bandwidth: float = float("nan")
    lag: float = float("nan")

    @property
    def signal(self) -> Array:
        """The samples (n,)."""
        return self.log.samples[:, 0]

    def between(self, first: float, last: float) -> Seen:
        """Only what was seen between two times (s), the last one excluded.

        Raises
        ------
        InputError
            Fewer than 64 samples are left.
        """
        kept = (self.time >= first) & (self.time < last)
        if kept.sum() < _FEWEST:
            raise InputError(
                f"{self.name}: {kept.sum()} samples lie between {first:.6g} s and {last:.6g} s of "
                f"the time that all sensors share; at least {_FEWEST} are needed"
            )
        log = replace(self.log, samples=self.log.samples[kept])
        ideal = None if self.ideal is None else self.ideal[kept]
        return replace(self, log=log, time=self.time[kept], ideal=ideal)


def sensors_named(words: str) -> tuple[str, ...]:
    """The sensors of a list such as ``MTN-1100,MPU-9250@500 Hz,mine.yaml``; the reference first.

    ``all`` stands for every built-in accelerometer with noise, ``platform`` for those that the
    source compares.

    Raises
    ------
    InputError
        An empty list, or a sensor that stands in it twice.
    """
    found: list[str] = []
    for word in (part.strip() for part in words.split(",")):
        found += _GROUPS[word.casefold()]() if word.casefold() in _GROUPS else [word]
    if not all(found):
        raise InputError(f'--sensors "{words}": a name is missing; give {PLATFORM}, or A,B,C')
    for name in found:
        if [other.casefold() for other in found].count(name.casefold()) > 1:
            raise InputError(f"--sensors: {name} stands there twice")
    return tuple(sorted(found, key=lambda name: not _is_reference(name)))


def left_out(words: str) -> tuple[str, ...]:
    """What ``all`` in such a list leaves out, in words."""
    if ALL not in [word.strip().casefold() for word in words.split(",")]:
        return ()
    silent = [
        name
        for name, sensor in catalogue.sensors().items()
        if _ELEMENT in sensor.elements and name not in _all()
    ]
    reason = "left out of all, as no source gives the noise of its accelerometer"
    return tuple(f"{name}: {reason}" for name in silent)


def name_of(sensor: str) -> str:
    """What a sensor of a list is called: ``MPU-9250`` for ``mpu-9250@500 Hz``."""
    model = sensor.partition("@")[0].strip()
    built_in = None if is_file(model) else catalogue.known(model)
    return built_in.name if built_in else Path(model).stem


def _is_reference(name: str) -> bool:
    return name.partition("@")[0].strip().casefold() == REFERENCE.casefold()


def _all() -> list[str]:
    return [
        name
        for name, sensor in catalogue.sensors().items()
        if "noise_density" in sensor.elements.get(_ELEMENT, {})
    ]


def _of_platform() -> list[str]:
    return [
        name
        for name, sensor in catalogue.sensors().items()
        if any(r.source == _OF_PLATFORM for r in sensor.records.get(_ELEMENT, ()))
    ]


_GROUPS: dict[str, Callable[[], list[str]]] = {ALL: _all, PLATFORM: _of_platform}


def scenario_of(path: Path, sensor: str) -> tuple[VibrationScenario, str, tuple[str, ...]]:
    """The scenario in a file as one sensor sees it, the sensor's name, and what to know of it.

    It samples at the rate after its ``@``, else at that of the catalogue (measured, else of the
    data sheet), else at the scenario's.  Its random numbers are its own: the seed is the
    scenario's plus a number made of the name.

    Raises
    ------
    InputError
        As ``mcsim.vibration.scenario.read_vibration``.
    """
    model, _, stated = (part.strip() for part in sensor.partition("@"))
    built_in = None if is_file(model) else catalogue.known(model)
    own = built_in.rate(_ELEMENT) if built_in and _ELEMENT in built_in.elements else None
    scenario = read_vibration(path, model, stated or own, f"--sensors {sensor}")
    name = name_of(sensor)
    seed = (scenario.seed + zlib.crc32(name.encode())) % LARGEST_SEED
    note = f"{name}: no source gives its rate; it samples at the scenario's {scenario.rate:.6g} Hz"
    notes = () if stated or own else (note,)
    return scenario.model_copy(update={"seed": seed}), name, notes


def simulate_seen(path: Path, sensors: Sequence[str], tell: Callable[[str], None]) -> list[Seen]:
    """What each sensor logs of a scenario.

    Parameters
    ----------
    path : Path
        The scenario.
    sensors : sequence of str
        Names, or sensor files, with ``@RATE`` behind those that are to sample otherwise.
    tell : callable
        Hears which one is simulated.

    Raises
    ------
    InputError
        As ``scenario_of``.
    """
    scenarios = [scenario_of(path, sensor) for sensor in sensors]
    seen = []
    for scenario, name, notes in scenarios:
        tell(f"{name}: {scenario.duration:g} s at {scenario.rate:.6g} Hz")
        one = _simulated(scenario, name)
        seen.append(replace(one, log=replace(one.log, notes=(*one.log.notes, *notes))))
    return seen


def _simulated(scenario: VibrationScenario, name: str) -> Seen:
    log = simulate(scenario, name)
    place = log.channels.index(scenario.along)
    alone = replace(log, channels=(scenario.along,), samples=log.samples[:, place : place + 1])
    axis = 0 if len(log.channels) == 1 else AXES.index(scenario.along)
    filters = errors_of(scenario, len(log.channels)).filters[axis]
    known = next((one.bandwidth for one in filters if isinstance(one, LowPass)), math.nan)
    return Seen(name, alone, log.time, ideal_of(scenario, log.time), known)


def ideal_of(scenario: VibrationScenario, time: Array) -> Array:
    """The excitation's acceleration (m/s²) at ``time`` (s), (n,)."""
    return acceleration(scenario.excitation, time, scenario.duration)


def true_one(scenario: VibrationScenario) -> Seen:
    """The excitation itself, at the scenario's rate."""
    time = np.arange(round(scenario.duration * scenario.rate)) / scenario.rate
    ideal = ideal_of(scenario, time)
    log = Log("the scenario", (scenario.along,), ideal[:, None], scenario.rate)
    return Seen(log.name, log, time, ideal)


def from_log(log: Log) -> Seen:
    """What a log of one channel shows; its time begins with its first sample.

    Raises
    ------
    InputError
        The log has several channels.
    """
    if len(log.channels) > 1:
        raise InputError(
            f"{log.name}: has the channels {', '.join(log.channels)}; name the one to compare with "
            "--channel (of each log that one is taken which it holds)"
        )
    return Seen(log.name, log, log.time)


def with_ideal(seen: Seen, scenario: VibrationScenario) -> Seen:
    """With the excitation beside it, as long as it lasts."""
    inside = seen.between(0.0, scenario.duration)
    return replace(inside, ideal=ideal_of(scenario, inside.time))
