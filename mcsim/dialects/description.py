"""What all dialects are read into: the errors of a sensor's elements, SI, by mcsim's keys."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from pydantic import BaseModel

from mcsim.errors import InputError
from mcsim.units import Kind, parse

if TYPE_CHECKING:
    from mcsim.scenario.sensor_block import AccelerometerErrors, GyroscopeErrors
    from mcsim.scenario.sensor_file import SensorFile

Values = tuple[float, ...]
Quantities = Mapping[str, Values]

ELEMENTS = ("accelerometer", "gyroscope")
AXES = ("x", "y", "z")
#: Allan's N and K under the names that each element gives them.
RANDOM_WALK = {"accelerometer": "velocity_random_walk", "gyroscope": "angle_random_walk"}
BIAS_WALK = {"accelerometer": "acceleration_random_walk", "gyroscope": "rate_random_walk"}
DEVIATION, CORRELATION_TIME = "gauss_markov.deviation", "gauss_markov.correlation_time"


@dataclass(frozen=True)
class Description:
    """A sensor: ``elements`` maps an element to its quantities.

    A quantity's key is that of the sensor block (``gauss_markov.deviation`` for a block
    inside it), its value a tuple of one SI number for all axes, or of three.
    """

    name: str | None = None
    rate: float | None = None
    elements: Mapping[str, Quantities] = field(default_factory=dict)


@dataclass(frozen=True)
class Reading:
    """A description, and what a reader of it should know."""

    description: Description
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Assumptions:
    """The user's answers to what a dialect leaves open."""

    answers: Mapping[str, str] = field(default_factory=dict)
    rate: float | None = None
    axis: str | None = None

    def answer(self, key: str, question: str, choices: Mapping[str, str]) -> str:
        """The answer given to ``key``, one of ``choices``.

        Raises
        ------
        InputError
            None or another was given; the message says what each choice means.
        """
        given = self.answers.get(key)
        if given in choices:
            return str(given)
        options = "\n".join(f"--assume {key}={c}: {meaning}" for c, meaning in choices.items())
        wrong = f' ("{given}" is none of them)' if given is not None else ""
        raise InputError(f"{question}; say which{wrong}:\n{options}")

    def quantity(self, key: str, why: str, kind: Kind, example: str) -> float:
        """The SI value above zero that was given to ``key``.

        Raises
        ------
        InputError
            It was not given, or is no such quantity; ``why`` says what needs it.
        """
        given = self.answers.get(key)
        if given is None:
            raise InputError(f"{why}; state it, for example --assume '{key}={example}'")
        value = parse(given, kind)
        if value <= 0.0:
            raise InputError(f"--assume {key}={given}: must be above zero")
        return value

    def required_rate(self, why: str) -> float:
        """The sampling rate (Hz).

        Raises
        ------
        InputError
            It was not given; ``why`` says what needs it.
        """
        if self.rate is None:
            raise InputError(f"{why}; give it with --rate, for example --rate '100 Hz'")
        return self.rate

    def one(self, values: Values, what: str) -> float:
        """The one number for a dialect that does not tell axes apart.

        Raises
        ------
        InputError
            The axes differ and no axis was chosen.
        """
        if len(set(values)) == 1:
            return values[0]
        if self.axis == "largest":
            return max(values)
        if self.axis in AXES:
            return three(values)[AXES.index(self.axis)]
        shown = " / ".join(f"{value:.4g}" for value in values)
        raise InputError(
            f"{what} differs between the axes ({shown}), and this dialect has one value for all; "
            "choose with --axis x, y, z or largest"
        )


def describe_file(sensor: SensorFile) -> Description:
    """The description of a validated sensor file."""
    blocks = {element: getattr(sensor, element) for element in ELEMENTS}
    return Description(
        sensor.name,
        sensor.rate,
        {element: _flat(block) for element, block in blocks.items() if block is not None},
    )


def _flat(block: AccelerometerErrors | GyroscopeErrors) -> dict[str, Values]:
    flat: dict[str, Values] = {}
    for name in type(block).model_fields:
        value = getattr(block, name)
        if name == "model" or value is None:
            continue
        if isinstance(value, BaseModel):
            for inner in type(value).model_fields:
                given = getattr(value, inner)
                flat[f"{name}.{inner}"] = given if isinstance(given, tuple) else (given,)
        else:
            flat[name] = value
    return flat


def two_sided(quantities: Quantities, element: str) -> Values | None:
    """White noise as Allan's N, in whichever convention it was given.

    Parameters
    ----------
    quantities : mapping
        Of an element, by key; SI, a value or three.
    element : str
        ``accelerometer`` or ``gyroscope``.

    Returns
    -------
    tuple of float or None
        m/s²/√Hz or rad/s/√Hz; None without white noise.
    """
    walk = quantities.get(RANDOM_WALK[element])
    density = quantities.get("noise_density")
    if walk is None and density is not None:
        return tuple(value / math.sqrt(2.0) for value in density)
    return walk


def three(values: Values) -> Values:
    """One number per axis."""
    return values * 3 if len(values) == 1 else values


def left_out(quantities: Quantities, carried: set[str]) -> list[str]:
    """The keys that a dialect has no words for; zeros need none."""
    return [key for key, values in quantities.items() if key not in carried and any(values)]
