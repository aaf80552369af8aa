"""Measured or simulated over reference acceleration of a shaker test: Figure 12."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from mcsim.calibration import LinearityFit
from mcsim.figures.style import house_style

_LINE, _POINTS = "#1b4965", "#d1495b"


def draw_linearity(fits: Sequence[LinearityFit], names: Sequence[str]) -> Figure:
    """Amplitudes with their line above, residuals in ppm of full scale below."""
    with house_style():
        figure = Figure(figsize=(4.8 * len(fits), 5.0), layout="constrained")
        panels = figure.subplots(2, len(fits), sharex="col", height_ratios=(1.7, 1), squeeze=False)
        for (above, below), fit, name in zip(panels.T, fits, names, strict=True):
            ends = np.array([0.0, fit.reference.max()])
            above.plot(ends, fit.slope * ends + fit.offset, color=_LINE, label="straight line")
            found = "simulated" if fit.simulated else "measured"
            above.plot(fit.reference, fit.measured, "o", color=_POINTS, label=found)
            above.set_title(
                f"{name}: slope {fit.slope:.4f}, "
                f"non-linearity {1e6 * fit.nonlinearity:.0f} ppm of {fit.full_scale:g} g"
            )
            above.set_ylabel(f"{found} amplitude [g]")
            above.legend(loc="upper left")
            below.axhline(0.0, color="#6b7280", linewidth=0.8)
            below.plot(fit.reference, 1e6 * fit.residuals / fit.full_scale, "o-", color=_POINTS)
            below.set_ylabel("residual [ppm FS]")
            below.set_xlabel("reference amplitude [g]")
    return figure
