"""What measured runs tell, in words made from their numbers."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator

import numpy as np

from mcsim.gum import Course
from mcsim.gum.words import comparison_words
from mcsim.measured_velocity.measurement import Measurement
from mcsim.measured_velocity.reference import Reference

#: Shares of a normal distribution within one and 1.96 standard deviations.
_ONE, _TWO, _FACTOR = 0.683, 0.95, 1.959963984540054
#: Coverage that misses by more than this is worth a word.
_OFF = 0.05


def measured_words(found: Measurement, course: Course, reference: Reference | None) -> str:
    """The velocity, what its uncertainties are worth, and how it meets the reference."""
    first = [*_result(found), *_coverage(found), *_reference(found, reference)]
    return "\n".join([*textwrap.wrap(" ".join(first), 100), "", comparison_words(course)])


def _result(found: Measurement) -> Iterator[str]:
    group, mean = found.group, found.mean
    at = int(np.argmax(np.abs(mean)))
    what = f"mean of {group.runs} runs" if group.runs > 1 else "one run"
    equation = "Eq. (31)" if group.runs > 1 else "Eq. (30)"
    for where, i in (("largest", at), ("end", -1)):
        yield (
            f"{'At its largest' if where == 'largest' else 'At the end'}, "
            f"{group.time[i]:.3g} s after the start, the velocity ({what}) is {mean[i]:.4g} m/s, "
            f"uc = {found.summed[i]:.2g} m/s by {equation} and {found.drawn.mean[i]:.2g} m/s by "
            f"Monte Carlo, whose 95 % lie between {found.drawn.low[i]:.4g} and "
            f"{found.drawn.high[i]:.4g} m/s."
        )


def _coverage(found: Measurement) -> Iterator[str]:
    """What ± uc of the equations would hold, if the distribution is that of Monte Carlo."""
    many = found.group.runs > 1
    pairs = [("Eq. (30) of one run", found.sums.single[:, -1], found.drawn.single[:, -1])]
    if many:
        pairs.append(("Eq. (31) of the mean", found.sums.mean[-1:], found.drawn.mean[-1:]))
    told = []
    for name, stated, real in pairs:
        ratio = float(np.sqrt(np.mean(stated**2) / max(np.mean(real**2), 1e-300)))
        if abs(_share(ratio) - _ONE) > _OFF:
            told.append(
                f"± uc by {name} holds {_share(ratio):.0%} (not {_ONE:.0%}) of what Monte Carlo "
                f"says, ± 1.96 uc {_share(_FACTOR * ratio):.0%} (not {_TWO:.0%})"
            )
    if told:
        yield (
            "The equations sum steps as if independent, while calibration, tilt and gravity err "
            f"alike in all of them: at the end {'; '.join(told)}."
        )


def _share(deviations: float) -> float:
    return math.erf(deviations / math.sqrt(2.0))


def _reference(found: Measurement, reference: Reference | None) -> Iterator[str]:
    given = found.reference
    if reference is None or given is None:
        return
    error = found.mean - given
    at = int(np.argmax(np.abs(error)))
    yield (
        f"Against the reference the error is {error[-1]:.2g} m/s at the end and at most "
        f"{error[at]:.2g} m/s, at {found.group.time[at]:.3g} s."
    )
    if found.group.reference is not None and found.group.runs > 1:
        single = found.runs[:, -1] - found.group.reference[:, -1]
        worst = float(np.max(np.abs(single)))
        better = f", {1.0 - abs(error[-1]) / worst:.0%} less in the mean" if worst > 0.0 else ""
        yield f"The worst run errs at the end by {worst:.2g} m/s{better}."
    moving = slice(1, None)
    u = np.hypot(found.drawn.mean, reference.deviation(given))
    inside = float(np.mean(np.abs(error[moving]) <= _FACTOR * u[moving]))
    yield f"It lies within 1.96 u of Monte Carlo, with the reference's own, at {inside:.0%} of " + (
        "the instants."
        if reference.uncertainty or reference.relative
        else "the instants; the reference counts as exact (--reference-uncertainty)."
    )
