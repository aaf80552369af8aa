"""The block that describes one sensing element's errors, as files and the catalogue write it.

One set of keys serves sensor files, vibration scenarios and the catalogue: those of the terms in
``mcsim.sensor_terms``, also of terms that are added later.  A value is one quantity for all axes,
or a list [x, y, z].
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    PrivateAttr,
    ValidationInfo,
    create_model,
    model_validator,
)
from pydantic_core import CoreSchema

from mcsim import catalogue
from mcsim.errors import InputError
from mcsim.scenario.block import Block, add_keys, rebuild
from mcsim.scenario.fields import NotNegative, Positive, Quantity, reject
from mcsim.sensor_terms import TERMS
from mcsim.sensor_terms.channel import ACCELEROMETER, GYROSCOPE, SIGNALS
from mcsim.sensor_terms.mechanisms.high_pass import HighPass
from mcsim.sensor_terms.mechanisms.mechanism import Acts, of_kind
from mcsim.sensor_terms.mechanisms.offset import Offset
from mcsim.sensor_terms.mechanisms.white import NOISE
from mcsim.sensor_terms.term import InnerBlock, SensorKey, SensorTerm

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


def _quantity(key: SensorKey, element: str) -> Any:
    """The type of a key's value."""
    bound = Positive if key.positive else NotNegative
    one = Annotated[float, Quantity(key.kind_for(element)), bound]
    return Annotated[tuple[one, ...], *_PER_AXIS] if key.per_axis else one


class _Described(Block):
    """A block whose keys bring their texts: nobody has to read its source for them."""

    model_config = ConfigDict(use_attribute_docstrings=False)


def _inner_block(inner: InnerBlock, keys: Sequence[SensorKey], element: str) -> type[Block]:
    """The block within an element's block that holds the keys of one term."""
    title = f"{'Acceleration' if element == ACCELEROMETER else 'Rate'}{inner.title}"
    fields = {
        key.name: (_quantity(key, element), Field(description=key.text or None)) for key in keys
    }
    return create_model(title, __base__=_Described, __doc__=inner.text, **fields)  # type: ignore[call-overload]


def _keys_of(term: SensorTerm, element: str) -> dict[str, tuple[Any, Any]]:
    """What a term adds to an element's block: types and fields of its keys."""
    keys = term.keys(element)
    if term.inner and keys:
        block = _inner_block(term.inner, keys, element)
        return {term.inner.key: (block | None, Field(default=None))}
    return {
        key.name: (
            _quantity(key, element) | None,
            Field(default=None, description=key.text or None),
        )
        for key in keys
    }


class _Element(_Described):
    """What both elements have."""

    ELEMENT: ClassVar[str]
    model: str | None = Field(
        default=None,
        description="Name of a built-in sensor (`mcsim sensors`), or a sensor file such as `mcsim "
        "characterise` writes; its values hold unless written here.",
    )

    @property
    def has_noise(self) -> bool:
        """Whether white noise is given, in one way or the other; zero is given."""
        return bool(self.values_of(TERMS[NOISE]))

    def values_of(self, term: SensorTerm) -> dict[str, Any]:
        """The values that are written of a term, by the roles of its keys: SI, or tuples of it."""
        block = self if term.inner is None else getattr(self, term.inner.key, None)
        if block is None:
            return {}
        written = {key: getattr(block, key.name) for key in term.keys(self.ELEMENT)}
        return {key.role or key.name: v for key, v in written.items() if v is not None}

    def acts_on(self, axis: int) -> Acts:
        """What acts on one axis, by the names of the terms; what is not written is absent."""
        written = {name: self.values_of(term) for name, term in TERMS.items()}
        return {
            name: TERMS[name].acts(**{role: _of_axis(v, axis) for role, v in values.items()})
            for name, values in written.items()
            if values
        }

    @property
    def ac_coupled(self) -> bool:
        """Whether nothing constant is left on one of the axes."""
        acts = [self.acts_on(axis) for axis in range(N_AXES)]
        return any(act.acts for own in acts for act in of_kind(own, HighPass).values())

    def assumed_left(self) -> Iterator[str]:
        """Terms that stand for what a calibration leaves, where they are not zero."""
        for axis in range(N_AXES):
            for name, act in of_kind(self.acts_on(axis), Offset).items():
                if act.assumed and act.deviation > 0.0:
                    yield name

    @model_validator(mode="after")
    def _given_once(self) -> Self:
        for term in filter(lambda term: term.alternatives, TERMS.values()):
            names = [key.name for key in term.keys(self.ELEMENT)]
            given = [name for name in names if getattr(self, name) is not None]
            if len(given) > 1:
                raise reject(f"`{given[0]}` and `{given[1]}` say the same thing twice; keep one")
        return self


class AccelerometerErrors(_Element):
    """Errors of an accelerometer; absent ones do not exist."""

    ELEMENT = ACCELEROMETER
    _built_in: catalogue.Sensor | None = PrivateAttr(None)

    @property
    def built_in(self) -> catalogue.Sensor | None:
        """The built-in sensor that the block is made from: it has traits beside its errors."""
        return self._built_in

    def made_from(self, sensor: catalogue.Sensor | None) -> None:
        """Say which built-in sensor it is; a sensor's name and its file are read outside."""
        self._built_in = sensor


class GyroscopeErrors(_Element):
    """Errors of a gyroscope; absent ones do not exist."""

    ELEMENT = GYROSCOPE


def _of_axis(value: Any, axis: int) -> float:
    """A value for all axes, or that of one of them."""
    values = value if isinstance(value, tuple) else (value,)
    return float(values[axis] if len(values) > 1 else values[0])


def _hold(term: SensorTerm) -> None:
    """Let the elements' blocks hold the keys of a term."""
    for block in (AccelerometerErrors, GyroscopeErrors):
        add_keys(block, _keys_of(term, block.ELEMENT))


def _hear(term: SensorTerm) -> None:
    """A term is added when blocks may be in use."""
    _hold(term)
    rebuild()


for _term in TERMS.values():
    _hold(_term)
TERMS.tell(_hear)

#: Ways to write white noise.
NOISE_KEYS = {key.name for element in SIGNALS for key in TERMS[NOISE].keys(element)}


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
