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
from mcsim.calibration.estimate import Estimate
from mcsim.errors import InputError

Array = NDArray[np.float64]

_FEWEST_POINTS, _FEWEST_REFERENCES = 4, 3
#: No shaker, and no centrifuge, makes more (g).
_LARGEST_AMPLITUDE = 1e6
#: Amplitudes that a line needs to span (g); differences of this share of them are rounding.
_LEAST_SPAN = 1e-6
_ROUNDING = 1e-9


@dataclass(frozen=True)
class LinearityFit:
    """Straight line through measured over reference amplitudes (fractions of g).

    ``nonlinearity`` is the largest residual as a share of ``full_scale``; ``simulated`` tells
    amplitudes that a simulated test found from measured ones.
    """

    reference: Array
    measured: Array
    slope: float
    offset: float
    full_scale: float
    simulated: bool = False

    @property
    def residuals(self) -> Array:
        return self.measured - self.slope * self.reference - self.offset

    @property
    def nonlinearity(self) -> float:
        return float(np.abs(self.residuals).max() / self.full_scale)

    @property
    def slope_estimate(self) -> Estimate:
        """The slope with its type-A uncertainty, if points scatter independently about the line.

        Where they bend instead, it tells how well the line is known as a description.
        """
        return self._estimate(self.slope, 1.0 / self._moment)

    @property
    def offset_estimate(self) -> Estimate:
        """The line at zero with its type-A uncertainty, as that of the slope."""
        n, mean = len(self.reference), float(self.reference.mean())
        return self._estimate(self.offset, 1.0 / n + mean**2 / self._moment)

    @property
    def bends(self) -> bool:
        """Whether neighbouring residuals are alike, as those of a curve are.

        The statistic is that of von Neumann: mean square of successive differences over the
        variance, 2 for independent residuals; beyond the lower 1 % point of its normal limit.
        """
        r = self.residuals[np.argsort(self.reference, kind="stable")]
        n, squares = len(r), float(r @ r)
        if not squares > (_ROUNDING * np.abs(self.measured).max()) ** 2 * n:
            return False
        ratio = float(np.sum(np.diff(r) ** 2)) / squares
        return ratio < 2.0 - 2.326 * 2.0 * np.sqrt((n - 2.0) / (n**2 - 1.0))

    @property
    def _moment(self) -> float:
        return float(np.sum((self.reference - self.reference.mean()) ** 2))

    def _estimate(self, value: float, factor: float) -> Estimate:
        freedom = len(self.reference) - 2
        variance = float(np.sum(self.residuals**2)) / freedom
        return Estimate(value, float(np.sqrt(variance * factor)), float(freedom))

    def scale_uncertainty(self, calibration: float, mxx: float) -> float:
        """u(lxx) by Eq. (34): calibration, and non-linearity taken as rectangular.

        ``mxx`` is M0's element from the six-position test.  The slope of the shaker's line is no
        substitute: a bent line has another slope than the sensor at 1 g.
        """
        return float(np.hypot(calibration, self.nonlinearity / abs(mxx) / np.sqrt(3.0)))


def read_amplitudes(path: Path, tell: Callable[[str], None] | None = None) -> tuple[Array, Array]:
    """Reference and measured amplitudes from a CSV with the columns ``reference, measured``.

    Raises
    ------
    InputError
        Fewer than four points, text, amplitudes beyond a shaker's, references with fewer
        than three different values, or a sensor that did not follow.
    """
    table = read_columns(path, ("reference", "measured"), tell=tell)
    outputs = table.outputs
    reference, measured = outputs["reference"], outputs["measured"]
    if len(reference) < _FEWEST_POINTS:
        raise InputError(
            f"{path}: {len(reference)} points; a line and its residuals need at least "
            f"{_FEWEST_POINTS}"
        )
    for name, values in outputs.items():
        far = np.abs(values) > _LARGEST_AMPLITUDE
        if far.any():
            row = int(np.argmax(far))
            raise InputError(
                f"{table.where(row)}: {name}: {values[row]:g} g is no amplitude of a shaker; "
                f"values up to {_LARGEST_AMPLITUDE:g} g are taken"
            )
    if len(np.unique(reference)) < _FEWEST_REFERENCES:
        raise InputError(
            f"{path}: the reference has {len(np.unique(reference))} different amplitudes; "
            f"a line and its residuals need at least {_FEWEST_REFERENCES}"
        )
    if np.ptp(reference) <= max(_ROUNDING * np.abs(reference).max(), _LEAST_SPAN):
        raise InputError(
            f"{path}: the reference amplitudes hardly differ, by {np.ptp(reference):.2g} g; "
            "no line can be fitted"
        )
    if np.ptp(measured) == 0.0:
        raise InputError(
            f"{path}: all measured amplitudes are equal ({measured[0]:g} g): the sensor did not "
            "follow the shaker"
        )
    return reference, measured


def linearity(
    reference: Array, measured: Array, full_scale: float, simulated: bool = False
) -> LinearityFit:
    """Fit a straight line by least squares; amplitudes and full scale in fractions of g.

    Parameters
    ----------
    reference, measured : (n,)
        Amplitudes in fractions of g, n >= 3, references not all equal.
    full_scale : float
        Fractions of g.
    simulated
        Whether a simulated test found the amplitudes.
    """
    centred = reference - reference.mean()
    slope = float(centred @ (measured - measured.mean()) / (centred @ centred))
    offset = float(measured.mean() - slope * reference.mean())
    return LinearityFit(reference, measured, slope, offset, full_scale, simulated)


def simulate_shaker(
    frequencies: Array,
    reference: Array,
    scale: float,
    cubic: float,
    noise: float,
    time: Array,
    series: int,
    generator: np.random.Generator,
) -> Array:
    """Mean measured amplitude at each frequency over ``series`` series.

    The sensor reads ``scale (a + cubic a^3)`` with white noise; its amplitude is that of the
    sinusoid fitted at the known frequency (IEEE Std 1057, three parameters).  ``time`` (n,) are
    the samples' times (s).
    """
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
