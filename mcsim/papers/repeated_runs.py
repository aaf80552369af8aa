"""``mcsim table repeated-runs``: what averaging 12 runs of the velocity paper does (V5, V6)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mcsim.papers import Computed, PaperFigure, PaperTable
from mcsim.papers.repetition import (
    TIME_ERRORS,
    Reduction,
    Repeated,
    reductions,
    reductions_of_normals,
    repeated,
    share_with_interval,
)
from mcsim.papers.shipped import VELOCITY_SENSORS, shipped_scenarios
from mcsim.text_table import frame_text

if TYPE_CHECKING:
    import pandas as pd

#: Groups of 12 runs simulated for each row, and the shares of them between which 95 % lie.
GROUPS, _ENDS = 4000, (2.5, 50.0, 97.5)
#: The reduction that the source names, and the one that its Table 2 has: 1 - 0.01 / 0.04 and
#: 1 - 0.01 / 0.06.
LEAST, _PRINTED = 0.75, {"A1": 0.75, "A2": 1.0 - 0.01 / 0.06}
#: Runs of a mean in the table, and in the figure.
_RUNS, _DRAWN_RUNS = (1, 12), (1, 2, 4, 12, 48)
#: Groups, seed, and ratios of shared to own deviation, of the figure's normal errors.
_NORMALS, _SEED, _RATIOS = 100_000, 5, np.geomspace(0.01, 10.0, 25)
#: Deviation of the mean of 12 runs by that of one, where a source averages out.
_OF_12 = 1.0 / math.sqrt(_RUNS[-1])
#: Relative difference of simulated ratios that is their sampling error.
_ALIKE = 0.1
_REST = """\
Noise at rest stays where one rest serves all runs of a group, as here; with a rest before each run,
as the paper's, it averages out as well. Calibration stays and is small: its errors enter the
acceleration and the tilt at rest, and cancel over a run that ends at rest."""
_SAID = {True: "averages out", False: "stays", None: "–"}


def repeated_runs() -> Computed:
    """Both tables, and what they say."""
    found = [r for name in VELOCITY_SENSORS for r in reductions(name, GROUPS)]
    kept = {
        (name.upper(), time_errors): repeated(name, time_errors, _RUNS, GROUPS)
        for name in VELOCITY_SENSORS
        for time_errors in TIME_ERRORS
    }
    tables = {"worst-run": worst_run_table(found), "sources": sources_table(kept)}
    texts = [f"{name}\n{frame_text(table)}\n" for name, table in tables.items()]
    texts += [worst_run_words(found), sources_words(kept)]
    return Computed(tables, "\n".join(texts))


def worst_run_table(found: Sequence[Reduction]) -> pd.DataFrame:
    """How often the mean beats the worst run by the printed reduction, and its distribution."""
    import pandas as pd

    rows = []
    for r in found:
        share, low, high = r.share_above(LEAST)
        quantiles = np.percentile(r.reductions, _ENDS)
        rows.append(
            (
                *(r.sensor, r.sources, r.time_errors, r.shared, r.own),
                *(100.0 * _PRINTED[r.sensor], *(100.0 * quantiles)),
                *(100.0 * share, 100.0 * low, 100.0 * high),
            )
        )
    return pd.DataFrame(
        rows,
        columns=[
            "sensor",
            "errors",
            "time base",
            "shared by the runs [m/s]",
            "each run's own [m/s]",
            "printed reduction [%]",
            "2.5 % of groups [%]",
            "median reduction [%]",
            "97.5 % of groups [%]",
            "groups above 75 % [%]",
            "low [%]",
            "high [%]",
        ],
    )


def worst_run_words(found: Sequence[Reduction]) -> str:
    """The verdict on V5, from the shares."""
    whole = [r.share_above(LEAST)[0] for r in found if r.sources == "all"]
    own = [r.share_above(LEAST)[0] for r in found if r.sources != "all"]
    verdict = "holds in most groups" if min(whole) > 0.5 else "holds in part of the groups"
    if max(whole) < 0.5:
        verdict = "does not hold in most groups"
    return (
        f"V5, the mean's error is more than {LEAST:.0%} below the worst run's: {verdict},\nin "
        f"{min(whole):.0%} to {max(whole):.0%} of them; in {min(own):.0%} to {max(own):.0%} where "
        "runs share no error.\nIt takes runs that differ by more than what they share."
    )


def sources_table(kept: Mapping[tuple[str, str], Sequence[Repeated]]) -> pd.DataFrame:
    """Each source's uncertainty: of one run, of the mean of 12, of endlessly many."""
    import pandas as pd

    rows = []
    for (sensor, time_errors), sources in kept.items():
        for s in sources:
            (one, mean), (one_drawn, mean_drawn) = s.linear, s.simulated
            rows.append(
                (
                    *(sensor, time_errors, s.source, _SAID[s.averages_out]),
                    *(one, one_drawn, mean, mean_drawn, s.lasting),
                    *(_ratio(mean, one), _ratio(mean_drawn, one_drawn)),
                )
            )
    return pd.DataFrame(
        rows,
        columns=[
            "sensor",
            "time base",
            "source",
            "printed",
            "one run, linear [m/s]",
            "one run, simulated [m/s]",
            "mean of 12, linear [m/s]",
            "mean of 12, simulated [m/s]",
            "mean of all, linear [m/s]",
            "12 to 1, linear",
            "12 to 1, simulated",
        ],
    )


def _ratio(mean: float, one: float) -> float:
    return mean / one if one > 0.0 else math.nan


def sources_words(kept: Mapping[tuple[str, str], Sequence[Repeated]]) -> str:
    """The verdict on V6, source by source, from the simulated ratios."""
    every = [s for sources in kept.values() for s in sources]
    told = []
    for averages, fate, words in ((True, _OF_12, "average out"), (False, 1.0, "stay")):
        said = list(dict.fromkeys(s.source for s in every if s.averages_out is averages))
        off = {s.source for s in every if s.averages_out is averages and not _has_fate(s, fate)}
        do = [source for source in said if source not in off]
        told.append(f"{_listed(do)} {words} as the paper says")
        if off:
            told.append(f"{_listed(sorted(off))} does not")
    return "V6: " + ";\n".join(told) + f".\n{_REST}"


def _has_fate(s: Repeated, fate: float) -> bool:
    return abs(_ratio(s.simulated[-1], s.simulated[0]) / fate - 1.0) < _ALIKE


def _listed(names: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]])) or "none"


def _figure(folder: Path) -> list[Path]:
    """u over the number of runs by source, and V5 over what runs share."""
    import pandas as pd

    from mcsim.figures.repetition import Marked, draw_repetition
    from mcsim.figures.style import printed
    from mcsim.provenance import provenance_of
    from mcsim.report import Report

    time_errors = "time stamps err"
    kept = {
        name.upper(): repeated(name, time_errors, _DRAWN_RUNS, GROUPS // 2)
        for name in VELOCITY_SENSORS
    }
    shares = [
        share_with_interval(
            int(np.sum(reductions_of_normals(ratio, 12, _NORMALS, _SEED) > LEAST)), _NORMALS
        )[0]
        for ratio in _RATIOS
    ]
    found = [r for name in VELOCITY_SENSORS for r in reductions(name, GROUPS)]
    marks = [
        Marked(f"{r.sensor}, {r.time_errors}", r.shared / r.own, *r.share_above(LEAST))
        for r in found
        if r.sources == "all"
    ]
    figure = draw_repetition(
        {
            name: {s.source: (s.linear, s.simulated) for s in sources if s.source != "gravity"}
            for name, sources in kept.items()
        },
        np.array(_DRAWN_RUNS),
        (_RATIOS, np.array(shares)),
        marks,
        "What repetition averages out: velocity after 1.5 s, time stamps err",
    )
    table = pd.DataFrame(
        [
            (name, s.source, int(m), float(linear), float(drawn))
            for name, sources in kept.items()
            for s in sources
            for m, linear, drawn in zip(s.runs, s.linear, s.simulated, strict=True)
        ],
        columns=["sensor", "source", "runs", "linear [m/s]", "simulated [m/s]"],
    )
    files = [shipped_scenarios() / "velocity" / f"{name}.yaml" for name in VELOCITY_SENSORS]
    Report(
        provenance=provenance_of("figures repeated-runs", files),
        tables={"table": table},
        pictures=printed(figure, "figure"),
    ).write(folder)
    return [folder / "figure.png"]


FIGURE = PaperFigure("repeated-runs", make=_figure, folder="repeated-runs")
TABLE = PaperTable(
    "repeated-runs",
    "How averaging repeated runs helps: against the worst run, and source by source.",
    repeated_runs,
    files=("worst-run", "sources"),
    folder="repeated-runs-tables",
    output="output",
)
