"""``mcsim.allan.to_density``: the density of a sensor's terms, or of those fitted to a curve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mcsim.api.allan.sensors import SensorAxis, sensor_axes
from mcsim.api.allan.tables import CurveTable, read_curve
from mcsim.api.convert import is_file
from mcsim.api.found import Found
from mcsim.characterisation.density_integral import allan_from_density
from mcsim.characterisation.noise_terms import PEAK_TIME, NoiseTerm, total_density, total_variance
from mcsim.characterisation.sensor_file import KEYS, SAMPLE
from mcsim.characterisation.terms_of_curve import FittedTerms, terms_of_curve
from mcsim.dialects import endings
from mcsim.errors import InputError
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.text_table import columns
from mcsim.units import KINDS, in_unit

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: Terms that a curve may be fitted with, and those that it is where nothing is said.
LETTERS, USUAL = ("Q", "N", "B", "K", "R", "GM"), ("N", "B", "K")
#: Frequencies (Hz) of a sensor's density, per decade.
_LOWEST, _HIGHEST, _PER_DECADE = 1e-5, 1e3, 10
#: Cluster times (s) of its Allan deviation, and rows on a terminal.
_SHORTEST, _LONGEST, _ROWS = 1e-2, 1e5, 9
#: A curve that the terms miss by more (root mean square) is not made up of them.
_MISFIT = 0.1
_AMBIGUOUS = (
    "An Allan deviation does not determine its density: different densities have the same one "
    "(Greenhall 1998). This is the density of the fitted terms, one that fits."
)


@dataclass(frozen=True)
class TermsOfAxis:
    """Terms of one axis or curve, SI; ``fitted`` and ``curve`` where they come from a table."""

    element: str
    name: str
    terms: tuple[NoiseTerm, ...]
    frequency: Array
    tau: Array
    fitted: FittedTerms | None = None
    curve: CurveTable | None = None


@dataclass(frozen=True)
class DensityOfTerms(Found):
    """Power spectral densities of noise terms.

    Attributes
    ----------
    axes : tuple of TermsOfAxis
        Terms in SI units.
    origin : mapping
        Where it comes from.
    """

    axes: tuple[TermsOfAxis, ...]
    origin: Mapping[str, Any]

    @property
    def table(self) -> pd.DataFrame:
        """Per axis, term (``total``) and frequency: psd_two_sided, psd_one_sided; SI per Hz."""
        import pandas as pd

        parts = []
        for axis in self.axes:
            densities = {t.letter: t.density for t in axis.terms if t.density is not None}
            values = {name: density(axis.frequency) for name, density in densities.items()}
            values["total"] = total_density(axis.terms, axis.frequency)
            for name, value in values.items():
                columns = {"frequency_hz": axis.frequency, "psd_two_sided": value}
                frame = pd.DataFrame({"axis": axis.name, "term": name, **columns})
                parts.append(frame.assign(psd_one_sided=2.0 * value))
        return pd.concat(parts)

    @property
    def allan(self) -> pd.DataFrame:
        """Per axis: tau_s, adev in closed form, and adev_integral by Eq. (3.12); SI.

        A ramp and a sinusoid have no density that is a function; the integral is without them.
        """
        import pandas as pd

        parts = []
        for axis in self.axes:
            terms = [t for t in axis.terms if t.density is not None]
            closed = np.sqrt(total_variance(terms, axis.tau))
            integral = np.sqrt(
                allan_from_density(lambda f, own=terms: total_density(own, f), axis.tau)  # type: ignore[misc]
            )
            columns = {"tau_s": axis.tau, "adev": closed, "adev_integral": integral}
            parts.append(pd.DataFrame({"axis": axis.name, **columns}))
        return pd.concat(parts)

    @property
    def text(self) -> str:
        """Coefficients, densities at some frequencies, and how well the integral agrees."""
        lines = []
        for axis in self.axes:
            kind, unit = SAMPLE[axis.element]
            one = in_unit(1.0, unit, KINDS[kind])
            lines += [f"{axis.name}: {', '.join(map(_named(axis.element), axis.terms))}"]
            rows = [["frequency [Hz]", f"two-sided [({unit})²/Hz]", f"one-sided [{unit}/√Hz]"]]
            spots = np.linspace(0, len(axis.frequency) - 1, _ROWS).round().astype(int)
            for f in axis.frequency[spots]:
                value = float(total_density(axis.terms, np.array([f]))[0]) * one**2
                rows.append([f"{f:.3g}", f"{value:.4g}", f"{np.sqrt(2.0 * value):.4g}"])
            lines += [*columns(rows), *_of_fit(axis)]
        table = self.allan
        worst = float((table["adev_integral"] / table["adev"] - 1.0).abs().max())
        lines.append(f"Integral of Eq. (3.12) and closed forms agree to {worst:.1g}.")
        return "\n".join(lines)

    def report(self) -> Report:
        """Files ``density`` and ``allan`` (tables), and ``density`` (picture) of the first axis."""
        from mcsim.figures.allan_density import (
            AllanCurveLine,
            DensityCurve,
            draw_density_and_curve,
        )
        from mcsim.figures.style import printed

        kind, unit = SAMPLE[self.axes[0].element]
        densities, lines = [], []
        for axis in [a for a in self.axes if a.element == self.axes[0].element]:
            density = total_density(axis.terms, axis.frequency)
            label = axis.name if axis.curve is None else "fitted terms"
            densities.append(DensityCurve(label, axis.frequency, density))
            if axis.curve is not None:
                lines.append(
                    AllanCurveLine("table", axis.curve.tau, axis.curve.deviation, points=True)
                )
            deviation = np.sqrt(total_variance(axis.terms, axis.tau))
            lines.append(AllanCurveLine(label, axis.tau, deviation))
        figure = draw_density_and_curve(densities, lines, in_unit(1.0, unit, KINDS[kind]), unit)
        return Report(
            provenance=self.origin,
            tables={"density": self.table, "allan": self.allan},
            pictures=printed(figure, "density"),
            nine_digits=("density", "allan"),
        )


def to_density(
    given: str | Path,
    *,
    terms: Sequence[str] | None = None,
    column: str | None = None,
    channel: str | None = None,
    element: str | None = None,
    axis: str | None = None,
) -> DensityOfTerms:
    """The power spectral density of a sensor's noise terms, or of those of an Allan curve.

    From a curve to a density there is no unique way back: what is well posed, and done here, is
    the fit of non-negative terms, whose density is then known.

    Parameters
    ----------
    given : path or str
        A built-in sensor, a sensor file in any dialect, or a table of cluster time and Allan
        deviation with units in its header, such as ``allan.csv`` of ``mcsim characterise``.
    terms : sequence of str, optional
        Of a table: ``Q``, ``N``, ``B``, ``K``, ``R``, ``GM`` (Gauss-Markov); N, B, K if absent.
    column, channel : str, optional
        Of a table with several.
    element, axis : str, optional
        Of a sensor: ``accelerometer`` or ``gyroscope``; ``x``, ``y`` or ``z``.

    Returns
    -------
    DensityOfTerms
        ``table``, ``allan``, ``text``, and ``write(folder)``.

    Raises
    ------
    InputError
        No such sensor, a table that cannot be read, or terms that there are not.
    """
    if is_file(given) and Path(given).suffix.lower() not in endings():
        if element is not None or axis is not None:
            raise InputError(f"{given}: --element and --axis are of a sensor; give --channel")
        return _of_curve(Path(given), terms, column, channel)
    if terms is not None or column is not None or channel is not None:
        raise InputError(f"{given}: --terms, --column and --channel are of an Allan table")
    found = sensor_axes(given, element, axis)
    origin = provenance_of(
        "allan to-density", [found.file] if found.file else [], {"sensor": found.name}
    )
    return DensityOfTerms(tuple(map(_of_sensor, found.axes)), origin)


def _of_sensor(axis: SensorAxis) -> TermsOfAxis:
    return TermsOfAxis(
        axis.element,
        f"{axis.element} {axis.axis}",
        axis.terms,
        _spaced(_LOWEST, _HIGHEST),
        _spaced(_SHORTEST, _LONGEST),
    )


def _of_curve(
    path: Path, terms: Sequence[str] | None, column: str | None, channel: str | None
) -> DensityOfTerms:
    for letter in terms or ():
        if letter not in LETTERS:
            raise InputError(f'--terms: "{letter}" is none of {", ".join(LETTERS)}')
    curve = read_curve(path, column, channel)
    wanted = tuple(terms or USUAL)
    if len(curve.tau) < len(wanted) + 1 + ("GM" in wanted):
        raise InputError(f"{path}: {len(curve.tau)} cluster times are too few for these terms")
    fitted = terms_of_curve(curve.tau, curve.deviation, wanted, curve.spread)
    low, high = 0.1 / curve.tau[-1], 0.5 / curve.tau[0]
    found = TermsOfAxis(
        curve.element,
        curve.name,
        fitted.terms,
        _spaced(low, high),
        _spaced(float(curve.tau[0]), float(curve.tau[-1])),
        fitted,
        curve,
    )
    options = {"terms": terms and list(terms), "column": column, "channel": channel}
    return DensityOfTerms((found,), provenance_of("allan to-density", [path], options))


def _spaced(low: float, high: float) -> Array:
    return np.geomspace(low, high, max(2, round(_PER_DECADE * np.log10(high / low)) + 1))


def _named(element: str) -> Any:
    """What says a term's coefficient with its unit."""
    kind, sample = SAMPLE[element]
    base = "m/s" if sample == "m/s²" else "rad"

    def words(term: NoiseTerm) -> str:
        if term.letter in KEYS[element]:
            _, name, unit = KEYS[element][term.letter]
            return f"{term.letter} {in_unit(term.coefficient, unit, KINDS[name]):.4g} {unit}"
        if term.letter == "GM":
            assert term.read_off is not None
            time = term.read_off.tau / PEAK_TIME
            deviation = term.coefficient * np.sqrt(time / 2.0)
            return f"σ {in_unit(deviation, sample, KINDS[kind]):.4g} {sample}, Tc {time:.4g} s"
        unit = {"Q": base, "R": "rad/s²" if base == "rad" else "m/s³"}[term.letter]
        return f"{term.letter} {term.coefficient:.4g} {unit}"

    return words


def _of_fit(axis: TermsOfAxis) -> list[str]:
    if axis.fitted is None:
        return []
    said = [f"Fitted terms miss the table by {100 * axis.fitted.rms:.2g} % (root mean square)."]
    if axis.fitted.rms > _MISFIT:
        said.append("That is much: the curve is not made up of these terms.")
    if any(term.letter == "R" for term in axis.terms):
        said.append("A ramp is no noise: it has no density, and is left out of it.")
    return [*said, _AMBIGUOUS]
