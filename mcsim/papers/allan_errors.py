"""``mcsim table allan-errors``: the ± columns of Tables 5.4 to 5.6 beside the fit's own.

The thesis takes its ± from Eq. (3.24), 1 / √(2 (K / M - 1)), and finds 0.3 %: with clusters of
"100 points" of 14 h.  That is how well one point of the curve is known at a short cluster time;
it says nothing of B and K, which are read off at long ones.  Beside it stands the standard
uncertainty that a fit to the whole curve has, under the noise of the printed N, B and K.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mcsim.papers import Computed, PaperTable
from mcsim.papers.sensor_logs import printed
from mcsim.text_table import columns

if TYPE_CHECKING:
    import pandas as pd

HOURS = 14.0
#: N (m/s/√h), B (m/s/h), K (m/s/h^1.5) of x, y, z with the printed ±.
PRINTED: dict[str, dict[str, tuple[tuple[float, float], ...]]] = {
    "MTI-300": {
        "N": ((0.0833, 0.00026), (0.0852, 0.00026), (1.19599, 0.0062)),
        "B": ((1.4273, 0.0045), (1.9474, 0.0061), (2.7729, 0.0087)),
        "K": ((4.052, 0.0128), (1.5527, 0.0049), (8.3062, 0.0262)),
    },
    "MPU-9250": {
        "N": ((0.1277, 0.0004), (0.1274, 0.0004), (0.2565, 0.0008)),
        "B": ((4.4881, 0.0141), (4.4140, 0.0139), (4.2605, 0.0134)),
        "K": ((4.9431, 0.0156), (5.1879, 0.0163), (8.8999, 0.0375)),
    },
    "LSM9DS1": {
        "N": ((0.0825, 0.00025), (0.0723, 0.00022), (0.0977, 0.0003)),
        "B": ((1.7619, 0.0055), (1.6712, 0.0053), (2.3084, 0.0073)),
        "K": ((2.1911, 0.0069), (2.8486, 0.0090), (4.8661, 0.0153)),
    },
    "BNO055": {
        "N": ((0.0743, 0.00023), (0.0840, 0.00026), (0.1032, 0.00032)),
        "B": ((0.8039, 0.0025), (2.9657, 0.0093), (3.9984, 0.0126)),
        "K": ((1.866, 0.0053), (12.7052, 0.040), (2.3612, 0.0074)),
    },
    "LSM303DLHC": {
        "N": ((0.7554, 0.0024), (0.8139, 0.0026), (0.8776, 0.0028)),
        "B": ((2.6671, 0.0084), (4.2955, 0.0135), (6.7863, 0.0157)),
        "K": ((3.306, 0.0104), (6.7863, 0.0454), (14.4080, 0.0454)),
    },
}
_TO_SI = {"N": 60.0, "B": 3600.0, "K": 3600.0**1.5}
_UNITS = {"N": "m/s/√h", "B": "m/s/h", "K": "m/s/h^1.5"}
#: Half-width of a normal 95 % interval.
_NORMAL = 1.959963984540054
#: The ± that most cells have, and what differs from it by more.
_USUAL, _FAR = 0.00315, 0.15
_WORDS = """\
In % of the value. printed: the ± column; of the fit: standard uncertainty of a weighted fit to
the whole Allan curve of {hours:g} h at the rate of Table 5.2, if the noise is what is printed (half
its 95 % interval over 1.96, from the covariance of the curve; "below" where the interval reaches
zero). Eq. (3.24) gives {usual:.2%} at the clusters of the thesis: N at the sensors' rates is known
better than that, B some {b:.0f} times and K some {k:.0f} times worse."""


@dataclass(frozen=True)
class Cell:
    """One coefficient of one axis, in the table's unit; ``fitted`` its relative uncertainty."""

    sensor: str
    axis: str
    term: str
    value: float
    printed: float
    fitted: float
    seen: bool
    rate: float


def cells() -> list[Cell]:
    """All of Tables 5.4 to 5.6."""
    found = []
    for sensor, terms in PRINTED.items():
        rate = printed(sensor).rate
        for i, axis in enumerate("xyz"):
            known = _uncertainties({t: terms[t][i][0] / _TO_SI[t] for t in terms}, rate)
            for term in terms:
                value, error = terms[term][i]
                found.append(Cell(sensor, axis, term, value, error, *known[term], rate))
    return found


def _uncertainties(model: dict[str, float], rate: float) -> dict[str, tuple[float, bool]]:
    """Relative uncertainty of a fit to the curve that N, B and K (SI) make, and whether seen."""
    from mcsim.characterisation.allan import AllanCurve, allan_terms, averaging_factors
    from mcsim.characterisation.fit import fit_noise

    factors = averaging_factors(round(HOURS * 3600.0 * rate), rate)
    squares = np.array([0.0, model["N"] ** 2, model["B"] ** 2, model["K"] ** 2, 0.0])
    variance = allan_terms(factors / rate) @ squares
    curve = AllanCurve(factors, 1.0 / rate, HOURS * 3600.0, variance)
    fit = fit_noise(curve, intervals="covariance")
    return {
        t: ((fit[t].high - fit[t].low) / (2.0 * _NORMAL * model[t]), fit[t].seen) for t in model
    }


def allan_errors() -> Computed:
    """The three ± columns, printed beside those of a fit."""
    found = cells()
    ratio = {
        t: float(np.median([c.fitted * c.value / c.printed for c in found if c.term == t]))
        for t in _UNITS
    }
    words = _WORDS.format(hours=HOURS, usual=_USUAL, b=ratio["B"], k=ratio["K"])
    odd = [
        f"{c.sensor} {c.term}{c.axis} {c.printed / c.value:.2%}"
        for c in found
        if abs(c.printed / c.value / _USUAL - 1.0) > _FAR
    ]
    told = f"Cells whose printed ± is another part of the value: {', '.join(odd)}."
    text = "\n".join([*columns(_rows(found)), words, told])
    return Computed({"allan-errors": _frame(found)}, text)


def _rows(found: Sequence[Cell]) -> list[list[str]]:
    heads = [f"{t} [{u}]" for t, u in _UNITS.items()]
    rows = [["sensor", "axis", *(x for h in heads for x in (h, "± printed", "of the fit"))]]
    for k in range(0, len(found), len(_UNITS)):
        group = found[k : k + len(_UNITS)]
        row = [group[0].sensor, group[0].axis]
        for c in group:
            fitted = f"{c.fitted:.2%}" if c.seen else "below"
            row += [f"{c.value:g}", f"{c.printed / c.value:.2%}", fitted]
        rows.append(row)
    return rows


def _frame(found: Sequence[Cell]) -> pd.DataFrame:
    """One row per coefficient; the unit stands in its own column."""
    import pandas as pd

    rows: list[dict[str, Any]] = [
        {
            "sensor": c.sensor,
            "axis": c.axis,
            "term": c.term,
            "value printed": c.value,
            "error printed": c.printed,
            "unit": _UNITS[c.term],
            "relative error printed": c.printed / c.value,
            "relative uncertainty of fit": c.fitted,
            "rate [Hz]": c.rate,
        }
        for c in found
    ]
    return pd.DataFrame(rows)


TABLE = PaperTable(
    "allan-errors",
    "The ± columns of Tables 5.4 to 5.6, printed, and the uncertainty of a fit of N, B and K.",
    allan_errors,
    files=("allan-errors",),
)
