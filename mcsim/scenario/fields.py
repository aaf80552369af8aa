"""Field types of scenarios: a quantity is text with a unit outside, an SI float inside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from annotated_types import Ge, Gt
from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from mcsim.errors import UnitError
from mcsim.units import KINDS, NUMBER_PATTERN, Kind, parse, parse_confidence


def reject(message: str) -> PydanticCustomError:
    """A validation error that carries our own sentence."""
    return PydanticCustomError("mcsim", "{message}", {"message": message})


#: Units of kinds whose SI unit has no sign.
_WRITTEN = {"ratio": ("%", "ppm"), "ratio per kelvin": ("%/K", "ppm/K")}


@dataclass(frozen=True)
class Quantity:
    """Marks a float field that is written as a number with a unit of ``kind``."""

    kind: str

    @property
    def details(self) -> Kind:
        return KINDS[self.kind]

    def read(self, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise reject(f'expected {self.details}, for example "{self.details.example}"')
        text = value if isinstance(value, str) else f"{value:.15g}"
        try:
            if self.kind == "confidence":
                return parse_confidence(text)
            return parse(text, self.details)
        except UnitError as error:
            raise reject(str(error)) from None

    def write(self, value: float) -> str:
        """A text that reads back to the same value, if it came from one of 15 digits at least."""
        units = _WRITTEN.get(self.kind, (self.details.si_unit,))
        texts = [
            f"{value / self.details.factors[unit]:.{digits}g} {unit}"
            for digits in (15, 16, 17)
            for unit in units
        ]
        return next((text for text in texts if self.read(text) == value), texts[0])

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_before_validator_function(
            self.read,
            handler(source),
            serialization=core_schema.plain_serializer_function_ser_schema(self.write),
        )

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {
            "type": "string",
            "pattern": rf"^\s*{NUMBER_PATTERN}\s*[^\s\d.].*$",
            "description": f"{self.details} with its unit: {', '.join(self.details.factors)}",
            "examples": [self.details.example],
        }


Length = Annotated[float, Quantity("length")]
Time = Annotated[float, Quantity("time")]
Angle = Annotated[float, Quantity("angle")]
Frequency = Annotated[float, Quantity("frequency")]
Speed = Annotated[float, Quantity("speed")]
Acceleration = Annotated[float, Quantity("acceleration")]
AngularRate = Annotated[float, Quantity("angular rate")]
AccelerationNoiseDensity = Annotated[float, Quantity("acceleration noise density")]
RateNoiseDensity = Annotated[float, Quantity("angular rate noise density")]
VelocityRandomWalk = Annotated[float, Quantity("velocity random walk")]
AngleRandomWalk = Annotated[float, Quantity("angle random walk")]
SensorOutput = Annotated[float, Quantity("sensor output")]
AccelerationRandomWalk = Annotated[float, Quantity("acceleration random walk")]
RateRandomWalk = Annotated[float, Quantity("rate random walk")]
GSensitivity = Annotated[float, Quantity("g-sensitivity")]
Jerk = Annotated[float, Quantity("jerk")]
RotationalSpeed = Annotated[float, Quantity("rotational speed")]
AngleGradient = Annotated[float, Quantity("angle gradient")]
TemperatureDifference = Annotated[float, Quantity("temperature difference")]
TemperatureRate = Annotated[float, Quantity("temperature rate")]
Ratio = Annotated[float, Quantity("ratio")]
Confidence = Annotated[float, Quantity("confidence")]

Positive = Gt(0)
NotNegative = Ge(0)
