"""The errors that the cases report, with their units in tables and figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

ErrorName = Literal[
    "along",
    "across",
    "height",
    "position",
    "roll",
    "pitch",
    "heading",
    "course",
    "velocity",
    "mean_velocity",
    "repeatability",
]
ERROR_NAMES: tuple[ErrorName, ...] = get_args(ErrorName)
#: Unit of each error in tables and figures.
UNITS: dict[str, str] = {
    "along": "m",
    "across": "m",
    "height": "m",
    "position": "m",
    "roll": "deg",
    "pitch": "deg",
    "heading": "deg",
    "course": "deg",
    "velocity": "m/s",
    "mean_velocity": "m/s",
    "repeatability": "m/s",
}


@dataclass(frozen=True)
class ErrorRow:
    """One error of a case, at the end or at an instant (s after the first sample)."""

    name: ErrorName
    time: float | None = None

    @property
    def label(self) -> str:
        """A name that tells the rows of a case apart."""
        return self.name if self.time is None else f"{self.name} at {self.time:.6g} s"

    @property
    def unit(self) -> str:
        return UNITS[self.name]
