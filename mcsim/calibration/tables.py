"""What a calibration found, as tables and as a block of a scenario."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mcsim.calibration.norm import NormFit
from mcsim.calibration.shaker import LinearityFit
from mcsim.calibration.six_positions import AXES, POSITIONS, SixPositionFit

if TYPE_CHECKING:
    import pandas as pd


def parameter_table(fit: SixPositionFit | NormFit) -> pd.DataFrame:
    """Matrix and bias: estimate, uncertainty, degrees of freedom, coverage factor."""
    import pandas as pd

    repeated: dict[str, float] = {}
    if isinstance(fit, SixPositionFit) and fit.repeatability is not None:
        corrections, biases = fit.repeatability
        for i, a in enumerate(AXES):
            repeated[f"b{a}"] = float(biases[i])
            for j, b in enumerate(AXES):
                repeated[f"l{a}{b}"] = float(corrections[i, j])
    rows = [
        (name, e.value, e.uncertainty, e.freedom, e.coverage_factor, repeated.get(name))
        for name, e in fit.estimates().items()
    ]
    return pd.DataFrame(
        rows,
        columns=[
            "quantity",
            "estimate",
            "uncertainty",
            "degrees of freedom",
            "k (95 %)",
            "from repetitions alone",
        ],
    )


def residual_table(fit: SixPositionFit) -> pd.DataFrame:
    """Columns repetition, position, and the residuals of x, y and z (g)."""
    import pandas as pd

    return pd.DataFrame(
        [
            (r + 1, position, *fit.residuals[r, p])
            for r in range(len(fit.residuals))
            for p, position in enumerate(POSITIONS)
        ],
        columns=["repetition", "position", *(f"{axis} [g]" for axis in AXES)],
    )


def linearity_table(fit: LinearityFit) -> pd.DataFrame:
    """Columns reference, measured (or simulated), fitted and residual: fractions of g and ppm."""
    import pandas as pd

    found = "simulated" if fit.simulated else "measured"

    return pd.DataFrame(
        {
            "reference [g]": fit.reference,
            f"{found} [g]": fit.measured,
            "fitted [g]": fit.measured - fit.residuals,
            "residual [ppm FS]": 1e6 * fit.residuals / fit.full_scale,
        }
    )


#: What is said of the frame of a correction that only norms tell.
_FRAME = (
    "# Only norms were measured: L is symmetric, in the frame turned least from the sensor's axes.",
)


def scenario_block(fit: SixPositionFit | NormFit) -> str:
    """The ``calibration`` block of a velocity scenario."""
    six = isinstance(fit, SixPositionFit)
    test = "a six-position test" if six else "arbitrary positions at rest"
    lines = [
        f"# Correction ac = L (am - B) of {test}. Uncertainties are k u / 1.96, the",
        "# deviation of a normal distribution with the 95 % interval of Student's t; comments tell",
        "# the standard uncertainty u, its degrees of freedom, and k.",
        *(() if six else _FRAME),
        "calibration:",
    ]
    for name, e in fit.estimates().items():
        if name[0] == "m" or name.startswith("ly"):
            continue  # no equation uses the corrected y
        unit = " g" if name.startswith("b") else ""
        lines.append(
            f"  {name}: {{estimate: {e.value:.9g}{unit}, "
            f"uncertainty: {e.normal_uncertainty:.3g}{unit}}}"
            f"  # u {e.uncertainty:.3g}, {e.freedom:.3g} degrees of freedom, "
            f"k = {e.coverage_factor:.3g}"
        )
    if fit.scatter is not None:
        x, y, z = fit.scatter.deviation
        lines += ["sensor:", f"  noise: {{x: {x:.3g} g, y: {y:.3g} g, z: {z:.3g} g}}"]
    return "\n".join(lines) + "\n"
