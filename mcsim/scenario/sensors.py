"""The sensors block: error parameters of the measured channels."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from annotated_types import Ge, Le
from pydantic import BeforeValidator, model_validator

from mcsim import catalogue
from mcsim.errors import InputError
from mcsim.scenario.block import Block
from mcsim.scenario.fields import (
    Acceleration,
    AccelerationNoiseDensity,
    AngleRandomWalk,
    AngularRate,
    Frequency,
    NotNegative,
    Positive,
    RateNoiseDensity,
    VelocityRandomWalk,
    reject,
)
from mcsim.units import density_from_random_walk


def _named_sensor(element: str) -> Any:
    """Accept a sensor's name for its block, and fill the block from the catalogue."""

    def expand(value: Any) -> Any:
        block = {"model": value} if isinstance(value, str) else value
        if not isinstance(block, dict) or not isinstance(block.get("model"), str):
            return block
        try:
            known = catalogue.element(block["model"], element)
        except InputError as error:
            raise reject(str(error)) from None
        given = block.keys() & {"noise_density", "velocity_random_walk", "angle_random_walk"}
        if given:
            return block
        if "noise_density" not in known:
            raise reject(
                f"{block['model']}: its source gives no noise density; "
                f"write `{element}: {{model: {block['model']}, noise_density: …}}`"
            )
        return {**block, "noise_density": known["noise_density"]}

    return BeforeValidator(expand)


def _one_noise(block: Block, names: tuple[str, str], example: str) -> None:
    given = [name for name in names if getattr(block, name) is not None]
    if len(given) == 2:
        raise reject(f"`{names[0]}` and `{names[1]}` say the same thing twice; keep one")
    if not given:
        raise reject(f"write `noise_density: {example}` (zero for none), or name a `model`")


class Accelerometer(Block):
    """All accelerometer axes of the case."""

    model: str | None = None
    """Name of a built-in sensor (`mcsim sensors`); its values hold unless written here."""
    noise_density: Annotated[AccelerationNoiseDensity, NotNegative] | None = None
    """White noise, one-sided density as data sheets print it."""
    velocity_random_walk: Annotated[VelocityRandomWalk, NotNegative] | None = None
    """White noise as Allan's N (two-sided), instead of `noise_density`."""
    miscalibration: Annotated[Acceleration, NotNegative] = 0.0
    """Standard deviation of the constant offset drawn once per realization and axis."""

    @model_validator(mode="after")
    def _noise_given_once(self) -> Accelerometer:
        _one_noise(self, ("noise_density", "velocity_random_walk"), "2.2e-3 m/s²/√Hz")
        return self

    @property
    def density(self) -> float:
        """One-sided noise density, m/s²/√Hz."""
        if self.velocity_random_walk is not None:
            return density_from_random_walk(self.velocity_random_walk)
        return self.noise_density or 0.0


class Gyroscope(Block):
    """All gyroscopes of the case."""

    model: str | None = None
    """Name of a built-in sensor (`mcsim sensors`); its values hold unless written here."""
    noise_density: Annotated[RateNoiseDensity, NotNegative] | None = None
    """White noise, one-sided density as data sheets print it."""
    angle_random_walk: Annotated[AngleRandomWalk, NotNegative] | None = None
    """White noise as Allan's N (two-sided), instead of `noise_density`."""
    miscalibration: Annotated[AngularRate, NotNegative] = 0.0
    """Standard deviation of the constant offset drawn once per realization."""

    @model_validator(mode="after")
    def _noise_given_once(self) -> Gyroscope:
        _one_noise(self, ("noise_density", "angle_random_walk"), "0.03 °/s/√Hz")
        return self

    @property
    def density(self) -> float:
        """One-sided noise density, rad/s/√Hz."""
        if self.angle_random_walk is not None:
            return density_from_random_walk(self.angle_random_walk)
        return self.noise_density or 0.0


class Sensors(Block):
    """The measured channels: those of acceleration, and those of angular rate."""

    rate: Annotated[Frequency, Positive, Ge(0.1), Le(100_000.0)]
    """Output rate of the sensors."""
    sampling: Literal["fir", "iir", "none", "average"] = "fir"
    """From dense truth to samples: filtered, picked, or averaged over the interval."""
    accelerometer: Annotated[Accelerometer, _named_sensor("accelerometer")]
    gyroscope: Annotated[Gyroscope, _named_sensor("gyroscope")]
