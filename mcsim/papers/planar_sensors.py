"""``mcsim table planar-sensors``: Table 1 of the planar paper beside the catalogue.

The stored text has lost the exponents of all noise densities.  What is left of a printed one are
its two digits; the catalogue's must have the same, and the table says which power of ten it takes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mcsim import catalogue
from mcsim.papers import Computed, PaperTable
from mcsim.text_table import columns
from mcsim.units import KINDS, STANDARD_GRAVITY, in_unit, parse

if TYPE_CHECKING:
    import pandas as pd

_SOURCE = "planar-table-1"
#: Rate of the paper's base parameters (Hz).
_BASE_RATE = 100.0


@dataclass(frozen=True)
class Printed:
    """One element of a type as printed.

    ``smallest`` and ``largest`` are the ends of its range (m/s² or °/s), ``digits`` those of its
    noise density without their power of ten (None: "not specified"), ``rate`` is in Hz.
    """

    smallest: float
    largest: float
    digits: float | None
    rate: float


_ACCELEROMETER, _GYROSCOPE = catalogue.ELEMENTS
#: Table 1 of the paper; an element that is not there is printed as "n/a".
PRINTED: dict[str, dict[str, Printed]] = {
    "LIS3DH": {_ACCELEROMETER: Printed(20.0, 160.0, 2.2, 5000.0)},
    "LIS33DE": {_ACCELEROMETER: Printed(20.0, 80.0, None, 400.0)},
    "LSM330DL": {
        _ACCELEROMETER: Printed(20.0, 160.0, 2.2, 5000.0),
        _GYROSCOPE: Printed(250.0, 2000.0, 3.0, 1344.0),
    },
    "L3G4200D": {_GYROSCOPE: Printed(250.0, 2000.0, 3.0, 800.0)},
    "CMR3000-D01": {_GYROSCOPE: Printed(2000.0, 2000.0, 2.0, 160.0)},
}
#: Units of the paper, and the kinds of quantity, of ranges and noise densities.
_UNITS = {_ACCELEROMETER: ("m/s²", "acceleration"), _GYROSCOPE: ("°/s", "angular rate")}
_CONCLUSION = """\
Noise densities are printed with a power of ten that the stored text has lost; the power in brackets
is the catalogue's, of the order of the makers' data sheets (2.2e-3 m/s²/√Hz are {in_g:.0f} µg/√Hz).
{verdict}
A scenario that names a sensor takes the largest range and no rate: `sensors.rate` is its own.
At {rate:g} Hz: deviation of a sample, ND √(rate/2); N: random walk, ND/√2, in m/s/√h and °/√h."""


@dataclass(frozen=True)
class Entry:
    """One element: what is printed, and what the catalogue holds; both in the paper's units."""

    sensor: str
    element: str
    printed: Printed
    smallest: float
    largest: float
    density: float | None
    rate: float
    taken_range: float

    @property
    def unit(self) -> str:
        return _UNITS[self.element][0]

    @property
    def power(self) -> int | None:
        """Of ten, that the catalogue restores."""
        return None if self.density is None else math.floor(math.log10(self.density) + 1e-9)

    @property
    def sample(self) -> float | None:
        """Standard deviation of the noise of one sample at the paper's base rate."""
        return None if self.density is None else self.density * math.sqrt(0.5 * _BASE_RATE)

    @property
    def walk(self) -> float | None:
        """Allan's N, per root of an hour."""
        return None if self.density is None else self.density / math.sqrt(2.0) * 60.0

    @property
    def agrees(self) -> bool:
        """Whether the catalogue holds the printed digits."""
        digits = None
        if self.density is not None and self.power is not None:
            digits = round(self.density / 10.0**self.power, 9)
        held = Printed(self.smallest, self.largest, digits, self.rate)
        return held == self.printed


def entries() -> Iterator[Entry]:
    """The elements of Table 1, in its order."""
    for sensor, elements in PRINTED.items():
        for element, printed in elements.items():
            yield _entry(sensor, element, printed)


def _entry(sensor: str, element: str, printed: Printed) -> Entry:
    held = catalogue.find(sensor)
    (record,) = (r.quantities for r in held.records[element] if r.source == _SOURCE)
    unit, kind = _UNITS[element]
    smallest, largest = (_number(text, kind, unit) for text in record["ranges"])
    density = None
    if "noise_density" in record:
        density = _number(record["noise_density"], f"{kind} noise density", f"{unit}/√Hz")
    return Entry(
        sensor=sensor,
        element=element,
        printed=printed,
        smallest=smallest,
        largest=largest,
        density=density,
        rate=parse(record["rate"], KINDS["frequency"]),
        taken_range=_number(held.elements[element]["range"], kind, unit),
    )


def _number(text: str, kind: str, unit: str) -> float:
    """A quantity in the paper's unit, free of what conversion rounds."""
    return float(f"{in_unit(parse(text, KINDS[kind]), unit, KINDS[kind]):.12g}")


def sensor_table() -> Computed:
    """The table, printed beside the catalogue."""
    found = list(entries())
    return Computed({"planar-sensors": frame(found)}, _text(found))


def _text(found: Sequence[Entry]) -> str:
    head = ["type", "", "range printed", "catalogue", "noise density printed", "catalogue"]
    rows = [[*head, "rate printed", "catalogue", f"at {_BASE_RATE:g} Hz", "N"]]
    rows += [_cells(entry) for entry in found]
    density = 2.2e-3 / STANDARD_GRAVITY * 1e6
    conclusion = _CONCLUSION.format(in_g=density, rate=_BASE_RATE, verdict=verdict(found))
    return "\n".join([*columns(rows), conclusion])


def _cells(entry: Entry) -> list[str]:
    unit, printed = entry.unit, entry.printed
    noise, held = ["not specified", "–"], ["–", "–"]
    if printed.digits is not None:
        noise = [f"{printed.digits:.1f}·10^[{entry.power}] {unit}/√Hz", f"{entry.density:.3g}"]
        held = [f"{entry.sample:.3g} {unit}", f"{entry.walk:.3g}"]
    return [
        entry.sensor,
        entry.element,
        f"{_range(printed.smallest, printed.largest)} {unit}",
        _range(entry.smallest, entry.largest),
        *noise,
        f"{printed.rate:g} Hz",
        f"{entry.rate:g}",
        *held,
    ]


def _range(smallest: float, largest: float) -> str:
    return f"{smallest:g}" if smallest == largest else f"{smallest:g}-{largest:g}"


def verdict(found: Sequence[Entry]) -> str:
    """Whether the catalogue holds what is printed."""
    off = [f"{e.sensor} ({e.element})" for e in found if not e.agrees]
    if off:
        return f"The catalogue differs from the print in {', '.join(off)}."
    return f"All {len(found)} elements of the catalogue agree with the print in every digit."


def frame(found: Sequence[Entry]) -> pd.DataFrame:
    """One row per element; numbers in ``unit``, and its noise densities per √Hz."""
    import pandas as pd

    def column(of: Any) -> list[Any]:
        return [of(entry) for entry in found]

    return pd.DataFrame(
        {
            "type": column(lambda e: e.sensor),
            "element": column(lambda e: e.element),
            "unit": column(lambda e: e.unit),
            "smallest range, printed": column(lambda e: e.printed.smallest),
            "smallest range": column(lambda e: e.smallest),
            "largest range, printed": column(lambda e: e.printed.largest),
            "largest range": column(lambda e: e.largest),
            "noise density, digits printed": column(lambda e: _or_nan(e.printed.digits)),
            "noise density": column(lambda e: _or_nan(e.density)),
            "power of ten restored": column(lambda e: _or_nan(e.power)),
            "rate, printed [Hz]": column(lambda e: e.printed.rate),
            "rate [Hz]": column(lambda e: e.rate),
            "range of a scenario": column(lambda e: e.taken_range),
            f"sample's noise at {_BASE_RATE:g} Hz": column(lambda e: _or_nan(e.sample)),
            "N per √h": column(lambda e: _or_nan(e.walk)),
        }
    )


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else float(value)


TABLE = PaperTable(
    "planar-sensors",
    "Sensors of the planar paper (Table 1), printed and as the catalogue holds them.",
    sensor_table,
    files=("planar-sensors",),
)
