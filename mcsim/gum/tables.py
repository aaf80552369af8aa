"""The budget and the comparison as tables, and what the numbers say in words."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from mcsim.gum.budget import Budget
from mcsim.gum.course import SENSOR_TERMS, Course

if TYPE_CHECKING:
    import pandas as pd

BUDGET_COLUMNS = (
    "i",
    "quantity",
    "estimate",
    "uncertainty",
    "equation",
    "sensitivity",
    "variance",
    "printed",
    "ratio",
)
#: What sums and simulation may differ by before the words name it.
_SAME = 0.1


def budget_table(budget: Budget, course: Course) -> pd.DataFrame:
    """Columns ``BUDGET_COLUMNS``: the 26 rows, then totals with their equations.

    Totals hold the combined standard uncertainty; ``ratio`` is variance to printed variance.
    """
    import pandas as pd

    rows: list[tuple[Any, ...]] = [
        (
            row.number,
            row.quantity,
            row.estimate,
            row.uncertainty,
            row.equation,
            row.sensitivity,
            row.variance,
            row.printed if row.printed is not None else math.nan,
            row.variance / row.printed if row.printed is not None else math.nan,
        )
        for row in budget.rows
    ]
    names = {"acx": "(26)", "acz": "(27)", "theta": "(28)", "Dv": "(29)"}
    totals = [
        (f"u({name})", budget.estimates[name], budget.uncertainty(name), equation)
        for name, equation in names.items()
    ]
    end = float(course.truth[-1])
    totals += [
        ("uc(vX,N)", end, float(course.summed_total[-1]), "(30)"),
        ("uc(mean vX,N)", end, float(course.summed_mean[-1]), "(31)"),
    ]
    nothing = math.nan
    rows += [
        (None, name, value, u, equation, nothing, u**2, nothing, nothing)
        for name, value, u, equation in totals
    ]
    table = pd.DataFrame(rows, columns=list(BUDGET_COLUMNS))
    return table.astype({"i": "Int64"})


def comparison_table(course: Course) -> pd.DataFrame:
    """Columns ``time [s], method, of, source, uncertainty [m/s]``; one row per step."""
    import pandas as pd

    frames = [
        pd.DataFrame(
            {
                "time [s]": course.time,
                "method": method,
                "of": of,
                "source": source,
                "uncertainty [m/s]": values,
            }
        )
        for method, of, source, values in _curves(course)
    ]
    return pd.concat(frames, ignore_index=True)


def _curves(course: Course) -> Iterator[tuple[str, str, str, np.ndarray]]:
    run, mean = "one run", f"mean of {course.runs} runs"
    yield "Eq. (30)", run, "all", course.summed_total
    yield "Eq. (31)", mean, "all", course.summed_mean
    yield "Monte Carlo", run, "all", course.total
    yield "Monte Carlo", mean, "all", course.total_mean
    yield "Monte Carlo", "scatter of the runs", "all", course.scatter
    for source, values in course.summed.items():
        yield "Eq. (30)", run, source, values
    for source, values in course.simulated.items():
        yield "Monte Carlo", run, source, values
    interaction = np.sign(course.interaction) * np.sqrt(np.abs(course.interaction))
    yield "Monte Carlo", run, "interaction (signed root of the variance)", interaction


def comparison_words(course: Course) -> str:
    """A paragraph on where summing steps as independent misses, made from the numbers."""
    t, gum, simulated = course.time[-1], course.summed_total[-1], course.total[-1]
    mean, mean_simulated = course.summed_mean[-1], course.total_mean[-1]
    parts = [
        f"After {t:.3g} s Eq. (30) gives u(v) = {gum:.3g} m/s and Monte Carlo "
        f"{simulated:.3g} m/s for one run ({_verdict(gum / simulated)}); for the mean of "
        f"{course.runs} runs Eq. (31) gives {mean:.3g} m/s and Monte Carlo {mean_simulated:.3g} "
        f"m/s ({_verdict(mean / mean_simulated)}).",
        "Source by source, each acting alone:",
    ]
    for source, values in course.summed.items():
        alone = course.simulated[source][-1]
        if max(values[-1], alone) < 1e-3 * simulated:
            continue
        parts.append(
            f"{source} {values[-1]:.2g} m/s by summing, {alone:.2g} m/s simulated"
            f"{_why(source, values[-1] / alone)};"
        )
    calibration = math.hypot(
        *(course.summed[name][-1] for name in ("calibration matrix", "zero bias"))
    )
    left = math.hypot(*(course.simulated[name][-1] for name in ("calibration matrix", "zero bias")))
    parts[-1] = parts[-1].removesuffix(";") + "."
    parts.append(
        "An error that is the same in all steps adds up in proportion to their number, not to "
        "its root, so summing steps as independent understates it. The errors of the "
        "calibration enter the corrected acceleration and the initial tilt alike and cancel: "
        f"together they leave {left:.2g} m/s, where treating acx and θ0 as independent makes "
        f"{calibration:.2g} m/s of them."
    )
    independent, stamps = (
        (course.other_scatter, course.scatter)
        if course.stamps
        else (course.scatter, course.other_scatter)
    )
    parts.append(
        f"Runs of a group scatter by s(v) = {independent[-1]:.2g} m/s where intervals between "
        f"samples err independently, and by {stamps[-1]:.2g} m/s where it is the time stamps that "
        "err, whose errors cancel from one interval to the next."
    )
    if course.sensor_terms:
        parts.append(
            "Eq. (30) and (31) leave out the accelerometer's own terms "
            f"({', '.join(course.sensor_terms)}); Monte Carlo has them, and alone they make "
            f"{course.simulated[SENSOR_TERMS][-1]:.2g} m/s."
        )
    share = abs(course.interaction[-1]) / simulated**2
    parts.append(
        f"The sources acting together differ from the sum of each alone by {share:.1%} of the "
        "variance."
    )
    return "\n".join(textwrap.wrap(" ".join(parts), 100)) + "\n"


def _verdict(ratio: float) -> str:
    if abs(ratio - 1.0) < _SAME:
        return "within 10 %"
    return (
        f"summing understates it {1 / ratio:.2g} times"
        if ratio < 1.0
        else (f"summing overstates it {ratio:.2g} times")
    )


def _why(source: str, ratio: float) -> str:
    if abs(ratio - 1.0) < _SAME:
        return ""
    if source == "noise":
        return " (at rest it averages out over the samples)"
    return " (it cancels)" if ratio > 1.0 else " (it is the same in every step)"
