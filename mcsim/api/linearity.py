"""``mcsim.linearity``: the shaker test of an accelerometer, measured or simulated."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcsim.api.bounded import between
from mcsim.api.found import Found
from mcsim.calibration import LinearityFit, read_amplitudes
from mcsim.calibration import linearity as fit_of
from mcsim.calibration.simulated import (
    is_scenario,
    sensitivity,
    simulated_linearity,
    velocity_scenario,
)
from mcsim.calibration.tables import linearity_table
from mcsim.calibration.words import linearity_words
from mcsim.errors import InputError
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.units import KINDS

if TYPE_CHECKING:
    import pandas as pd

#: Full scales (g) that a sensor may have.
_SCALES = "1 mg", "1e+06 g"


@dataclass(frozen=True)
class Linearity(Found):
    """Straight line and non-linearity of an accelerometer.

    Attributes
    ----------
    name : str
        Of the test.
    fit : mcsim.calibration.LinearityFit
        Amplitudes (n,) and line in fractions of g.
    mxx : float or None
        M0's element of a six-position test, for Eq. (34).
    origin : mapping
        Where it comes from: the provenance of its files.
    """

    name: str
    fit: LinearityFit
    mxx: float | None
    origin: Mapping[str, Any]

    @property
    def table(self) -> pd.DataFrame:
        """Columns reference, measured (or simulated), fitted (g) and residual (ppm)."""
        return linearity_table(self.fit)

    @property
    def words(self) -> str:
        """What the test tells, line by line."""
        return linearity_words(self.fit, self.mxx)

    def report(self) -> Report:
        """Files ``linearity``: table and picture."""
        from mcsim.figures.linearity import draw_linearity
        from mcsim.figures.style import printed

        return Report(
            provenance=self.origin,
            tables={"linearity": self.table},
            pictures=printed(draw_linearity([self.fit], [self.name]), "linearity"),
        )


def linearity(
    file: str | Path,
    *,
    full_scale: str | None = None,
    mxx: float | None = None,
    seed: int = 1,
    tell: Callable[[str], None] | None = None,
) -> Linearity:
    """Fit a straight line to a shaker test.

    Parameters
    ----------
    file : path
        A CSV with the columns reference and measured (amplitudes in g, or in the unit in
        brackets); or a velocity scenario (YAML) with a block ``shaker``, whose test is simulated.
    full_scale : str, optional
        Range of the sensor with its unit, such as ``15 g``; a scenario brings its own.
    mxx : float, optional
        M0's element of a six-position test, for Eq. (34); a scenario brings its own.
    seed : int
        Of the simulation.
    tell : callable, optional
        Hears what was noticed about a CSV.

    Returns
    -------
    Linearity
        ``table`` (slope, offset and their uncertainties), ``words`` and ``write(folder)``.

    Raises
    ------
    InputError
        A file that cannot be read or is no such test; what a scenario brings, or a CSV lacks.
    """
    path, simulated = Path(file), is_scenario(Path(file))
    if simulated:
        fit, mxx = _of_scenario(path, full_scale, mxx, seed)
    else:
        fit = fit_of(*read_amplitudes(path, tell), _scale(full_scale))
    options = {"full_scale": full_scale} | ({} if simulated else {"mxx": mxx})
    origin = provenance_of("linearity", [path], options, seed if simulated else None)
    return Linearity(path.stem, fit, mxx, origin)


def _of_scenario(
    path: Path, full_scale: str | None, mxx: float | None, seed: int
) -> tuple[LinearityFit, float]:
    if mxx is not None:
        raise InputError("--mxx: the scenario brings its own, from the matrix of its calibration")
    if full_scale is not None:
        raise InputError("--full-scale: the scenario brings its own, shaker.full_scale")
    model = velocity_scenario(path)
    return simulated_linearity(path, model, seed), sensitivity(model)


def _scale(text: str | None) -> float:
    if text is None:
        raise InputError("--full-scale: is missing; write for example --full-scale '15 g'")
    return between("--full-scale", text, KINDS["sensor output"], _SCALES, "15 g")
