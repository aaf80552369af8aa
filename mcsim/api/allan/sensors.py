"""The terms of Allan analysis that a built-in sensor or a sensor file has, axis by axis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mcsim.api.convert import convert
from mcsim.characterisation.expected_errors import Truth
from mcsim.characterisation.noise_terms import NoiseTerm, flicker, gauss_markov, random_walk, white
from mcsim.characterisation.process import GaussMarkov
from mcsim.dialects.description import (
    AXES,
    BIAS_WALK,
    CORRELATION_TIME,
    DEVIATION,
    Quantities,
    three,
    two_sided,
)
from mcsim.errors import InputError

#: Name of an axis that stands for all three.
ALL_AXES = "x, y, z"


@dataclass(frozen=True)
class SensorAxis:
    """One axis of a sensor, or all where they are alike; SI units.

    ``white`` (N), ``instability`` (B) and ``walk`` (K) are 0 where the sensor has none;
    ``bandwidth`` (Hz) and ``resolution`` are 0 where they are not known.
    """

    element: str
    axis: str
    white: float
    instability: float
    walk: float
    process: GaussMarkov | None
    bandwidth: float
    resolution: float

    @property
    def terms(self) -> tuple[NoiseTerm, ...]:
        """What it has, in the order N, B, K, Gauss-Markov."""
        found = [
            make(value)
            for make, value in (
                (white, self.white),
                (flicker, self.instability),
                (random_walk, self.walk),
            )
            if value
        ]
        return (*found, *([gauss_markov(self.process)] if self.process is not None else []))

    @property
    def truth(self) -> Truth:
        """The same for predictions."""
        squares = np.array([0.0, self.white**2, self.instability**2, self.walk**2, 0.0])
        return Truth(squares, self.process)


@dataclass(frozen=True)
class SensorAxes:
    """A sensor: its name, the file that it comes from if any, and its axes."""

    name: str
    axes: tuple[SensorAxis, ...]
    file: Path | None = None


def sensor_axes(
    sensor: str | Path, element: str | None = None, axis: str | None = None
) -> SensorAxes:
    """The noise of a built-in sensor, or of a sensor file in any dialect.

    Parameters
    ----------
    sensor : path or str
        A file in any dialect that says all, or the name of a built-in sensor.
    element : str, optional
        ``accelerometer`` or ``gyroscope``; what the sensor has if absent.
    axis : str, optional
        ``x``, ``y`` or ``z``; all if absent.

    Raises
    ------
    InputError
        No such sensor, element or axis, or one without noise terms.
    """
    if axis is not None and axis not in AXES:
        raise InputError(f'--axis "{axis}" is none of {", ".join(AXES)}')
    found = convert(sensor, "mcsim").sensor
    name = found.name or Path(sensor).stem
    if element is not None and element not in found.elements:
        raise InputError(f"{name} has no {element} (it has: {', '.join(found.elements)})")
    wanted = found.elements if element is None else {element: found.elements[element]}
    axes = [one for kind, own in wanted.items() for one in _axes(kind, own, axis) if one.terms]
    if not axes:
        raise InputError(
            f"{name} has no noise of Allan analysis: a noise density, bias instability, random "
            "walk or Gauss-Markov bias is needed"
        )
    return SensorAxes(name, tuple(axes), Path(sensor) if Path(sensor).is_file() else None)


def _axes(element: str, own: Quantities, axis: str | None) -> list[SensorAxis]:
    every = [_axis(element, own, k) for k in range(len(AXES))]
    if axis is not None:
        return [every[AXES.index(axis)]]
    alike = len({(a.white, a.instability, a.walk, a.process, a.resolution) for a in every}) == 1
    if alike:
        first = every[0]
        return [SensorAxis(**{**first.__dict__, "axis": ALL_AXES})]
    return every


def _axis(element: str, own: Quantities, k: int) -> SensorAxis:
    def value(key: str) -> float:
        given = own.get(key)
        return three(given)[k] if given is not None else 0.0

    deviation, time = value(DEVIATION), value(CORRELATION_TIME)
    noise = two_sided(own, element)
    bandwidth = value("bandwidth")
    return SensorAxis(
        element=element,
        axis=AXES[k],
        white=three(noise)[k] if noise is not None else 0.0,
        instability=value("bias_instability"),
        walk=value(BIAS_WALK[element]),
        process=GaussMarkov(time, deviation) if deviation and time else None,
        bandwidth=bandwidth if math.isfinite(bandwidth) else 0.0,
        resolution=value("resolution"),
    )
