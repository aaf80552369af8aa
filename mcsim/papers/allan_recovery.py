"""``mcsim table allan-recovery``: Tables 5.4 to 5.6 of the vibration thesis from simulated logs.

N, B and K that the thesis prints make a log of its length; the Allan analysis gives them back.
Beside them stands the error of Eq. (3.24), as the thesis states it and where each term is read.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mcsim import catalogue
from mcsim.papers import Computed, PaperTable, Setting
from mcsim.text_table import columns
from mcsim.units import KINDS, in_unit, parse

if TYPE_CHECKING:
    import pandas as pd

    from mcsim.characterisation.coefficients import Coefficient

Array = NDArray[np.float64]

#: Sensors of the tables, in their order.
SENSORS = ("MTI-300", "MPU-9250", "LSM9DS1", "BNO055", "LSM303DLHC")
AXES, TERMS = ("x", "y", "z"), ("N", "B", "K")
_SOURCE = "thesis-tables-5.4-5.6"
_KEYS = {
    "N": ("velocity_random_walk", "velocity random walk", "m/s/√h"),
    "B": ("bias_instability", "acceleration", "m/s/h"),
    "K": ("acceleration_random_walk", "acceleration random walk", "m/s/h^1.5"),
}
#: The ± columns of the tables, in the tables' units.
PRINTED_ERRORS = {
    "MTI-300": {
        "N": (0.00026, 0.00026, 0.0062),
        "B": (0.0045, 0.0061, 0.0087),
        "K": (0.0128, 0.0049, 0.0262),
    },
    "MPU-9250": {
        "N": (0.0004, 0.0004, 0.0008),
        "B": (0.0141, 0.0139, 0.0134),
        "K": (0.0156, 0.0163, 0.0375),
    },
    "LSM9DS1": {
        "N": (0.00025, 0.00022, 0.0003),
        "B": (0.0055, 0.0053, 0.0073),
        "K": (0.0069, 0.0090, 0.0153),
    },
    "BNO055": {
        "N": (0.00023, 0.00026, 0.00032),
        "B": (0.0025, 0.0093, 0.0126),
        "K": (0.0053, 0.040, 0.0074),
    },
    "LSM303DLHC": {
        "N": (0.0024, 0.0026, 0.0028),
        "B": (0.0084, 0.0135, 0.0157),
        "K": (0.0104, 0.0454, 0.0454),
    },
}
HOURS, RATE = 14, 10
#: The reading's error of the place where a term makes up the curve.
_READ = 0.25
#: Errors that differ by less are the same but for rounding.
_ALIKE = 0.1


@dataclass(frozen=True)
class Recovered:
    """One coefficient of one axis, SI.

    ``printed`` with its error as printed, ``found`` with the fit's interval of 95 %; ``tau`` (s)
    where the term is read, ``error`` that of Eq. (3.24) there, as parts of 1.
    """

    sensor: str
    axis: str
    term: str
    printed: float
    printed_error: float
    found: Coefficient
    tau: float
    error: float

    @property
    def off(self) -> float:
        """Relative error of what was found."""
        return self.found.value / self.printed - 1.0

    @property
    def inside_printed(self) -> bool:
        """Whether the error that the thesis prints holds it."""
        return abs(self.off) <= self.printed_error

    @property
    def inside_equation(self) -> bool:
        """Whether Eq. (3.24) holds it, at the place where the term is read."""
        return abs(self.off) <= self.error

    @property
    def inside_interval(self) -> bool:
        """Whether the fit's own interval holds the truth."""
        return self.found.low <= self.printed <= self.found.high


def printed_coefficients(sensor: str) -> Array:
    """N, B and K (3, 3 axes) of the tables, SI."""
    records = catalogue.find(sensor).records["accelerometer"]
    record = next(r for r in records if r.source == _SOURCE)
    return np.array(
        [
            [parse(text, KINDS[kind]) for text in record.quantities[key]]
            for key, kind, _ in _KEYS.values()
        ]
    )


def static_log(
    white: float, instability: float, walk: float, rate: float, duration: float, seed: int
) -> Array:
    """A log at rest (n,) with N, B and K (SI) at ``rate`` (Hz) over ``duration`` (s)."""
    from mcsim.sensor_terms.bias_instability import flicker
    from mcsim.sensor_terms.mechanisms.process import Process, process_noise, processes_of
    from mcsim.sensor_terms.mechanisms.process import random_walk as walk_of

    rng = np.random.default_rng(seed)
    terms = {
        "B": flicker(instability),
        "K": Process(lambda interval, _: (walk_of(walk, interval),)),
    }
    n = round(rate * duration)
    slow = process_noise(processes_of(terms, 1.0 / rate, duration), rng)(n)
    noise: Array = slow + white * np.sqrt(rate) * rng.standard_normal(n)
    return noise


def recovered(hours: float = HOURS, rate: float = RATE, seed: int = 1) -> Iterator[Recovered]:
    """Simulate a log of every axis of the tables, and fit it."""
    for i, sensor in enumerate(SENSORS):
        for k, truth in enumerate(printed_coefficients(sensor).T):
            yield from _of_axis(sensor, k, truth, (hours, rate, 1000 * seed + 10 * i + k))


def _of_axis(
    sensor: str, k: int, truth: Array, test: tuple[float, float, int]
) -> Iterator[Recovered]:
    """One axis; the test is the length of its log (h), its rate (Hz) and a seed."""
    from mcsim.characterisation import allan_curve, fit_noise
    from mcsim.characterisation.expected_errors import relative_error
    from mcsim.characterisation.noise_terms import flicker, random_walk, white
    from mcsim.characterisation.read_offs import reading_of

    hours, rate, seed = test
    duration = 3600.0 * hours
    n, b, walk = truth.tolist()
    log = static_log(n, b, walk, rate, duration, seed)
    fit = fit_noise(allan_curve(log, rate), (0.0, duration), intervals="covariance")
    terms = [white(n), flicker(b), random_walk(walk)]
    for term in terms:
        name, value = term.letter, term.coefficient
        error = PRINTED_ERRORS[sensor][name][k] / _in_unit(value, name)
        tau = reading_of(term, terms, 1.0 / rate, _READ).tau
        yield Recovered(
            sensor,
            AXES[k],
            name,
            value,
            error,
            fit[name],
            tau,
            relative_error(duration / tau),
        )


def _in_unit(value: float, term: str) -> float:
    _, kind, unit = _KEYS[term]
    return in_unit(value, unit, KINDS[kind])


def allan_recovery(hours: int, rate: int, seed: int) -> Computed:
    """The table: printed, recovered, and what Eq. (3.24) promises."""
    entries = list(recovered(hours, rate, seed))
    text = "\n".join([*columns(_rows(entries)), "", *_sentences(entries, hours, rate)])
    return Computed({"allan-recovery": _frame(entries)}, text)


def _rows(entries: Sequence[Recovered]) -> list[list[str]]:
    rows = [
        [
            "sensor",
            "term",
            "printed",
            "± printed",
            "recovered",
            "off by",
            "inside ±?",
            "read at τ",
            "± (3.24)",
            "inside?",
            "in the fit's 95 %?",
        ]
    ]
    for e in entries:
        unit = _KEYS[e.term][2]
        rows.append(
            [
                f"{e.sensor} {e.axis}",
                e.term,
                f"{_in_unit(e.printed, e.term):.5g} {unit}",
                f"{100 * e.printed_error:.2f} %",
                f"{_in_unit(e.found.value, e.term):.4g}",
                f"{100 * e.off:+.2f} %",
                _yes(e.inside_printed),
                f"{e.tau:.3g} s",
                f"{100 * e.error:.2g} %" if math.isfinite(e.error) else "log too short",
                _yes(e.inside_equation) if math.isfinite(e.error) else "–",
                _yes(e.inside_interval),
            ]
        )
    return rows


def _yes(value: bool) -> str:
    return "yes" if value else "no"


def _sentences(entries: Sequence[Recovered], hours: float, rate: float) -> list[str]:
    from mcsim.characterisation.expected_errors import relative_error

    at_one = relative_error(3600.0 * hours)
    slow = [e for e in entries if e.term != "N"]
    said = [
        f"Logs of {hours:g} h at {rate:g} Hz with the printed N, B and K, one per axis, fitted by "
        "mcsim.characterisation.",
        f"Eq. (3.24) at τ = 1 s, where N is read, gives {100 * at_one:.2g} %: so (within a tenth) "
        f"are {_share(abs(e.printed_error / at_one - 1.0) < _ALIKE for e in entries)} printed "
        f"errors, {_share(abs(e.printed_error / at_one - 1.0) < _ALIKE for e in slow)} of B and K.",
    ]
    for term in TERMS:
        own = [e for e in entries if e.term == term]
        worst = max(abs(e.off) for e in own)
        said.append(
            f"{term}: {_share(e.inside_printed for e in own)} inside the printed ±, "
            f"{_share(e.inside_equation for e in own if math.isfinite(e.error))} inside "
            "Eq. (3.24) where it is read, "
            f"{_share(e.inside_interval for e in own)} inside the fit's 95 %; off by up to "
            f"{100 * worst:.2g} %."
        )
    said.append(
        "One standard error holds two thirds. Read at τ: where the term's share of the Allan "
        "variance is enough for a reading within 25 %, or is largest."
    )
    return [*said, *_nine_clusters()]


def _share(flags: Iterable[bool]) -> str:
    found = list(flags)
    return f"{sum(found)} of {len(found)}"


def _nine_clusters() -> list[str]:
    """Eq. (3.25) beside the degrees of freedom of the estimates (Greenhall and Riley 2003)."""
    from mcsim.characterisation.expected_errors import clusters_needed, relative_error
    from mcsim.characterisation.freedom import degrees_of_freedom

    m, nine = 100, clusters_needed(0.25)

    def error(alpha: int, overlapping: bool) -> float:
        n = round(nine) * m + 1
        freedom = degrees_of_freedom(alpha, 2, m, n, modified=False, overlapping=overlapping)
        return 1.0 / math.sqrt(2.0 * freedom)

    noises = (("white noise", 0), ("flicker", -1), ("random walk", -2))
    words = ", ".join(
        f"{name} {100 * error(a, True):.0f} % ({100 * error(a, False):.0f} %)" for name, a in noises
    )
    return [
        f"Nine clusters: Eq. (3.24) gives {100 * relative_error(nine):.0f} %; by the degrees of "
        f"freedom of overlapping (separate) clusters: {words}."
    ]


def _frame(entries: Sequence[Recovered]) -> pd.DataFrame:
    """One row per coefficient, in the thesis' units; errors as parts of 1."""
    import pandas as pd

    return pd.DataFrame(
        {
            "sensor": [e.sensor for e in entries],
            "axis": [e.axis for e in entries],
            "term": [e.term for e in entries],
            "unit": [_KEYS[e.term][2] for e in entries],
            "printed": [_in_unit(e.printed, e.term) for e in entries],
            "printed_error": [e.printed_error for e in entries],
            "recovered": [_in_unit(e.found.value, e.term) for e in entries],
            "off_by": [e.off for e in entries],
            "inside_printed_error": [e.inside_printed for e in entries],
            "read_at_s": [e.tau for e in entries],
            "eq_3_24_error": [e.error for e in entries],
            "inside_eq_3_24": [e.inside_equation for e in entries],
            "ci_low": [_in_unit(e.found.low, e.term) for e in entries],
            "ci_high": [_in_unit(e.found.high, e.term) for e in entries],
            "inside_ci": [e.inside_interval for e in entries],
        }
    )


TABLE = PaperTable(
    "allan-recovery",
    "N, B and K (Tables 5.4 to 5.6) recovered from simulated logs, beside Eq. (3.24).",
    allan_recovery,
    files=("allan-recovery",),
    settings=(
        Setting("hours", HOURS, "Length of the logs.", least=1),
        Setting("rate", RATE, "Of the logs in Hz.", least=1),
        Setting("seed", 1, least=0),
    ),
)
