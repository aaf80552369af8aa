"""What a vibration scenario may say: an excitation, and the sensor that sees it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from annotated_types import Ge, Le, Len
from pydantic import Field, model_validator

from mcsim import catalogue
from mcsim.errors import InputError
from mcsim.scenario.block import Block, Whole
from mcsim.scenario.document import read_document
from mcsim.scenario.fields import (
    Acceleration,
    Angle,
    Frequency,
    Jerk,
    Length,
    NotNegative,
    Positive,
    RotationalSpeed,
    Speed,
    Time,
    reject,
)
from mcsim.scenario.named_sensor import NamedAccelerometer
from mcsim.scenario.run import LARGEST_SEED
from mcsim.scenario.validation import validate
from mcsim.scenario_file.schema import SCHEMA_DRAFT

CASE = "vibration"
#: More samples than this are not simulated.
MOST_SAMPLES = 20_000_000


class Order(Block):
    """One harmonic of a shaft."""

    order: Annotated[float, Positive, Le(1000.0)]
    """Periods per revolution of the crankshaft."""
    amplitude: Annotated[Acceleration, NotNegative]
    phase: Angle = 0.0


class Harmonic(Block):
    """A machine that turns steadily: a sum of orders."""

    shape: Literal["harmonic"]
    speed: Annotated[RotationalSpeed, Positive]
    """Speed of the crankshaft."""
    cylinders: Annotated[int, Whole, Ge(1), Le(64)] = 4
    """Of a four-stroke engine: half as many firings per revolution."""
    orders: Annotated[tuple[Order, ...], Len(1, 100)]


class Sweep(Block):
    """A shaker that runs through frequencies at a constant amplitude of acceleration."""

    shape: Literal["sweep"]
    first: Annotated[Frequency, Positive]
    """Frequency at the start."""
    last: Annotated[Frequency, Positive]
    """Frequency at the end."""
    amplitude: Annotated[Acceleration, NotNegative]
    scale: Literal["linear", "log"] = "log"
    """How the frequency goes with time."""

    @model_validator(mode="after")
    def _goes_somewhere(self) -> Sweep:
        if self.first == self.last:
            raise reject("`first` and `last` are equal; a harmonic excitation does that")
        return self


class Hum(Block):
    """A vibration of the moving car, growing with its speed."""

    frequency: Annotated[Frequency, Positive]
    amplitude: Annotated[Acceleration, NotNegative]
    """At full speed."""


class Elevator(Block):
    """An elevator's run: trapezoidal velocity with limited jerk."""

    shape: Literal["elevator"]
    distance: Annotated[Length, Positive]
    """Travel, upwards."""
    speed: Annotated[Speed, Positive]
    acceleration: Annotated[Acceleration, Positive]
    """Largest acceleration."""
    jerk: Annotated[Jerk, Positive]
    start: Annotated[Time, NotNegative] = 2.0
    """When the run begins."""
    hum: Annotated[tuple[Hum, ...], Len(0, 20)] = ()

    @model_validator(mode="after")
    def _reaches_its_speed(self) -> Elevator:
        if self.speed * self.jerk < self.acceleration**2:
            raise reject(
                f"the acceleration cannot be reached: with this jerk and speed the largest is "
                f"{(self.speed * self.jerk) ** 0.5:.3g} m/s²"
            )
        needed = self.speed * (self.speed / self.acceleration + self.acceleration / self.jerk)
        if self.distance < needed:
            raise reject(
                f"the distance is too short to reach the speed: at least {needed:.3g} m are needed"
            )
        return self


Excitation = Annotated[Harmonic | Sweep | Elevator, Field(discriminator="shape")]


class Chain(Block):
    """The processing of a log before it is looked at; zero leaves a step out."""

    moving_average: Annotated[int, Whole, Ge(0), Le(100_000)] = 10
    """Samples of the moving average."""
    high_pass: Annotated[Frequency, NotNegative] = 2.0
    low_pass: Annotated[Frequency, NotNegative] = 50.0

    @model_validator(mode="after")
    def _leaves_a_band(self) -> Chain:
        if 0.0 < self.low_pass <= self.high_pass:
            raise reject("`low_pass` must lie above `high_pass`")
        return self


class VibrationScenario(Block):
    """An excitation seen by an accelerometer."""

    case: Literal["vibration"]
    title: str | None = None
    """One line for people."""
    sensor: NamedAccelerometer
    """A built-in sensor's name, or a block of its errors."""
    rate: Annotated[Frequency, Ge(1.0), Le(1e6)]
    """Output rate of the sensor."""
    duration: Annotated[Time, Positive]
    along: Literal["x", "y", "z"] = "z"
    """Axis of the excitation."""
    gravity: bool = True
    """Whether the z axis also senses gravity."""
    seed: Annotated[int, Whole, Ge(0), Le(LARGEST_SEED)] = 1
    excitation: Excitation
    analysis: Chain = Chain()

    @model_validator(mode="after")
    def _samples_fit(self) -> VibrationScenario:
        count = self.duration * self.rate
        if not 64 <= count <= MOST_SAMPLES:
            raise reject(
                f"duration times rate are {count:,.0f} samples; "
                f"between 64 and {MOST_SAMPLES:,} can be simulated"
            )
        return self


def is_vibration(path: Path) -> bool:
    """Whether a scenario file says ``case: vibration``.

    Raises
    ------
    InputError
        Not readable.
    """
    return bool(read_document(path).tree.get("case") == CASE)


def read_vibration(path: Path, sensor: str | None = None) -> VibrationScenario:
    """The vibration scenario in a file; ``sensor`` takes the place of its own.

    Raises
    ------
    InputError
        Not readable, another case, or not valid; one line per problem.
    """
    document = replace(read_document(path), folder=path.parent)
    case = document.tree.get("case")
    if case != CASE:
        raise InputError(f'{document.place(("case",))}: case: "{case}" is not `case: {CASE}`')
    if sensor is not None:
        tree = {**document.tree, "sensor": sensor}
        document = replace(document, tree=tree, overrides={("sensor",): "--sensor"})
        # An option's file lies where the command is given.
        document = replace(document, folder=Path())
    scenario = validate(document, VibrationScenario)
    errors = scenario.sensor
    if errors.model and not errors.has_noise:
        raise InputError(
            f"{document.place(('sensor',))}: sensor: {errors.model}: its source gives no noise "
            f"density; write `sensor: {{model: {errors.model}, noise_density: …}}`"
        )
    return scenario


def vibration_schema() -> dict[str, Any]:
    """The JSON schema (draft 7) of vibration scenarios."""
    schema = VibrationScenario.model_json_schema(
        by_alias=True, ref_template="#/definitions/{model}"
    )
    definitions = schema.pop("$defs")
    names = [s.name for s in catalogue.sensors().values() if "accelerometer" in s.elements]
    block = definitions["AccelerometerErrors"]
    definitions["AccelerometerErrors"] = {
        "anyOf": [{"enum": names, "description": "A sensor of the catalogue"}, block]
    }
    excitation = schema["properties"]["excitation"]
    excitation.pop("discriminator", None)
    return {
        "$schema": SCHEMA_DRAFT,
        "title": "mcsim vibration scenario",
        **{key: value for key, value in schema.items() if key != "title"},
        "definitions": definitions,
    }
