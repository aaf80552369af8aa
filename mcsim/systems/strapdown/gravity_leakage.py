"""Table 1 of the application note: what gravity does through an error of the attitude.

A vehicle at rest whose attitude is wrong by ``eps`` takes ``g sin(eps)`` of gravity for an
acceleration: ``g sin(eps) t`` of velocity, ``g sin(eps) t^2 / 2`` of position.  That holds for
minutes: over longer times the earth's curvature turns the error into a Schuler oscillation of
84 minutes, which neither the note nor mcsim's level frame has.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mcsim.kernels import strapdown
from mcsim.systems.strapdown.undisturbed import integrated
from mcsim.units import KINDS, STANDARD_GRAVITY, parse

Array = NDArray[np.float64]
Quantity = Literal["acceleration", "velocity", "position"]

#: The note's gravity (m/s^2).
NOTE_GRAVITY = 9.8
#: Sampling rate of the simulated vehicle (Hz).
RATE = 20.0
#: Table 1 as printed: acceleration (m/s^2), velocity at 10 s (m/s), position (m) at 10 s,
#: 1 min, 10 min, 1 h, by the angle in degrees.
PRINTED: dict[str, tuple[float, ...]] = {
    "0.1 °": (0.017, 0.17, 1.7, 61.2, 6120.0, 220e3),
    "0.5 °": (0.086, 0.86, 8.6, 309.6, 30960.0, 1.1e6),
    "1 °": (0.17, 1.7, 17.0, 612.0, 61200.0, 2.2e6),
    "1.5 °": (0.256, 2.56, 25.6, 921.6, 92160.0, 3.3e6),
    "2 °": (0.342, 3.42, 34.2, 1231.2, 123120.0, 4.4e6),
    "3 °": (0.513, 5.13, 51.3, 1846.8, 184680.0, 6.6e6),
    "5 °": (0.854, 8.54, 85.4, 3074.4, 307440.0, 11e6),
}
_COLUMNS: tuple[tuple[Quantity, float], ...] = (
    ("acceleration", 1.0),
    ("velocity", 10.0),
    ("position", 10.0),
    ("position", 60.0),
    ("position", 600.0),
    ("position", 3600.0),
)


@dataclass(frozen=True)
class Leakage:
    """One entry of the table, in SI units.

    ``exact`` and ``with_9_8`` are the closed form with standard gravity and with the note's,
    ``simulated`` is what the strapdown kernel makes of a vehicle at rest.
    """

    quantity: Quantity
    time: float
    angle: str
    printed: float
    exact: float
    with_9_8: float
    simulated: float

    @property
    def ratio(self) -> float:
        """Printed value by closed form with the note's gravity."""
        return self.printed / self.with_9_8


def closed_form(quantity: Quantity, angle: float, time: float, gravity: float) -> float:
    """``g sin(eps)`` and what it has summed to after ``time``; SI units."""
    power = {"acceleration": 1.0, "velocity": time, "position": 0.5 * time**2}
    return gravity * math.sin(angle) * power[quantity]


def gravity_leakage() -> Iterator[Leakage]:
    """The entries of Table 1, angle by angle; each angle takes a moment to simulate."""
    for angle, printed in PRINTED.items():
        tilt = parse(angle, KINDS["angle"])
        velocity, position = simulate_at_rest(tilt, _COLUMNS[-1][1])
        for (quantity, time), value in zip(_COLUMNS, printed, strict=True):
            sample = round(time * RATE)
            # The acceleration is the velocity after one second, by that second.
            simulated = position[sample] if quantity == "position" else velocity[sample]
            yield Leakage(
                quantity,
                time,
                angle,
                value,
                closed_form(quantity, tilt, time, STANDARD_GRAVITY),
                closed_form(quantity, tilt, time, NOTE_GRAVITY),
                float(simulated),
            )


def simulate_at_rest(tilt: float, duration: float) -> tuple[Array, Array]:
    """Velocity and position across (n + 1,) that the strapdown kernel finds at rest.

    Ideal sensors at ``RATE``, the note's forward Euler recursion, a roll wrong by ``tilt`` (rad).
    """
    n = round(duration * RATE)
    signals = np.zeros((n + 1, strapdown.Strapdown.CHANNELS))
    signals[:, 3] = STANDARD_GRAVITY
    start = strapdown.AT_ORIGIN._replace(roll=-tilt)
    history = integrated(start, signals, "forward_euler", 1.0 / RATE)
    return history[4], history[1]
