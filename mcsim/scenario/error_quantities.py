"""What reconstructions err in: names, units and words of errors, for all cases."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import AfterValidator

from mcsim.errors import InputError
from mcsim.registry import Registry
from mcsim.scenario.fields import reject

#: Units of tables and figures, with their signs: angles are shown in degrees.
SIGNS = {"m": "m", "m/s": "m/s", "m/s^2": "m/s²", "deg": "°"}


@dataclass(frozen=True)
class ErrorQuantity:
    """An error that some case reports.

    Attributes
    ----------
    name : str
        In tables, and in the figure block of scenarios.
    unit : str
        In tables: ``m``, ``m/s``, ``m/s^2`` or ``deg``; radian inside.
    words : str
        In figures: ``along-road error``.

    Raises
    ------
    InputError
        Another unit.
    """

    name: str
    unit: str
    words: str

    def __post_init__(self) -> None:
        if self.unit not in SIGNS:
            raise InputError(f"{self.name}: the unit of an error is one of {', '.join(SIGNS)}")


#: Several cases have an error in common; a case brings those that only it has.
ERROR_QUANTITIES: Registry[ErrorQuantity] = Registry(
    "error",
    (
        ErrorQuantity("along", "m", "along-road error"),
        ErrorQuantity("across", "m", "across-road error"),
        ErrorQuantity("height", "m", "height error"),
        ErrorQuantity("position", "m", "position error"),
        ErrorQuantity("roll", "deg", "roll error"),
        ErrorQuantity("pitch", "deg", "pitch error"),
        ErrorQuantity("heading", "deg", "heading error"),
        ErrorQuantity("course", "deg", "course error"),
        ErrorQuantity("velocity", "m/s", "velocity error"),
        ErrorQuantity("mean_velocity", "m/s", "error of the mean velocity"),
        ErrorQuantity("repeatability", "m/s", "scatter of the runs"),
    ),
)


class _Units(Mapping[str, str]):
    """Unit of each error in tables and figures."""

    def __getitem__(self, name: str) -> str:
        return ERROR_QUANTITIES[name].unit

    def __iter__(self) -> Iterator[str]:
        return iter(ERROR_QUANTITIES)

    def __len__(self) -> int:
        return len(ERROR_QUANTITIES)


UNITS = _Units()


def _known(name: str) -> str:
    if name not in ERROR_QUANTITIES:
        raise reject(ERROR_QUANTITIES.unknown(name))
    return name


def known_name() -> AfterValidator:
    """Refuses names that no error has."""
    return AfterValidator(_known)


class OneOrMoreNames:
    """Describes a field of one error name, or of several, in the JSON schema."""

    def __get_pydantic_json_schema__(self, *_: Any) -> dict[str, Any]:
        names = list(ERROR_QUANTITIES)
        several = {"type": "array", "items": {"enum": names}, "minItems": 1}
        return {"oneOf": [{"enum": names}, several]}


@dataclass(frozen=True)
class ErrorRow:
    """One error of a case, at the end or at an instant (s after the first sample)."""

    name: str
    time: float | None = None

    @property
    def label(self) -> str:
        """A name that tells the rows of a case apart."""
        return self.name if self.time is None else f"{self.name} at {self.time:.6g} s"

    @property
    def unit(self) -> str:
        return UNITS[self.name]
