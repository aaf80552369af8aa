"""What a vibration scenario may say: an excitation, and the sensor that sees it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from annotated_types import Ge, Le
from pydantic import model_validator

from mcsim import catalogue
from mcsim.errors import InputError
from mcsim.scenario.block import Block, Whole
from mcsim.scenario.document import PathKey, read_document
from mcsim.scenario.fields import Frequency, NotNegative, Positive, Time, reject
from mcsim.scenario.named_sensor import NamedAccelerometer
from mcsim.scenario.run import LARGEST_SEED
from mcsim.scenario.temperature import Temperature
from mcsim.scenario.validation import validate
from mcsim.scenario_file.schema import SCHEMA_DRAFT
from mcsim.vibration.excitations import AnyExcitation

CASE = "vibration"
#: More samples than this are not simulated.
MOST_SAMPLES = 20_000_000


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
    ac_corner: Annotated[Frequency, Positive] | None = None
    """Lower limit (first order, -3 dB) of an AC-coupled sensor whose source gives none; other
    sensors are as they are."""
    temperature: Temperature | None = None
    """Of the sensor, less that of its calibration."""
    seed: Annotated[int, Whole, Ge(0), Le(LARGEST_SEED)] = 1
    excitation: AnyExcitation
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


def read_vibration(
    path: Path, sensor: str | None = None, rate: str | None = None, option: str = "--sensor"
) -> VibrationScenario:
    """The vibration scenario in a file; ``sensor`` and ``rate`` take the place of its own.

    ``option`` is what messages say of the two.

    Raises
    ------
    InputError
        Not readable, another case, or not valid; one line per problem.
    """
    document = replace(read_document(path), folder=path.parent)
    case = document.tree.get("case")
    if case != CASE:
        raise InputError(f'{document.place(("case",))}: case: "{case}" is not `case: {CASE}`')
    given = {"sensor": sensor, "rate": rate}
    chosen = {key: value for key, value in given.items() if value is not None}
    if chosen:
        overrides: dict[PathKey, str] = {(key,): option for key in chosen}
        document = replace(document, tree={**document.tree, **chosen}, overrides=overrides)
    if sensor is not None:
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
    return {
        "$schema": SCHEMA_DRAFT,
        "title": "mcsim vibration scenario",
        **{key: value for key, value in schema.items() if key != "title"},
        "definitions": definitions,
    }
