"""What a calibration by the norm of gravity tells, as tables and in words."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mcsim.calibration.norm import UNKNOWNS, WORTH_A_WORD, NormFit

if TYPE_CHECKING:
    import pandas as pd

#: Positions that lie off by so many deviations are named.
_FAR = 4.0
#: With fewer positions intervals of 95 % hold the truth in 92 % at worst.
_FEW = 12


def norm_residual_table(fit: NormFit) -> pd.DataFrame:
    """Columns position, samples, x, y, z and residual (norm less one), deviation; g."""
    import pandas as pd

    return pd.DataFrame(
        {
            "position": fit.test.names,
            "samples": fit.test.counts,
            **{f"{axis} [g]": fit.test.means[:, k] for k, axis in enumerate("xyz")},
            "residual [g]": fit.residuals,
            "deviation [g]": fit.deviations,
        }
    )


def norm_words(fit: NormFit) -> str:
    """Where the uncertainties come from, and what the positions cover."""
    return " ".join(_norm(fit))


def _norm(fit: NormFit) -> Iterator[str]:
    n = len(fit.residuals)
    yield (
        f"{n} positions at rest, {UNKNOWNS} unknowns, {n - UNKNOWNS} degrees of freedom: the norm "
        "of gravity. A rotation of the sensor does not show in it; L is symmetric, the frame "
        "turned least from the sensor's own axes."
    )
    yield from _noise(fit)
    yield f"Condition number {fit.condition:.3g}."
    if fit.condition > WORTH_A_WORD:
        yield (
            f"The positions tell little of {', '.join(fit.weakest)}: add some that differ more "
            "from these (each axis up, down, and between)."
        )
    if n < _FEW:
        yield (
            f"With fewer than {_FEW} positions some intervals hold the truth in 92 % rather than "
            "95 %, and they are wide."
        )
    far = np.abs(fit.residuals) > _FAR * np.maximum(fit.deviations, 1e-12)
    if np.any(far):
        names = ", ".join(fit.test.names[k] for k in np.flatnonzero(far))
        yield f"Far off: {names}; did the sensor move there?"
    yield (
        "± k u is an interval of 95 % (Student's t, degrees of freedom by JCGM 100, G.4); "
        "calibration.yaml holds k u / 1.96, the deviation of a normal distribution with this "
        "interval."
    )


def _noise(fit: NormFit) -> Iterator[str]:
    if fit.scatter is None:
        yield (
            "Each position is one row, whose noise nothing tells: u is from the residuals, "
            f"{fit.position:.2g} g each."
        )
        return
    x, y, z = fit.scatter.deviation
    yield f"One sample's noise is x {x:.2g}, y {y:.2g}, z {z:.2g} g."
    if fit.position > 0.1 * math.sqrt(float(np.mean(fit.deviations**2))):
        yield (
            f"Beyond it, norms scatter by {fit.position:.2g} g from position to position (a drift "
            "of the bias, non-linearity, motion)."
        )
    else:
        yield "Positions scatter by no more than that."
