"""``mcsim.allan.plan``: how long a sensor must be logged, and at which rate."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcsim.api.allan.curves import panel_of
from mcsim.api.allan.sensors import SensorAxes, SensorAxis, sensor_axes
from mcsim.api.allan.words import coefficient_words, crossing_of, duration_words, error_words
from mcsim.api.bounded import between, positive
from mcsim.api.found import Found
from mcsim.characterisation.expected_errors import (
    TIME,
    clusters_needed,
    fit_errors,
    length_for,
)
from mcsim.characterisation.read_offs import Reading, reading_of
from mcsim.errors import InputError
from mcsim.logs.model import SHORT
from mcsim.provenance import provenance_of
from mcsim.report import Report
from mcsim.text_table import columns
from mcsim.units import KINDS

if TYPE_CHECKING:
    import pandas as pd

#: Coefficients that can be planned for; a Gauss-Markov bias by its correlation time.
COEFFICIENTS = ("N", "B", "K", TIME)
_LETTER = {"GM": TIME}
#: Accuracies that a plan makes sense for.
_FINEST, _COARSEST = "0.5 %", "50 %"
#: Sampling intervals that the white noise must last: a decade of cluster times.
_DECADE = 10.0
#: A sample's noise must be at least this part of a step of the converter.
_OF_A_STEP = 0.5
#: Errors that differ by less are the same.
_SAME = 0.2
#: Rate (Hz) where nothing demands one.
_ANY_RATE = 1.0


@dataclass(frozen=True)
class PlannedTerm:
    """One coefficient of one axis.

    ``by_equation`` (s) is the log that Eq. (3.24) asks for at the place of the ``reading``,
    ``error_there`` what the fit attains in it, ``by_fit`` (s) the log in which the fit attains
    the accuracy; infinite where it never does.
    """

    axis: SensorAxis
    name: str
    reading: Reading
    by_equation: float
    error_there: float
    by_fit: float


@dataclass(frozen=True)
class RateReason:
    """A rate (Hz) that a log should have at least, and why."""

    rate: float
    words: str


@dataclass(frozen=True)
class AllanPlan(Found):
    """A test that gives a sensor's coefficients to an accuracy.

    Attributes
    ----------
    sensor : SensorAxes
    error : float
        Relative standard error that is asked for.
    rate : float
        Of the log in Hz; ``reasons`` say what it should be at least.
    terms : tuple of PlannedTerm
    origin : mapping
        Where it comes from.
    """

    sensor: SensorAxes
    error: float
    rate: float
    reasons: tuple[RateReason, ...]
    terms: tuple[PlannedTerm, ...]
    origin: Mapping[str, Any]

    @property
    def length(self) -> float:
        """Length of the log (s): the fit then knows every coefficient so well."""
        return max(term.by_fit for term in self.terms)

    @property
    def table(self) -> pd.DataFrame:
        """A row per axis and coefficient; shares and errors as parts of 1, times in s."""
        import pandas as pd

        return pd.DataFrame(
            {
                "element": [t.axis.element for t in self.terms],
                "axis": [t.axis.axis for t in self.terms],
                "term": [t.name for t in self.terms],
                "coefficient": [coefficient_words(t.axis, t.name) for t in self.terms],
                "read_at_s": [t.reading.tau for t in self.terms],
                "share_there": [t.reading.share for t in self.terms],
                "reading_too_large_by": [t.reading.bias for t in self.terms],
                "length_eq_3_24_s": [t.by_equation for t in self.terms],
                "error_of_fit_there": [t.error_there for t in self.terms],
                "length_for_fit_s": [t.by_fit for t in self.terms],
            }
        )

    @property
    def text(self) -> str:
        """The plan as a terminal shows it."""
        return "\n".join([*columns(self._rows()), "", *self._sentences()])

    def _rows(self) -> list[list[str]]:
        rows = [
            [
                "axis",
                "term",
                "coefficient",
                "read at τ",
                "its share",
                "reads high by",
                "log by Eq. (3.24)",
                "fit's error in it",
                "log for the fit",
            ]
        ]
        return rows + [_row(term) for term in self.terms]

    def _sentences(self) -> list[str]:
        longest = max(self.terms, key=lambda t: t.by_fit)
        if math.isfinite(self.length):
            samples = self.length * self.rate
            first = (
                f"Log {duration_words(self.length)} at {self.rate:.3g} Hz ({samples:.2g} samples): "
                f"the fit then knows every coefficient to {100 * self.error:.3g} % (one standard "
                f"error); {longest.name} of {longest.axis.axis} decides."
            )
        else:
            never = [f"{t.name} of {t.axis.axis}" for t in self.terms if math.isinf(t.by_fit)]
            first = f"No log of 30 years gives {', '.join(never)} to {100 * self.error:.3g} %."
        found = [first, *self._of_the_rate()]
        hidden = [f"{t.name} of {t.axis.axis}" for t in self.terms if t.reading.region is None]
        if hidden:
            found.append(
                f"Hidden: {', '.join(hidden)} nowhere make up enough of the curve to be read off "
                f"to {100 * self.error:.3g} %, however long the log; only a fit of all terms "
                "together tells them apart."
            )
        found += self._of_the_equation()
        return found

    def _of_the_equation(self) -> list[str]:
        """What the fit attains in the logs that Eq. (3.24) asks for."""
        asked = f"{100 * self.error:.3g} %"
        groups = (
            ("promises too much for {} (the fit attains {} instead of {})", 1.0 + _SAME, math.inf),
            ("asks for more than the fit needs for {} ({} instead of {})", 0.0, 1.0 - _SAME),
        )
        said = []
        for words, low, high in groups:
            errors: dict[str, list[float]] = {}
            for t in self.terms:
                if low <= t.error_there / self.error < high:
                    errors.setdefault(t.name, []).append(t.error_there)
            if errors:
                worst = ", ".join(error_words(max(found)) for found in errors.values())
                said.append(words.format(", ".join(errors), worst, asked))
        if not said:
            return []
        return [f"Eq. (3.24) is the error of one point of the curve: it {'; it '.join(said)}."]

    def _of_the_rate(self) -> list[str]:
        missed = [r for r in self.reasons if r.rate > self.rate * (1.0 + 1e-9)]
        said = [
            f"Rate: {'at least' if r not in missed else 'too low, at least'} {r.rate:.3g} Hz "
            f"{r.words}."
            for r in self.reasons
        ]
        return said or ["Rate: any; the sensor's bandwidth and resolution are not known."]

    def report(self) -> Report:
        """Files ``plan`` (table) and ``plan`` (picture of the curves with the regions)."""
        from mcsim.figures.allan_terms import draw_terms
        from mcsim.figures.style import printed

        panels = [
            replace(panel_of(axis), readings=[t.reading for t in self.terms if t.axis == axis])
            for axis in self.sensor.axes
        ]
        title = f"{self.sensor.name}: where each coefficient is read to {100 * self.error:.3g} %"
        return Report(
            provenance=self.origin,
            tables={"plan": self.table},
            pictures=printed(draw_terms(panels, title), "plan"),
        )


def _row(t: PlannedTerm) -> list[str]:
    return [
        f"{SHORT[t.axis.element]} {t.axis.axis}",
        t.name,
        coefficient_words(t.axis, t.name),
        f"{t.reading.tau:.3g} s",
        f"{100 * t.reading.share:.0f} %",
        f"{100 * t.reading.bias:.1f} %" + ("" if t.reading.region else " (hidden)"),
        duration_words(t.by_equation),
        error_words(t.error_there),
        duration_words(t.by_fit),
    ]


def plan(
    sensor: str | Path,
    accuracy: str = "10 %",
    *,
    terms: Sequence[str] | None = None,
    rate: str | None = None,
    element: str | None = None,
    axis: str | None = None,
) -> AllanPlan:
    """Plan a static test: how long and at which rate, for coefficients to an accuracy.

    Eqs. (3.24) and (3.25) of the thesis at the place where each coefficient is read, N at 1 s, B
    where its plateau begins, K where the walk takes over (its line is read at 3 s), Tc at 1.89 Tc;
    beside them what a fit of the whole curve attains.

    Parameters
    ----------
    sensor : path or str
        A sensor file in any dialect, or a built-in sensor.
    accuracy : str
        Relative standard error: ``10 %``.
    terms : sequence of str, optional
        Of ``N``, ``B``, ``K``, ``Tc``; all that the sensor has if absent.
    rate : str, optional
        Of the log, ``100 Hz``; as high as the sensor asks for if absent.
    element, axis : str, optional
        ``accelerometer`` or ``gyroscope``; ``x``, ``y`` or ``z``; all if absent.

    Returns
    -------
    AllanPlan
        ``length`` (s), ``rate`` (Hz), a row per axis and coefficient in ``terms`` and ``table``,
        ``text``, and ``write(folder)``.

    Raises
    ------
    InputError
        No such sensor, element, axis or term, or an accuracy or rate that makes no sense.
    """
    error = between("--accuracy", accuracy, KINDS["ratio"], (_FINEST, _COARSEST), "10 %")
    axes = sensor_axes(sensor, element, axis)
    chosen = _chosen(terms, axes)
    reasons = tuple(_reasons(axes.axes))
    hertz = max((r.rate for r in reasons), default=_ANY_RATE)
    if rate is not None:
        hertz = positive("--rate", rate, KINDS["frequency"])
    planned = [
        _planned(one, name, error, hertz)
        for one in axes.axes
        for name in one.truth.names
        if name in chosen
    ]
    options = {"sensor": axes.name, "accuracy": accuracy, "rate": rate}
    origin = provenance_of("allan plan", [axes.file] if axes.file else [], options)
    return AllanPlan(axes, error, hertz, reasons, tuple(planned), origin)


def _chosen(terms: Sequence[str] | None, axes: SensorAxes) -> Sequence[str]:
    has = {name for axis in axes.axes for name in axis.truth.names}
    for name in terms or ():
        if name not in COEFFICIENTS:
            raise InputError(f'--terms: "{name}" is none of {", ".join(COEFFICIENTS)}')
        if name not in has:
            known = ", ".join(name for name in COEFFICIENTS if name in has)
            raise InputError(f"--terms: {axes.name} has no {name} (it has: {known})")
    return terms or COEFFICIENTS


def _planned(axis: SensorAxis, name: str, error: float, rate: float) -> PlannedTerm:
    term = next(t for t in axis.terms if _LETTER.get(t.letter, t.letter) == name)
    reading = reading_of(term, axis.terms, 1.0 / rate, error)
    by_equation = reading.tau * clusters_needed(error)

    def error_of(length: float) -> float:
        return fit_errors(axis.truth, length, 1.0 / rate)[name]

    return PlannedTerm(
        axis, name, reading, by_equation, error_of(by_equation), length_for(error, error_of, 100.0)
    )


def _reasons(axes: Sequence[SensorAxis]) -> list[RateReason]:
    """What asks for a rate, the most demanding axis of each."""
    found = []
    if bandwidth := max(axis.bandwidth for axis in axes):
        words = (
            f"(twice the bandwidth of {bandwidth:.3g} Hz: below, noise from beyond half the rate "
            "folds down and N is too large)"
        )
        found.append(RateReason(2.0 * bandwidth, words))
    crossings = [crossing_of(axis) for axis in axes if axis.white]
    if (crossing := min(crossings, default=math.inf)) < math.inf:
        words = f"(white noise rules up to {crossing:.3g} s: a decade of clusters to read it from)"
        found.append(RateReason(_DECADE / crossing, words))
    steps = [axis.resolution * _OF_A_STEP / axis.white for axis in axes if axis.white]
    if step := max(steps, default=0.0):
        words = "(a sample's noise is then half a step of the converter, and carries B and K over)"
        found.append(RateReason(step**2, words))
    return found
