"""What a six-position or a shaker test tells, in words made from its numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mcsim.calibration.shaker import LinearityFit
from mcsim.calibration.six_positions import AXES, SixPositionFit
from mcsim.calibration.uncertainty import CHANGE_LEVEL, FIXTURE_LEVEL

#: Correlation between samples, and scatter of positions beyond noise, that are worth a word.
_INFLATED, _BEYOND = 1.2, 0.1
#: With fewer degrees of freedom the coverage factor exceeds 2.8.
_FEW = 4.0


def calibration_words(fit: SixPositionFit) -> str:
    """Where the uncertainties of a six-position test come from, and what they rest on."""
    return " ".join(_calibration(fit))


def _calibration(fit: SixPositionFit) -> Iterator[str]:
    u, scatter = fit.uncertainties, fit.scatter
    if scatter is None:
        yield (
            "Each position is one row, whose noise nothing tells: u is from the residuals of the "
            f"equations ({_axes(u.position)} g for an axis in one position)."
        )
    else:
        yield f"One sample's noise is {_axes(scatter.deviation)} g; it leaves {_axes(u.noise)} g."
        if (scatter.inflation > _INFLATED).any():
            yield (
                "Samples are correlated, as those of a low-passed sensor: their means have "
                f"{_axes(scatter.inflation)} times the variance of as many independent ones."
            )
        if (u.position > _BEYOND * u.noise).any():
            angle = math.degrees(float(u.position[0] / abs(fit.matrix[0, 0])))
            yield (
                f"Beyond that, positions scatter by {_axes(u.position)} g, as a misalignment of "
                f"{angle:.2g} ° does."
            )
        else:
            yield "Positions scatter by no more than that."
    yield from _repetitions(fit)
    least = min((e for e in fit.estimates().values()), key=lambda e: e.freedom)
    if least.freedom < _FEW:
        remedy = (
            "give the samples of each position, or repeat the test"
            if scatter is None
            else "repeat the test"
        )
        yield (
            f"As few as {least.freedom:.1f} degrees of freedom need k = "
            f"{least.coverage_factor:.1f}; for less, {remedy}."
        )
    yield (
        "± k u is an interval of 95 % (Student's t, degrees of freedom by JCGM 100, G.4); "
        "calibration.yaml holds k u / 1.96, the deviation of a normal distribution with this "
        "interval."
    )


def _repetitions(fit: SixPositionFit) -> Iterator[str]:
    u, n = fit.uncertainties, len(fit.residuals)
    if n < 2:
        return
    if u.fixture:
        yield (
            f"The positions' errors in the {n} repetitions are not clearly independent (F test, "
            f"{FIXTURE_LEVEL:.0%}): they count as a fixture's, which do not average out."
        )
    for name in u.changing:
        what = "zero bias" if name == "bias" else "matrix"
        yield (
            f"The {what} changes between the repetitions by more than the positions explain (F "
            f"test, {CHANGE_LEVEL:.0%}): the scatter of the {n} repetitions is added."
        )
    if not u.fixture and not u.changing:
        yield f"The {n} repetitions agree with each other."


def linearity_words(fit: LinearityFit, mxx: float | None) -> str:
    """What a shaker test tells, line by line."""
    return "\n".join(_linearity(fit, mxx))


def _linearity(fit: LinearityFit, mxx: float | None) -> Iterator[str]:
    slope, offset = fit.slope_estimate, fit.offset_estimate
    yield (
        f"{'simulated' if fit.simulated else 'measured'}: slope {slope.value:.6g}, "
        f"u = {slope.uncertainty:.2g}; offset {offset.value:.3g} g, u = {offset.uncertainty:.2g} g "
        f"({slope.freedom:.0f} degrees of freedom, k = {slope.coverage_factor:.2f} for 95 %)"
    )
    if fit.bends:
        yield (
            "neighbouring residuals are alike: the points bend, and u tells how well a line "
            "describes these, not how well the slope elsewhere is known"
        )
    yield f"non-linearity {1e6 * fit.nonlinearity:.3g} ppm of {fit.full_scale:g} g"
    if mxx is None:
        yield (
            "its part of u(lxx), Eq. (34), divides by mxx of a six-position test: give it by --mxx "
            "(`mcsim calibrate` prints it)"
        )
    else:
        yield (
            f"its part of u(lxx), Eq. (34) with mxx = {mxx:.6g}: "
            f"{fit.scale_uncertainty(0.0, mxx):.2g}"
        )


def _axes(values: np.ndarray) -> str:
    """Values of the axes, as ``x 0.004, y 0.003, z 0.005``; once if they are alike."""
    texts = [f"{value:.2g}" for value in values]
    if len(set(texts)) == 1:
        return texts[0]
    return ", ".join(f"{axis} {text}" for axis, text in zip(AXES, texts, strict=True))
