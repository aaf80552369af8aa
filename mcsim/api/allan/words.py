"""Coefficients and times as people write them."""

from __future__ import annotations

import math

from mcsim.api.allan.sensors import SensorAxis
from mcsim.characterisation.expected_errors import TIME
from mcsim.characterisation.noise_terms import FLOOR
from mcsim.characterisation.sensor_file import KEYS
from mcsim.units import KINDS, in_unit

_YEAR, _DAY, _HOUR, _MINUTE = 365.25 * 86400.0, 86400.0, 3600.0, 60.0


def crossing_of(axis: SensorAxis) -> float:
    """The cluster time (s) up to which an axis' white noise is more than B and K together."""
    n2, b2, k2 = axis.white**2, (FLOOR * axis.instability) ** 2, axis.walk**2 / 3.0
    return math.inf if not (b2 or k2) else _root(n2, b2, k2)


def _root(n2: float, b2: float, k2: float) -> float:
    """Where n²/τ = b² + k² τ."""
    if not k2:
        return n2 / b2
    return 2.0 * n2 / (b2 + math.sqrt(b2**2 + 4.0 * n2 * k2))


def coefficient_words(axis: SensorAxis, name: str) -> str:
    """A coefficient with its unit."""
    if name == TIME:
        assert axis.process is not None
        return f"{axis.process.correlation_time:.4g} s"
    values = {"N": axis.white, "B": axis.instability, "K": axis.walk}
    _, kind, unit = KEYS[axis.element][name]
    return f"{in_unit(values[name], unit, KINDS[kind]):.4g} {unit}"


def duration_words(seconds: float) -> str:
    """A length of time to three digits, in the unit that suits it."""
    if math.isinf(seconds):
        return "never"
    for unit, size in (("years", _YEAR), ("days", _DAY), ("h", _HOUR), ("min", _MINUTE)):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"


def error_words(error: float) -> str:
    """A relative error in per cent; beyond 100 % it is none."""
    return f"{100 * error:.2g} %" if error <= 1.0 else "above 100 %"
