"""``mcsim.allan.from_density``: from a tabulated density to its Allan deviation, Eq. (3.12)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mcsim.api.allan.tables import DensityTable, read_density
from mcsim.api.found import Found
from mcsim.characterisation.density_integral import TabulatedDensity, allan_from_density
from mcsim.characterisation.sensor_file import SAMPLE
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.text_table import columns
from mcsim.units import KINDS, in_unit

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

_PER_DECADE = 10
#: Exponents between which the continued integral exists.
_STEEPEST, _SHALLOWEST = -3.0, 1.0
#: What lies outside of the band may change the deviation by less: it is then known.
_KNOWN = 0.02
#: Rows on a terminal.
_ROWS = 16


@dataclass(frozen=True)
class AllanOfDensity(Found):
    """The Allan deviation that belongs to a tabulated density.

    Attributes
    ----------
    source : DensityTable
        Two-sided, SI units.
    tau : float64 (k,)
        Cluster times in s.
    inside, continued : float64 (k,)
        Allan deviation in SI units of the band of the table alone, which is the least it can be,
        and with both ends continued by their power laws (nan where that has no integral).
    slopes : (float, float)
        Exponents of the frequency at both ends.
    origin : mapping
        Where it comes from.
    """

    source: DensityTable
    tau: Array
    inside: Array
    continued: Array
    slopes: tuple[float, float]
    origin: Mapping[str, Any]

    @property
    def known(self) -> NDArray[np.bool_]:
        """Cluster times (k,) at which the ends matter little."""
        return np.asarray(self.continued <= (1.0 + _KNOWN) * self.inside)

    @property
    def table(self) -> pd.DataFrame:
        """Columns tau_s, adev_band, adev_continued (SI)."""
        import pandas as pd

        return pd.DataFrame(
            {"tau_s": self.tau, "adev_band": self.inside, "adev_continued": self.continued}
        )

    @property
    def text(self) -> str:
        """The curve as a terminal shows it."""
        kind, unit = SAMPLE[self.source.element]
        one = in_unit(1.0, unit, KINDS[kind])
        rows = [["τ [s]", f"band alone [{unit}]", f"ends continued [{unit}]", ""]]
        for i in np.unique(np.linspace(0, len(self.tau) - 1, _ROWS).round().astype(int)):
            pair = (self.inside[i] * one, self.continued[i] * one)
            far = "" if self.known[i] else "what lies outside of the band matters"
            rows.append([f"{self.tau[i]:.4g}", *(_cell(x) for x in pair), far])
        return "\n".join([*columns(rows), *self._sentences()])

    def _sentences(self) -> list[str]:
        first, last = (round(slope, 2) + 0.0 for slope in self.slopes)
        said = [f"{note}." for note in self.source.notes]
        said.append(f"The density goes as f^{first:g} at its lower end, f^{last:g} at its upper.")
        if first <= _STEEPEST:
            said.append("Continued below, its Allan variance would be infinite (f⁻³ or steeper).")
        if last >= _SHALLOWEST:
            said.append("Continued above, its Allan variance would be infinite (it rises as f).")
        if self.known.any():
            tau = self.tau[self.known]
            said.append(f"Known to {100 * _KNOWN:g} % from {tau[0]:.3g} s to {tau[-1]:.3g} s.")
        return said

    def report(self) -> Report:
        """Files ``allan_of_density`` (table and picture)."""
        from mcsim.figures.allan_density import (
            AllanCurveLine,
            DensityCurve,
            draw_density_and_curve,
        )
        from mcsim.figures.style import printed

        kind, unit = SAMPLE[self.source.element]
        figure = draw_density_and_curve(
            DensityCurve(self.source.name, self.source.frequency, self.source.density),
            [
                AllanCurveLine("band of the table alone", self.tau, self.inside),
                AllanCurveLine("ends continued", self.tau, self.continued),
            ],
            in_unit(1.0, unit, KINDS[kind]),
            unit,
        )
        return Report(
            provenance=self.origin,
            tables={"allan_of_density": self.table},
            pictures=printed(figure, "allan_of_density"),
            nine_digits=("allan_of_density",),
        )


def _cell(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "–"


def from_density(
    file: str | Path,
    *,
    sides: str | None = None,
    column: str | None = None,
    channel: str | None = None,
) -> AllanOfDensity:
    """The Allan deviation of a tabulated power spectral density, by the integral of Eq. (3.12).

    Between its points the density is a power law.  The integral over the band of the table is the
    least that the Allan variance can be; with the ends continued it is what the table suggests.

    Parameters
    ----------
    file : path
        A table of frequency and density with units in its header, such as ``psd.csv`` of
        ``mcsim characterise``.
    sides : "one" or "two", optional
        Convention of the density, where its title does not say it.
    column, channel : str, optional
        Which density, and which channel of a column ``channel``, where there are several.

    Returns
    -------
    AllanOfDensity
        ``tau``, ``inside``, ``continued``, ``table``, ``text``, and ``write(folder)``.

    Raises
    ------
    InputError
        A table that cannot be read, or lacks a unit or a convention.
    """
    path = Path(file)
    source = read_density(path, sides, column, channel)
    density = TabulatedDensity(source.frequency, source.density)
    low, high = density.band
    tau = np.geomspace(0.5 / high, 0.5 / low, max(2, round(_PER_DECADE * np.log10(high / low)) + 1))
    inside = allan_from_density(density, tau, density.band, source.frequency)
    first, last = density.slopes
    continued = np.full(len(tau), np.nan)
    if first > _STEEPEST and last < _SHALLOWEST:
        continued = allan_from_density(density.continued(), tau, points=source.frequency)
    options = {"sides": sides, "column": column, "channel": channel}
    return AllanOfDensity(
        source,
        tau,
        np.sqrt(inside),
        np.sqrt(continued),
        density.slopes,
        provenance_of("allan from-density", [path], options),
    )
