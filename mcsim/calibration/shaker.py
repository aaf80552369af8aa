"""The harmonic shaker test: linearity of the scale factor.

The amplitude grows in proportion to the frequency; the measured amplitude over the
reference gives a straight line, and the largest residual the non-linearity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.calibration.columns import read_columns
from mcsim.errors import InputError

Array = NDArray[np.float64]

_FEWEST_POINTS = 4


@dataclass(frozen=True)
class LinearityFit:
    """Straight line through measured over reference amplitudes (fractions of g).

    ``nonlinearity`` is the largest residual as a share of ``full_scale``.
    """

    reference: Array
    measured: Array
    slope: float
    offset: float
    full_scale: float

    @property
    def residuals(self) -> Array:
        return self.measured - self.slope * self.reference - self.offset

    @property
    def nonlinearity(self) -> float:
        return float(np.abs(self.residuals).max() / self.full_scale)

    def scale_uncertainty(self, calibration: float) -> float:
        """u(lxx) by Eq. (34): calibration, and non-linearity taken as rectangular."""
        return float(np.hypot(calibration, self.nonlinearity / self.slope / np.sqrt(3.0)))


def read_amplitudes(path: Path, tell: Callable[[str], None] | None = None) -> tuple[Array, Array]:
    """Reference and measured amplitudes from a CSV with the columns ``reference, measured``.

    Raises
    ------
    InputError
        Fewer than four points, text, or references that are all equal.
    """
    outputs = read_columns(path, ("reference", "measured"), tell=tell).outputs
    reference, measured = outputs["reference"], outputs["measured"]
    if len(reference) < _FEWEST_POINTS:
        raise InputError(
            f"{path}: {len(reference)} points; a line and its residuals need at least "
            f"{_FEWEST_POINTS}"
        )
    if np.ptp(reference) <= 1e-9 * np.abs(reference).max():
        raise InputError(f"{path}: all reference amplitudes are equal; no line can be fitted")
    return reference, measured


def linearity(reference: Array, measured: Array, full_scale: float) -> LinearityFit:
    """Fit a straight line by least squares; amplitudes and full scale in fractions of g."""
    slope, offset = np.polyfit(reference, measured, 1)
    return LinearityFit(reference, measured, float(slope), float(offset), full_scale)


def simulate_shaker(
    frequencies: Array,
    reference: Array,
    scale: float,
    cubic: float,
    noise: float,
    rate: float,
    duration: float,
    series: int,
    generator: np.random.Generator,
) -> Array:
    """Mean measured amplitude at each frequency over ``series`` series.

    The sensor reads ``scale (a + cubic a^3)`` with white noise; its amplitude is that of the
    sinusoid fitted at the known frequency (IEEE Std 1057, three parameters).
    """
    time = np.arange(round(duration * rate)) / rate
    result = np.zeros(len(frequencies))
    for _ in range(series):
        for i, (frequency, amplitude) in enumerate(zip(frequencies, reference, strict=True)):
            angle = 2.0 * np.pi * frequency * time + generator.uniform(0.0, 2.0 * np.pi)
            true = amplitude * np.sin(angle)
            output = scale * (true + cubic * true**3) + noise * generator.standard_normal(len(time))
            design = np.column_stack([np.sin(angle), np.cos(angle), np.ones_like(angle)])
            (a, b, _), *_ = np.linalg.lstsq(design, output, rcond=None)
            result[i] += np.hypot(a, b) / series
    return result


def cubic_of(nonlinearity: float, full_scale: float, scale: float, reference: Array) -> float:
    """The cubic term whose line fit over these amplitudes leaves the asked non-linearity."""
    unit = linearity(reference, 0.75 * scale * reference**3, full_scale)
    return nonlinearity / unit.nonlinearity
