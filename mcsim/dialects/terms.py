"""The quantities of a sensor by mcsim's keys, and the numbers that other tools make of them."""

from __future__ import annotations

from dataclasses import dataclass

from mcsim.units import KINDS, factor

#: Keys of white noise as Allan's N.
WHITE = ("velocity_random_walk", "angle_random_walk")


def kind_of(key: str, element: str) -> str:
    """Name of the kind of quantity behind a key."""
    from mcsim.sensor_terms import find_key

    return find_key(key, element).kind_for(element)


@dataclass(frozen=True)
class Term:
    """A number of another tool: its name there, the key here, the unit there.

    ``tool`` and ``remark`` are words beside it in a list of all tools.
    """

    name: str
    element: str
    key: str
    unit: str
    tool: str = ""
    remark: str = ""

    @property
    def si(self) -> float:
        """SI value of one unit."""
        return factor(self.unit, KINDS[kind_of(self.key, self.element)])


def terms_of(tool: str, *rows: tuple[str, str, str, str]) -> tuple[Term, ...]:
    """The terms of a tool whose white noise is Allan's N: name, element, key and unit of each."""
    return tuple(
        Term(*row, tool, f"{row[3]}, two-sided" if row[2] in WHITE else row[3]) for row in rows
    )
