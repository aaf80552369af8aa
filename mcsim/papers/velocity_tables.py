"""``mcsim table velocity``: Tables 2 to 4 of the velocity paper."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcsim.papers import Computed, PaperTable
from mcsim.papers.shipped import VELOCITY_SENSORS, velocity_sensor
from mcsim.text_table import frame_text

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: Groups of runs simulated for Table 2, and the shares of them between which 95 % lie.
GROUPS, _ENDS = 2000, (2.5, 50.0, 97.5)
#: Top speeds that agree with Table 2; the one of the run is not printed.
_TOP_SPEEDS = ("0.3 m/s", "0.4 m/s", "0.5 m/s")
_RUNS = 12


class Printed(NamedTuple):
    """Table 2 after 1.5 s (m/s), and half a unit of each last digit.

    Largest error of twelve runs and error of their mean (both measured once, against a wheel
    encoder), uc of the mean, s(v) of the twelve.
    """

    largest: float
    of_mean: float
    uc: float
    scatter: float

    @property
    def largest_possible(self) -> tuple[float, float]:
        """The largest error that any twelve runs of this mean and scatter have: as printed, and
        where all three are rounded towards it.

        No value lies further than ``s (M - 1) / sqrt(M)`` from the mean of M (Thompson, 1935).
        """
        reach = (_RUNS - 1) / math.sqrt(_RUNS)
        as_printed = abs(self.of_mean) + self.scatter * reach
        return as_printed, as_printed + 0.005 + 0.0005 * reach


_TABLE_2 = {
    "a1": Printed(0.04, -0.01, 0.02, 0.006),
    "a2": Printed(0.06, 0.01, 0.04, 0.009),
}


class Row(NamedTuple):
    """A quantity (m/s) as printed and as computed, over groups where it is measured."""

    quantity: str
    printed: float
    median: float
    expected: float
    low: float
    high: float
    below: float
    """Share of groups (%) whose value is below the printed one."""
    kind: str


_COLUMNS = [
    *("sensor", "top speed", "quantity [m/s]", "printed", "computed", "expected"),
    *("2.5 % of groups", "97.5 % of groups", "groups below printed [%]", "kind"),
]


def velocity_tables() -> Computed:
    """Tables 2, 3 and 4, printed and computed."""
    from mcsim.gum import course_of_uncertainty, step_budget
    from mcsim.gum.tables import budget_table

    tables: dict[str, pd.DataFrame] = {"table2": table_2()}
    for name, number in zip(VELOCITY_SENSORS, (3, 4), strict=True):
        _, model = velocity_sensor(name)
        tables[f"table{number}"] = budget_table(step_budget(model), course_of_uncertainty(model))
    texts = [f"{name}\n{frame_text(table)}\n" for name, table in tables.items()]
    texts.insert(1, f"{words_of_table_2(tables['table2'])}\n")
    return Computed(tables, "\n".join(texts))


def table_2() -> pd.DataFrame:
    """Table 2 after 1.5 s: printed values beside ours, for the top speeds that agree with it.

    What the source measured on one group of twelve runs stands beside the simulated distribution
    of the same quantity over groups: its median and mean, the ends between which 95 % of the
    groups lie, and the share of groups below the printed value.  What the source computed, uc,
    stands beside the same equation.  The error that sampling and integration alone make, which
    nobody measured, has a row of its own, and so has the largest error that the other printed
    values allow.
    """
    import pandas as pd

    rows: list[tuple[Any, ...]] = []
    for name in VELOCITY_SENSORS:
        for speed in _TOP_SPEEDS:
            rows += [(name.upper(), speed, *row) for row in rows_of_table_2(name, speed)]
        rows.append((name.upper(), "any", *_possible(_TABLE_2[name])))
    return pd.DataFrame(rows, columns=_COLUMNS)


def rows_of_table_2(name: str, speed: str) -> Iterator[Row]:
    """The rows of a sensor at one top speed."""
    from mcsim.engine import point_key
    from mcsim.gum import course_of_uncertainty
    from mcsim.systems.velocity.problem import VelocityProblem

    printed = _TABLE_2[name]
    for label, errors in (("time stamps err", "stamps"), ("intervals err", "independent")):
        _, model = velocity_sensor(name, trajectory__top_speed=speed, sensor__time_errors=errors)
        problem = VelocityProblem.from_model(model)
        runs = problem.velocities(point_key(model.monte_carlo, ()), 0, GROUPS)[-1]
        yield from _measured(runs - problem.truth[-1], printed, label)
    uc = float(course_of_uncertainty(model).summed_mean[-1])
    method = float(problem.method_errors()[-3])
    yield _computed("uc of the mean, Eq. (31)", printed.uc, uc, "computed | computed")
    yield _computed("error of the method", math.nan, method, "– | computed, no sensor error")


def _measured(errors: Array, printed: Printed, label: str) -> Iterator[Row]:
    """What the source measured once, beside its distribution; errors (runs, groups)."""
    mean = errors.mean(axis=0)
    for quantity, value, values in (
        ("largest |error|", printed.largest, np.abs(errors).max(axis=0)),
        ("error of the mean", printed.of_mean, mean),
        ("|error of the mean|", abs(printed.of_mean), np.abs(mean)),
        ("s(v)", printed.scatter, errors.std(axis=0, ddof=1)),
    ):
        low, median, high = np.percentile(values, _ENDS)
        below = 100.0 * float(np.mean(values < value))
        yield Row(
            f"{quantity} of {len(errors)} runs, {label}",
            *(value, median, float(values.mean()), low, high, below),
            "measured once | simulated, median",
        )


def _possible(printed: Printed) -> Row:
    as_printed, rounded = printed.largest_possible
    return Row(
        "largest |error| that the printed mean and s(v) allow",
        *(printed.largest, as_printed, math.nan, math.nan, rounded, math.nan),
        "measured once | bound as printed, and by rounding",
    )


def _computed(quantity: str, printed: float, value: float, kind: str) -> Row:
    return Row(quantity, printed, value, math.nan, math.nan, math.nan, math.nan, kind)


def words_of_table_2(table: pd.DataFrame) -> str:
    """What depends on the top speed, and whether the printed values can be of one group."""
    told = []
    for name in VELOCITY_SENSORS:
        sensor = name.upper()
        own = table[table["sensor"] == sensor]
        spans = [
            f"{words} {_span(own, quantity)}"
            for words, quantity in (
                ("uc", "uc of the mean, Eq. (31)"),
                ("s(v)", f"s(v) of {_RUNS} runs, time stamps err"),
                ("the largest |error|", f"largest |error| of {_RUNS} runs, time stamps err"),
                ("|error of the mean|", f"|error of the mean| of {_RUNS} runs, time stamps err"),
            )
        ]
        ends = f"{_TOP_SPEEDS[0]} to {_TOP_SPEEDS[-1]}"
        first, second = ", ".join(spans[:2]), ", ".join(spans[2:])
        told.append(f"{sensor}, top speed from {ends}: {first},\n  {second}.")
        told.append(f"  {_words_of_bound(_TABLE_2[name])}")
    return "\n".join(told)


def _span(table: pd.DataFrame, quantity: str) -> str:
    values = table.loc[table["quantity [m/s]"] == quantity, "computed"]
    return f"{values.iloc[0]:.2g} to {values.iloc[-1]:.2g} m/s"


def _words_of_bound(printed: Printed) -> str:
    as_printed, rounded = printed.largest_possible
    said = (
        f"A largest error of {printed.largest:g} beside a mean of {printed.of_mean:g} and s(v) of "
        f"{printed.scatter:g} "
    )
    if printed.largest <= as_printed:
        return f"{said}can be of the same {_RUNS} runs."
    bound = f"({as_printed:.2g} is the most, {rounded:.2g} by rounding)"
    if printed.largest - 0.005 <= rounded:
        return f"{said}can only just be of the same {_RUNS} runs\n  {bound}."
    return f"{said}cannot be of the same {_RUNS} runs at\n  one instant {bound}."


TABLE = PaperTable(
    "velocity",
    "Tables 2, 3 and 4 of the velocity paper, printed and computed.",
    velocity_tables,
    files=("table2", "table3", "table4"),
    folder="velocity-tables",
    output="output",
)
