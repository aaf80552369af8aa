"""The block that describes one sensing element's errors, as files and the catalogue write it.

One set of keys serves sensor files, vibration scenarios and the catalogue.  A value
is one quantity for all axes, or a list [x, y, z].
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    GetJsonSchemaHandler,
    PrivateAttr,
    ValidationInfo,
    model_validator,
)
from pydantic_core import CoreSchema

from mcsim import catalogue
from mcsim.errors import InputError
from mcsim.scenario.block import Block
from mcsim.scenario.fields import (
    Acceleration,
    AccelerationNoiseDensity,
    AccelerationRandomWalk,
    Angle,
    AngleRandomWalk,
    AngularRate,
    Frequency,
    GSensitivity,
    NotNegative,
    Positive,
    RateNoiseDensity,
    RateRandomWalk,
    Ratio,
    Time,
    VelocityRandomWalk,
    reject,
)

#: Axes of a sensor.
N_AXES = 3


def _per_axis(value: Any) -> Any:
    return value if isinstance(value, list | tuple) else (value,)


def _one_or_three(values: tuple[float, ...]) -> tuple[float, ...]:
    if len(values) not in (1, N_AXES):
        raise reject(f"write one value, or three for [x, y, z]; these are {len(values)}")
    return values


class OneOrThree:
    """Marks a field that is one quantity or three; says so in the JSON schema."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        three = handler(schema)
        return {"anyOf": [three["items"], {**three, "minItems": 1, "maxItems": N_AXES}]}


# Written as one quantity, or as one per axis.
_PER_AXIS = (BeforeValidator(_per_axis), AfterValidator(_one_or_three), OneOrThree())


Accelerations = Annotated[tuple[Annotated[Acceleration, NotNegative], ...], *_PER_AXIS]
AccelerationRange = Annotated[tuple[Annotated[Acceleration, Positive], ...], *_PER_AXIS]
AngularRates = Annotated[tuple[Annotated[AngularRate, NotNegative], ...], *_PER_AXIS]
AngularRateRange = Annotated[tuple[Annotated[AngularRate, Positive], ...], *_PER_AXIS]
Times = Annotated[tuple[Annotated[Time, Positive], ...], *_PER_AXIS]
Ratios = Annotated[tuple[Annotated[Ratio, NotNegative], ...], *_PER_AXIS]
Angles = Annotated[tuple[Annotated[Angle, NotNegative], ...], *_PER_AXIS]
Frequencies = Annotated[tuple[Annotated[Frequency, Positive], ...], *_PER_AXIS]
AccelerationNoiseDensities = Annotated[
    tuple[Annotated[AccelerationNoiseDensity, NotNegative], ...], *_PER_AXIS
]
VelocityRandomWalks = Annotated[tuple[Annotated[VelocityRandomWalk, NotNegative], ...], *_PER_AXIS]
AccelerationRandomWalks = Annotated[
    tuple[Annotated[AccelerationRandomWalk, NotNegative], ...], *_PER_AXIS
]
RateNoiseDensities = Annotated[tuple[Annotated[RateNoiseDensity, NotNegative], ...], *_PER_AXIS]
AngleRandomWalks = Annotated[tuple[Annotated[AngleRandomWalk, NotNegative], ...], *_PER_AXIS]
RateRandomWalks = Annotated[tuple[Annotated[RateRandomWalk, NotNegative], ...], *_PER_AXIS]
GSensitivities = Annotated[tuple[Annotated[GSensitivity, NotNegative], ...], *_PER_AXIS]


class AccelerationProcess(Block):
    """A first-order Gauss-Markov process, in its stationary state."""

    deviation: Accelerations
    """Standard deviation of the process."""
    correlation_time: Times
    """Time after which the autocorrelation has fallen to 1/e."""


class RateProcess(Block):
    """A first-order Gauss-Markov process, in its stationary state."""

    deviation: AngularRates
    """Standard deviation of the process."""
    correlation_time: Times
    """Time after which the autocorrelation has fallen to 1/e."""


class AccelerationSpikes(Block):
    """Outliers of either sign."""

    rate: Annotated[Frequency, NotNegative]
    """Mean number per second and axis (Poisson)."""
    amplitude: Annotated[Acceleration, NotNegative]
    """What a spike adds or takes away."""


class RateSpikes(Block):
    """Outliers of either sign."""

    rate: Annotated[Frequency, NotNegative]
    """Mean number per second and axis (Poisson)."""
    amplitude: Annotated[AngularRate, NotNegative]
    """What a spike adds or takes away."""


class _Element(Block):
    """What both elements have."""

    model: str | None = None
    """Name of a built-in sensor (`mcsim sensors`), or a sensor file such as `mcsim
    characterise` writes; its values hold unless written here."""
    scale_factor_error: Ratios | None = None
    """Standard deviation of the scale factor error."""
    misalignment: Angles | None = None
    """Standard deviation of the angles between the axes. Gravity shows by them in the level axes,
    in the planar case as well."""
    bandwidth: Frequencies | None = None
    """First-order low-pass, -3 dB."""


class AccelerometerErrors(_Element):
    """Errors of an accelerometer; absent ones do not exist."""

    noise_density: AccelerationNoiseDensities | None = None
    """White noise, one-sided density as data sheets print it."""
    velocity_random_walk: VelocityRandomWalks | None = None
    """White noise as Allan's N (two-sided), instead of `noise_density`."""
    miscalibration: Accelerations | None = None
    """Standard deviation of the constant offset."""
    turn_on_bias: Accelerations | None = None
    """Standard deviation of the bias drawn at each turn-on."""
    bias_instability: Accelerations | None = None
    """Flicker noise, Allan's B; the floor of the Allan deviation is 0.664 B. Its correlation times
    reach to ten times the run (with `calibration` or `levelling`, run and rests together; in the
    velocity case, the rest and all runs)."""
    acceleration_random_walk: AccelerationRandomWalks | None = None
    """Allan's K."""
    gauss_markov: AccelerationProcess | None = None
    resolution: Accelerations | None = None
    """Quantisation step."""
    range: AccelerationRange | None = None
    """Saturation, plus and minus."""
    spikes: AccelerationSpikes | None = None
    _built_in: catalogue.Sensor | None = PrivateAttr(None)

    @property
    def built_in(self) -> catalogue.Sensor | None:
        """The built-in sensor that the block is made from: it has traits beside its errors."""
        return self._built_in

    def made_from(self, sensor: catalogue.Sensor | None) -> None:
        """Say which built-in sensor it is; a sensor's name and its file are read outside."""
        self._built_in = sensor

    @model_validator(mode="after")
    def _noise_given_once(self) -> AccelerometerErrors:
        if self.noise_density is not None and self.velocity_random_walk is not None:
            raise reject(
                "`noise_density` and `velocity_random_walk` say the same thing twice; keep one"
            )
        return self


class GyroscopeErrors(_Element):
    """Errors of a gyroscope; absent ones do not exist."""

    noise_density: RateNoiseDensities | None = None
    """White noise, one-sided density as data sheets print it."""
    angle_random_walk: AngleRandomWalks | None = None
    """White noise as Allan's N (two-sided), instead of `noise_density`."""
    miscalibration: AngularRates | None = None
    """Standard deviation of the constant offset."""
    turn_on_bias: AngularRates | None = None
    """Standard deviation of the bias drawn at each turn-on."""
    g_sensitivity: GSensitivities | None = None
    """Standard deviation of the bias that an acceleration brings."""
    bias_instability: AngularRates | None = None
    """Flicker noise, Allan's B; the floor of the Allan deviation is 0.664 B. Its correlation times
    reach to ten times the run (with `calibration` or `levelling`, run and rests together)."""
    rate_random_walk: RateRandomWalks | None = None
    """Allan's K."""
    gauss_markov: RateProcess | None = None
    resolution: AngularRates | None = None
    """Quantisation step."""
    range: AngularRateRange | None = None
    """Saturation, plus and minus."""
    spikes: RateSpikes | None = None

    @model_validator(mode="after")
    def _noise_given_once(self) -> GyroscopeErrors:
        if self.noise_density is not None and self.angle_random_walk is not None:
            raise reject(
                "`noise_density` and `angle_random_walk` say the same thing twice; keep one"
            )
        return self


NOISE_KEYS = {"noise_density", "velocity_random_walk", "angle_random_walk"}


#: Reads an element of a sensor file: its quantities, as text.
FileReader = Callable[[Path, str], Mapping[str, Any]]


def is_file(model: str) -> bool:
    """Whether a sensor's name is that of a file."""
    return Path(model).suffix.lower() in (".yaml", ".yml")


def filled(block: Mapping[str, Any], element: str, folder: Path, reader: FileReader) -> Any:
    """The block, its gaps filled by the sensor that its ``model`` names.

    White noise is written in one way or the other, never in both.

    Raises
    ------
    InputError
        No such sensor, or a sensor file that cannot be read.
    """
    model = block.get("model")
    if not isinstance(model, str):
        return block
    in_file = is_file(model)
    known = reader(folder / model, element) if in_file else catalogue.element(model, element)
    if block.keys() & NOISE_KEYS:
        known = {key: known[key] for key in known if key not in NOISE_KEYS}
    return {**known, **block}


def named(element: str, reader: FileReader) -> BeforeValidator:
    """Accept a sensor's name for its block, or fill a block's gaps by its ``model``.

    A name that ends in ``.yaml`` is that of a sensor file, relative to the document's folder.
    """

    def expand(value: Any, info: ValidationInfo) -> Any:
        block = {"model": value} if isinstance(value, str) else value
        if not isinstance(block, dict):
            return block
        folder = (info.context or {}).get("folder", Path())
        try:
            return filled(block, element, folder, reader)
        except InputError as error:
            raise reject(str(error)) from None

    return BeforeValidator(expand)
