"""A vibration scenario as the log that its sensor would have written."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from mcsim.sensors.signal_errors import Element, SignalErrors, signal_errors
from mcsim.units import STANDARD_GRAVITY
from mcsim.vibration.excitation import acceleration
from mcsim.vibration.log import Log
from mcsim.vibration.scenario import VibrationScenario

AXES = ("x", "y", "z")
#: The dense signal is this much faster than the sensor's low-pass, up to a limit (Hz).
_DENSER, _DENSEST = 8.0, 100_000.0
#: Dense samples that are worked on at a time.
_PIECE = 1 << 18


def simulate(
    scenario: VibrationScenario, name: str, progress: Callable[[float], None] = lambda _: None
) -> Log:
    """The simulated log: three channels x, y, z in m/s².

    Parameters
    ----------
    scenario : VibrationScenario
    name : str
        Name of the log.
    progress : callable
        Is told the share done, 0 to 1.
    """
    errors = signal_errors(scenario.sensor)
    dense = oversampling(errors, scenario.rate)
    count = round(scenario.duration * scenario.rate)
    element = Element(errors, scenario.rate, scenario.duration, scenario.seed, dense)
    axis = AXES.index(scenario.along)
    pieces = []
    for first in range(0, count * dense, _PIECE):
        last = min(first + _PIECE, count * dense)
        time = np.arange(first, last) / (scenario.rate * dense)
        ideal = np.zeros((last - first, len(AXES)))
        ideal[:, axis] = acceleration(scenario.excitation, time, scenario.duration)
        if scenario.gravity:
            ideal[:, 2] += STANDARD_GRAVITY
        pieces.append(element.measure(ideal))
        progress(last / (count * dense))
    return Log(name, AXES, np.vstack(pieces), scenario.rate)


def oversampling(errors: SignalErrors, rate: float) -> int:
    """Dense samples per output sample that the element's low-pass needs."""
    finite = errors.bandwidth[np.isfinite(errors.bandwidth)]
    if not len(finite):
        return 1
    wanted = min(_DENSER * float(finite.max()), max(_DENSEST, rate))
    return max(1, math.ceil(wanted / rate))
