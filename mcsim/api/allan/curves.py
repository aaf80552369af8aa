"""``mcsim.allan.curves``: what theory says of each term, and of a sensor's terms together."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mcsim.api.allan.sensors import SensorAxis, sensor_axes
from mcsim.api.allan.words import coefficient_words
from mcsim.api.bounded import positive
from mcsim.api.found import Found
from mcsim.characterisation import noise_terms as terms
from mcsim.characterisation.noise_terms import NoiseTerm, total_variance
from mcsim.characterisation.process import GaussMarkov
from mcsim.characterisation.sensor_file import SAMPLE
from mcsim.errors import InputError
from mcsim.figures.allan_terms import CorrelationPanel, TermPanel, draw_terms
from mcsim.figures.style import printed
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.text_table import columns
from mcsim.units import KINDS, in_unit

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: Points per decade of cluster time, and the decades of the pictures (s).
_PER_DECADE, _SHORTEST, _LONGEST = 20, 1e-2, 1e5
#: In the figure of the terms: cut-off of the flicker noise (Hz), sampling interval of the
#: quantisation (s), correlation time (s), frequency of the sinusoid (Hz).
_CUTOFF, _INTERVAL, _TIME, _FREQUENCY = 1.0, 0.01, 10.0, 0.1
#: Coefficients whose terms take turns, as in Figure 3.6.
_EXAMPLE = {"Q": 0.003, "N": 0.05, "B": 0.03, "K": 3e-4, "R": 1e-6}


@dataclass(frozen=True)
class AllanCurves(Found):
    """Theoretical Allan deviations.

    Attributes
    ----------
    panels : tuple of TermPanel
        What is drawn: terms, cluster times, unit.
    table : DataFrame
        A row per curve and cluster time: ``curve``, ``term`` (``total`` for all together),
        ``tau_s``, ``adev`` and ``unit``.
    text : str
        Where each coefficient is read.
    origin : mapping
        Where it comes from.
    """

    panels: tuple[TermPanel | CorrelationPanel, ...]
    table: pd.DataFrame
    text: str
    title: str
    origin: Mapping[str, Any]

    def report(self) -> Report:
        """Files ``curves`` (table and picture)."""
        return Report(
            provenance=self.origin,
            tables={"curves": self.table},
            pictures=printed(draw_terms(self.panels, self.title), "curves"),
            nine_digits=("curves",),
        )


def curves(
    sensor: str | Path | None = None,
    *,
    element: str | None = None,
    axis: str | None = None,
    cutoff: str | None = None,
) -> AllanCurves:
    """Theoretical Allan deviation of each term, or of the terms of a sensor.

    Parameters
    ----------
    sensor : path or str, optional
        A sensor file in any dialect, or a built-in sensor; without one the terms of the thesis
        themselves, Figures 3.2 to 3.7, with quantisation, ramp and sinusoid.
    element, axis : str, optional
        ``accelerometer`` or ``gyroscope``; ``x``, ``y`` or ``z``; all if absent.
    cutoff : str, optional
        Frequency above which a sensor's flicker noise ends, ``1 Hz``: Eq. (3.16); none if absent.

    Returns
    -------
    AllanCurves
        ``table``, ``text``, ``panels``, and ``write(folder)``.

    Raises
    ------
    InputError
        No such sensor, element or axis, or a cut-off that is not above zero.
    """
    if sensor is None:
        if element is not None or axis is not None or cutoff is not None:
            raise InputError("--element, --axis and --cutoff are of a sensor; name one")
        return _of_terms()
    found = sensor_axes(sensor, element, axis)
    end = _cutoff(cutoff)
    axes = [replace(one, cutoff=end) for one in found.axes]
    panels = tuple(panel_of(one) for one in axes)
    rows = [["axis", "term", "coefficient", "slope", "read at τ", "deviation there"]]
    rows += [row for one in axes for row in _rows(one)]
    options = {"sensor": found.name, "cutoff": cutoff}
    origin = provenance_of("allan curves", [found.file] if found.file else [], options)
    title = f"{found.name}: Allan deviation of its terms"
    return AllanCurves(panels, _table(panels), "\n".join(columns(rows)), title, origin)


def _cutoff(text: str | None) -> float:
    if text is None:
        return math.inf
    return positive("--cutoff", text, KINDS["frequency"])


def cluster_times(shortest: float = _SHORTEST, longest: float = _LONGEST) -> Array:
    """Cluster times (k,) in s of a picture."""
    count = round(_PER_DECADE * np.log10(longest / shortest)) + 1
    return np.geomspace(shortest, longest, count)


def panel_of(axis: SensorAxis) -> TermPanel:
    """The terms of one axis, in the unit of its samples."""
    kind, unit = SAMPLE[axis.element]
    return TermPanel(
        title=f"{axis.element} {axis.axis}",
        label=f"Allan deviation [{unit}]",
        terms=axis.terms,
        tau=cluster_times(),
        one=in_unit(1.0, unit, KINDS[kind]),
    )


def _rows(axis: SensorAxis) -> list[list[str]]:
    kind, unit = SAMPLE[axis.element]
    rows = []
    for term in axis.terms:
        assert term.read_off is not None
        level = in_unit(term.read_off.level * term.coefficient, unit, KINDS[kind])
        name = "Tc" if term.letter == "GM" else term.letter
        where = "plateau" if term.letter == "B" else f"{term.read_off.tau:.4g} s"
        rows.append(
            [
                f"{axis.element} {axis.axis}",
                term.words,
                f"{name} = {coefficient_words(axis, name)}",
                term.slope,
                where,
                f"{level:.4g} {unit}",
            ]
        )
    return rows


def shown_terms() -> dict[str, NoiseTerm]:
    """The terms of the figure, each with a coefficient of 1."""
    deviation = np.sqrt(_TIME / 2.0)  # qc = 1
    return {
        "quantisation Q, slope −1: Q at τ = √3 s": terms.quantisation(1.0, _INTERVAL),
        "white noise N, slope −1/2: N at τ = 1 s": terms.white(1.0),
        "bias instability B up to f₀ = 1 Hz: 0.664 B": terms.flicker(1.0, _CUTOFF),
        "random walk K, slope +1/2: K at τ = 3 s": terms.random_walk(1.0),
        "ramp R, slope +1: R at τ = √2 s": terms.ramp(1.0),
        "Gauss-Markov, Tc = 10 s: 0.437 qc √Tc at 1.89 Tc": terms.gauss_markov(
            GaussMarkov(_TIME, float(deviation))
        ),
        "sinusoid of 0.1 Hz: 0.725 A at 0.371 / f": terms.sinusoid(1.0, _FREQUENCY),
    }


def _of_terms() -> AllanCurves:
    tau = cluster_times(1e-2, 1e3)
    single = [
        TermPanel(title, f"Allan deviation for {_unit(term)} = 1 (SI)", [term], _fine(term, tau))
        for title, term in shown_terms().items()
    ]
    mixed = [
        terms.quantisation(_EXAMPLE["Q"], _INTERVAL),
        terms.white(_EXAMPLE["N"]),
        terms.flicker(_EXAMPLE["B"]),
        terms.random_walk(_EXAMPLE["K"]),
        terms.ramp(_EXAMPLE["R"]),
    ]
    example = ", ".join(f"{k} {v:g}" for k, v in _EXAMPLE.items())
    panels: tuple[TermPanel | CorrelationPanel, ...] = (
        *single,
        TermPanel(f"together ({example}, SI)", "Allan deviation (SI)", mixed, cluster_times()),
        CorrelationPanel("Gauss-Markov: autocorrelation, 1/e at Tc"),
    )
    rows = [["term", "slope", "read at τ", "deviation there, coefficient 1"]]
    for term in shown_terms().values():
        point = term.read_off
        assert point is not None
        rows.append([term.words, term.slope, f"{point.tau:.4g} s", f"{point.level:.4g}"])
    return AllanCurves(
        panels,
        _table(panels),
        "\n".join(columns(rows)),
        "Allan deviation of each term (Figures 3.2 to 3.7 of the thesis)",
        provenance_of("allan curves"),
    )


def _unit(term: NoiseTerm) -> str:
    return {"GM": "qc", "S": "A"}.get(term.letter, term.letter)


def _fine(term: NoiseTerm, tau: Array) -> Array:
    """Cluster times that a curve with lobes needs, no two of them on a zero."""
    if term.letter == "S":
        return np.geomspace(0.1, 100.0, 4001)
    return np.geomspace(tau[0], tau[-1], 1001) if term.letter == "B" else tau


def _table(panels: Sequence[TermPanel | CorrelationPanel]) -> pd.DataFrame:
    import pandas as pd

    def part(panel: TermPanel, name: str, deviation: Array) -> pd.DataFrame:
        return pd.DataFrame(
            {
                "curve": panel.title,
                "term": name,
                "tau_s": panel.tau,
                "adev": deviation * panel.one,
                "unit": panel.label.partition("[")[2].rstrip("]") or "SI",
            }
        )

    parts = []
    for panel in panels:
        if isinstance(panel, TermPanel):
            parts += [part(panel, t.letter, t.deviation(panel.tau)) for t in panel.terms]
            if len(panel.terms) > 1:
                total = np.sqrt(total_variance(panel.terms, panel.tau))
                parts.append(part(panel, "total", total))
    return pd.concat(parts)
