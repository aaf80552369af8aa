"""``mcsim table gravity-leakage``: Table 1 of the application note, gravity through wrong attitude.

A vehicle at rest whose attitude is wrong by ``eps`` takes ``g sin(eps)`` of gravity for an
acceleration: ``g sin(eps) t`` of velocity, ``g sin(eps) t^2 / 2`` of position.  That holds for
minutes: over longer times the earth's curvature turns the error into a Schuler oscillation of
84 minutes, which neither the note nor mcsim's level frame has.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from mcsim.papers import Computed, PaperTable
from mcsim.papers.application_note import PRINTED
from mcsim.text_table import columns
from mcsim.units import KINDS, STANDARD_GRAVITY, parse

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
Quantity = Literal["acceleration", "velocity", "position"]

#: The note's gravity (m/s^2).
NOTE_GRAVITY = 9.8
#: Sampling rate of the simulated vehicle (Hz).
RATE = 20.0
_COLUMNS: tuple[tuple[Quantity, float], ...] = (
    ("acceleration", 1.0),
    ("velocity", 10.0),
    ("position", 10.0),
    ("position", 60.0),
    ("position", 600.0),
    ("position", 3600.0),
)
_UNITS = {"acceleration": "m/s²", "velocity": "m/s", "position": "m"}
_TIMES = {1.0: "", 10.0: " at 10 s", 60.0: " at 1 min", 600.0: " at 10 min", 3600.0: " at 1 h"}
_HEADER = ["angle", "printed", "exact", "g = 9.8", "simulated", "printed / (g = 9.8)"]
_CONCLUSION = """\
exact: standard gravity, 9.80665 m/s²; simulated: the strapdown kernel at {rate:g} Hz with the
note's recursion, which lags by T/t. Beyond some minutes the earth's curvature would bound the
error (Schuler), in neither column."""
#: Printed values that differ by less do so by rounding.
_ROUNDED = 0.05


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
    from mcsim.kernels import strapdown
    from mcsim.systems.strapdown.undisturbed import integrated

    n = round(duration * RATE)
    signals = np.zeros((n + 1, strapdown.Strapdown.CHANNELS))
    signals[:, 3] = STANDARD_GRAVITY
    start = strapdown.AT_ORIGIN._replace(roll=-tilt)
    history = integrated(start, signals, "forward_euler", 1.0 / RATE)
    return history[4], history[1]


def leakage_table() -> Computed:
    """The table, printed, in closed form, and simulated."""
    entries = list(gravity_leakage())
    return Computed({"gravity-leakage": _frame(entries)}, _text(entries))


def _text(entries: list[Leakage]) -> str:
    rows: dict[tuple[str, float], list[list[str]]] = {}
    for entry in entries:
        numbers = (entry.printed, entry.exact, entry.with_9_8, entry.simulated)
        cells = [entry.angle, *map(_plain, numbers), f"{entry.ratio:.3f}"]
        rows.setdefault((entry.quantity, entry.time), [_HEADER]).append(cells)
    blocks = [
        "\n".join([f"{quantity} error{_TIMES[time]} [{_UNITS[quantity]}]", *columns(block)])
        for (quantity, time), block in rows.items()
    ]
    return "\n\n".join([*blocks, f"{verdict(entries)}\n{_CONCLUSION.format(rate=RATE)}"])


def verdict(entries: list[Leakage]) -> str:
    """How the printed values compare with g sin(angle), a t and a t²/2, from their ratios."""
    ratios = {name: [entry.ratio for entry in entries if entry.quantity == name] for name in _UNITS}
    others = [*ratios["acceleration"], *ratios["velocity"]]
    off = max(abs(ratio - 1.0) for ratio in others)
    first = (
        "Accelerations are g sin(angle), velocities a t: as printed, to the note's rounding."
        if off < _ROUNDED
        else "Accelerations are g sin(angle), velocities a t; printed values differ by up to "
        f"{off:.0%}."
    )
    middle = median(ratios["position"])
    second = "Positions are a t²/2, which is what the note's own recursion gives; the printed ones "
    if abs(middle / 2.0 - 1.0) < _ROUNDED:
        second += f"are a t²,\ntoo large by a factor of two (median ratio {middle:.2f})."
    elif abs(middle - 1.0) < _ROUNDED:
        second += f"agree\n(median ratio {middle:.2f})."
    else:
        second += f"are\n{middle:.2f} times that (median)."
    return f"{first}\n{second}"


def _plain(number: float) -> str:
    """Four significant digits without an exponent."""
    rounded = float(f"{number:.4g}")
    return f"{rounded:,.0f}" if rounded >= 1000.0 else f"{rounded:g}"


def _frame(entries: list[Leakage]) -> pd.DataFrame:
    import pandas as pd

    return pd.DataFrame(
        {
            "quantity": [e.quantity for e in entries],
            "time [s]": [e.time for e in entries],
            "angle": [e.angle for e in entries],
            "unit": [_UNITS[e.quantity] for e in entries],
            "printed": [e.printed for e in entries],
            "exact": [e.exact for e in entries],
            "g = 9.8": [e.with_9_8 for e in entries],
            "simulated": [e.simulated for e in entries],
        }
    )


TABLE = PaperTable(
    "gravity-leakage",
    "Errors of a vehicle at rest whose attitude is wrong, printed and recomputed.",
    leakage_table,
    files=("gravity-leakage",),
)
