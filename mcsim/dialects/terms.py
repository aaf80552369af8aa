"""The quantities of a sensor by mcsim's keys, and the numbers that other tools make of them."""

from __future__ import annotations

from dataclasses import dataclass

from mcsim.units import KINDS, factor

#: The kind of each key's quantity, for the accelerometer and for the gyroscope.
KIND_OF = {
    "noise_density": ("acceleration noise density", "angular rate noise density"),
    "velocity_random_walk": ("velocity random walk",) * 2,
    "angle_random_walk": ("angle random walk",) * 2,
    "miscalibration": ("acceleration", "angular rate"),
    "turn_on_bias": ("acceleration", "angular rate"),
    "scale_factor_error": ("ratio", "ratio"),
    "misalignment": ("angle", "angle"),
    "g_sensitivity": ("g-sensitivity", "g-sensitivity"),
    "bias_instability": ("acceleration", "angular rate"),
    "acceleration_random_walk": ("acceleration random walk",) * 2,
    "rate_random_walk": ("rate random walk",) * 2,
    "gauss_markov.deviation": ("acceleration", "angular rate"),
    "gauss_markov.correlation_time": ("time", "time"),
    "resolution": ("acceleration", "angular rate"),
    "range": ("acceleration", "angular rate"),
    "bandwidth": ("frequency", "frequency"),
    "spikes.rate": ("frequency", "frequency"),
    "spikes.amplitude": ("acceleration", "angular rate"),
}

#: Keys of white noise as Allan's N.
WHITE = ("velocity_random_walk", "angle_random_walk")


def kind_of(key: str, element: str) -> str:
    """Name of the kind of quantity behind a key."""
    return KIND_OF[key][element == "gyroscope"]


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
