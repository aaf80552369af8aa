"""A vibration scenario as the log that its sensor would have written."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mcsim import catalogue
from mcsim.sensor_terms.channel import ACCELEROMETER, Channel
from mcsim.sensor_terms.mechanisms.high_pass import HighPass
from mcsim.sensors.error_model import ChannelErrors, Conditions, element_errors
from mcsim.sensors.simulated_log import SimulatedLog
from mcsim.units import STANDARD_GRAVITY
from mcsim.vibration.excitations import acceleration
from mcsim.vibration.log import Log
from mcsim.vibration.scenario import VibrationScenario

AXES = ("x", "y", "z")
#: The dense signal is this much faster than the sensor's filters, up to a limit (Hz): a tone at
#: its cut-off then loses 0.1 % more than it should, by the straight lines between dense samples.
_DENSER, _DENSEST = 64.0, 100_000.0
#: Dense samples that are worked on at a time.
_PIECE = 1 << 18


def simulate(
    scenario: VibrationScenario, name: str, progress: Callable[[float], None] = lambda _: None
) -> Log:
    """The simulated log: channels x, y, z in m/s², or that of the one axis that a sensor has.

    A sensor of one axis lies along the excitation; one that is AC-coupled reads no gravity, and
    behind its lower limit no steady acceleration.

    Parameters
    ----------
    scenario : VibrationScenario
    name : str
        Name of the log.
    progress : callable
        Is told the share done, 0 to 1.
    """
    built_in = scenario.sensor.built_in
    alone = built_in is not None and built_in.axes("accelerometer") == 1
    channels = (scenario.along,) if alone else AXES
    errors = errors_of(scenario, len(channels))
    # The source of an AC-coupled sensor may give no lower limit.
    constant = built_in is None or not built_in.ac_coupled("accelerometer") or _coupled(errors)
    dense = oversampling(errors)
    count = round(scenario.duration * scenario.rate)
    element = SimulatedLog(errors, scenario.seed, dense)
    pieces = []
    for first in range(0, count * dense, _PIECE):
        last = min(first + _PIECE, count * dense)
        time = np.arange(first, last) / (scenario.rate * dense)
        ideal = np.zeros((last - first, len(channels)))
        ideal[:, channels.index(scenario.along)] = acceleration(
            scenario.excitation, time, scenario.duration
        )
        if scenario.gravity and constant and "z" in channels:
            ideal[:, channels.index("z")] += STANDARD_GRAVITY
        pieces.append(element.measure(ideal))
        progress(last / (count * dense))
    notes = _notes(built_in, scenario, errors) if built_in is not None else ()
    return Log(name, channels, np.vstack(pieces), scenario.rate, notes)


def _coupled(errors: ChannelErrors) -> bool:
    return any(isinstance(one, HighPass) for own in errors.filters for one in own)


def _notes(
    sensor: catalogue.Sensor, scenario: VibrationScenario, errors: ChannelErrors
) -> tuple[str, ...]:
    """What a sensor of its kind does not see."""
    notes = []
    if sensor.axes("accelerometer") == 1:
        notes.append(f"{sensor.name} has one axis, which lies along {scenario.along}")
    if sensor.ac_coupled("accelerometer"):
        known = _coupled(errors)
        notes.append(
            f"{sensor.name} is AC-coupled and reads no gravity"
            + (
                ", nor any steady acceleration"
                if known
                else "; its lower limit, which the source "
                "does not give, is not simulated: write `ac_corner`"
            )
        )
    return tuple(notes)


def errors_of(scenario: VibrationScenario, axes: int) -> ChannelErrors:
    """The errors of the sensor's one axis or three."""
    channels = [Channel(ACCELEROMETER, axis) for axis in range(axes)]
    errors = element_errors(
        {ACCELEROMETER: scenario.sensor},
        scenario.rate,
        channels,
        scenario.duration,
        conditions=Conditions(temperature=scenario.temperature),
    )
    built_in, corner = scenario.sensor.built_in, scenario.ac_corner
    if corner is None or built_in is None or not built_in.ac_coupled("accelerometer"):
        return errors
    if _coupled(errors):
        return errors
    return replace(errors, filters=tuple((HighPass(corner), *own) for own in errors.filters))


def oversampling(errors: ChannelErrors) -> int:
    """Dense samples per output sample that the element's filters need."""
    finite = [one.fastest for own in errors.filters for one in own]
    if not finite:
        return 1
    rate = 1.0 / errors.interval
    wanted = min(_DENSER * max(finite), max(_DENSEST, rate))
    return max(1, math.ceil(wanted / rate))
