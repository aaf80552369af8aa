"""mcsim's own sensor files, in SI units or in those of data sheets and Allan analysis."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace

from mcsim.dialects.description import (
    ELEMENTS,
    RANDOM_WALK,
    Assumptions,
    Description,
    Reading,
    Values,
    describe_file,
    two_sided,
)
from mcsim.dialects.dialect import Dialect
from mcsim.dialects.numbers import number
from mcsim.dialects.terms import kind_of
from mcsim.scenario.document import SENSOR, parse_document
from mcsim.units import KINDS, factor, parse

CONVENTION = (
    "noise_density is one-sided, as data sheets print it: variance ND² fs / 2 per sample; "
    "velocity_random_walk and angle_random_walk are Allan's N, two-sided: N² fs; ND = √2 N"
)

#: Kinds whose SI unit has no sign of its own.
_SI = {"ratio": "ppm", "ratio per kelvin": "ppm/K"}
_DATA_SHEET = {
    "acceleration noise density": "µg/√Hz",
    "angular rate noise density": "°/s/√Hz",
    "acceleration": "mg",
    "angular rate": "°/s",
    "angle": "°",
    "acceleration random walk": "µg/√s",
    "rate random walk": "°/s/√s",
}
_ALLAN = {
    "velocity random walk": "m/s/√h",
    "angle random walk": "°/√h",
    "acceleration random walk": "m/s/h^1.5",
    "rate random walk": "°/h^1.5",
}
_ALLAN_BIAS = {"accelerometer": "m/s/h", "gyroscope": "°/h"}


def recognises(text: str) -> bool:
    """An element's block at the margin."""
    return bool(re.search(r"(?m)^['\"{]*(accelerometer|gyroscope)['\"]?\s*:", text))


def read(text: str, source: str, assumptions: Assumptions) -> Reading:
    """A sensor file; its rate is its own or that of its elements.

    Raises
    ------
    InputError
        Not a valid sensor file; one line per problem.
    """
    from mcsim.scenario.sensor_file import SensorFile, parse_sensor_file
    from mcsim.scenario.validation import validate

    sensor = describe_file(validate(parse_sensor_file(text, source), SensorFile))
    if sensor.rate is not None:
        return Reading(sensor)
    rates = _rates(text, source)
    if len(set(rates.values())) > 1 and assumptions.rate is None:
        shown = ", ".join(f"{element} {rate:g} Hz" for element, rate in rates.items())
        return Reading(sensor, (f"rates differ ({shown}): where one is needed, --rate says which",))
    if assumptions.rate in rates.values():
        return Reading(sensor)
    return Reading(replace(sensor, rate=next(iter(rates.values()), None)))


def _rates(text: str, source: str) -> dict[str, float]:
    """What the elements' own blocks say, in Hz, of a file that is valid."""
    tree = parse_document(text, source, SENSOR).tree
    blocks = {element: tree.get(element) for element in ELEMENTS}
    return {
        element: parse(str(block["rate"]), KINDS["frequency"])
        for element, block in blocks.items()
        if isinstance(block, dict) and block.get("rate") is not None
    }


def write_si(sensor: Description, assumptions: Assumptions) -> str:
    """A sensor file in SI units, every quantity in the convention it came in."""
    return _write(sensor, assumptions, {})


def write_data_sheet(sensor: Description, assumptions: Assumptions) -> str:
    """A sensor file with one-sided noise densities, in the units of data sheets."""

    def one_sided(element: str, quantities: Mapping[str, Values]) -> dict[str, Values]:
        changed = {key: v for key, v in quantities.items() if key != RANDOM_WALK[element]}
        walk = quantities.get(RANDOM_WALK[element])
        if walk is not None:
            changed = {"noise_density": tuple(math.sqrt(2.0) * v for v in walk), **changed}
        return changed

    elements = {e: one_sided(e, q) for e, q in sensor.elements.items()}
    return _write(Description(sensor.name, sensor.rate, elements), assumptions, _DATA_SHEET)


def write_allan(sensor: Description, assumptions: Assumptions) -> str:
    """A sensor file with Allan's N, B and K, in m, s and h, or degrees."""

    def as_walk(element: str, quantities: Mapping[str, Values]) -> dict[str, Values]:
        changed = {key: v for key, v in quantities.items() if key != "noise_density"}
        walk = two_sided(quantities, element)
        return {RANDOM_WALK[element]: walk, **changed} if walk is not None else changed

    elements = {e: as_walk(e, q) for e, q in sensor.elements.items()}
    return _write(Description(sensor.name, sensor.rate, elements), assumptions, _ALLAN)


def _write(sensor: Description, assumptions: Assumptions, units: Mapping[str, str]) -> str:
    rate = sensor.rate if sensor.rate is not None else assumptions.rate
    lines = [f"name: {_quoted(sensor.name)}"] if sensor.name else []
    lines += [f"rate: {number(rate)} Hz"] if rate is not None else []
    for element, quantities in sensor.elements.items():
        lines.append(f"{element}:")
        for outer in dict.fromkeys(key.rpartition(".")[0] for key in quantities):
            indent = "    " if outer else "  "
            lines += [f"  {outer}:"] if outer else []
            lines += [
                f"{indent}{key.rpartition('.')[2]}: {_quantity(key, element, values, units)}"
                for key, values in quantities.items()
                if key.rpartition(".")[0] == outer
            ]
    return "\n".join(lines) + "\n"


def _quantity(key: str, element: str, values: Values, units: Mapping[str, str]) -> str:
    kind = KINDS[kind_of(key, element)]
    unit = units.get(kind.name, _SI.get(kind.name, kind.si_unit))
    if units is _ALLAN and key == "bias_instability":
        unit = _ALLAN_BIAS[element]
    if units is _DATA_SHEET and key == "range" and element == "accelerometer":
        unit = "g"
    texts = [f"{number(value / factor(unit, kind))} {unit}" for value in values]
    return texts[0] if len(texts) == 1 else f"[{', '.join(texts)}]"


def _quoted(name: str) -> str:
    return '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'


DIALECT = Dialect("mcsim", "mcsim sensor file", CONVENTION, recognises, read, write_si)
DATA_SHEET = Dialect(
    "datasheet",
    "mcsim sensor file in a data sheet's units",
    CONVENTION,
    None,
    None,
    write_data_sheet,
)
ALLAN = Dialect(
    "allan", "mcsim sensor file with Allan's N, B and K", CONVENTION, None, None, write_allan
)
