"""``mcsim table attitude-drift``: Table 1 of the application note with a gyroscope behind it.

The note's tilt is constant.  A tilt that a gyroscope's bias makes grows with time, one of its angle
random walk with the root of it, and one from levelling cancels the accelerometer's offset until
the vehicle turns.  Each stands in closed form, simulated by the strapdown case, and on the round
earth, where Schuler's pendulum bounds it (``mcsim.simulation.attitude_drift``).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mcsim.papers import Computed, PaperFigure, PaperTable, Setting
from mcsim.papers.attitude_sources import TIMES, sources
from mcsim.papers.shipped import shipped_scenarios
from mcsim.simulation.attitude_drift import (
    STATED,
    TILT,
    TURN_RATE,
    Drift,
    Source,
    lasts,
)
from mcsim.text_table import columns

if TYPE_CHECKING:
    import pandas as pd

    from mcsim.scenario_file import Scenario

#: What a simulated value comes from, and the least samples of a run.
REALIZATIONS, _SAMPLES = 1000, 2000
_CONFIDENCE = "95 %"
#: Turning round takes this share of a run; a track's leads bound how long that may be (s).
_TURN, _LONGEST_LEAD = 0.03, 60.0
#: Rate at which a turn is sampled at least (Hz), so that its signals need no dense truth of hours.
_RATE_OF_TURNS = 20.0
_NAME = "attitude-drift"
_SCENARIO = "attitude_drift"
#: Smaller positions (m) are rounding.
_ROUNDING = 1e-9
_HEADER = ["of", "", "tilt by then", "printed", "flat", "simulated", "round earth", "note"]
_CONCLUSION = """\
printed: the note's, g θ t², twice what its own recursion gives (`mcsim table gravity-leakage`);
flat: closed form in the level frame, g θ t²/2, g b t³/6, g N √(t⁵/20), N two-sided; simulated: RMS
of {count:,} vehicles of the strapdown case, in the same frame, whose tilt, bias or walk has that
standard deviation; round earth: the same on a sphere, where what moves by mistake takes its
vertical along (Schuler, {period:.1f} min). Flat errors of a constant tilt are {share:.0%} too
large after {tilt:.1f} min, of a bias after {bias:.1f} min. Earth's rate: a gyroscope that is not
told of it, and has not taken it for part of its bias at rest, reads it as a bias on the axis that
points north; a bias below it is worth nothing then. No column has the coupling of both axes by the
earth's rate, which turns by {coupling:.1f}° within an hour."""


def drifts(bias: str = "", noise: str = "", seed: int = 1) -> Iterator[Drift]:
    """All sources at all times; each entry takes a moment to simulate."""
    scenario = _scenario()
    for source in sources(bias, noise):
        for time in TIMES:
            printed = source.printed.get(time, math.nan)
            yield Drift(source, time, printed, *_simulated(scenario, source, time, seed))


def _scenario() -> Scenario:
    from mcsim.scenario_file import Scenario

    return Scenario.from_yaml(shipped_scenarios() / "strapdown" / f"{_SCENARIO}.yaml")


def _simulated(
    scenario: Scenario, source: Source, time: float, seed: int
) -> tuple[float, float, float]:
    """RMS of the error along with its interval, where a track can be as long as that."""
    from mcsim.api.run import run

    if source.turned and (1.0 - _TURN) * time > 2.0 * _LONGEST_LEAD:
        return math.nan, math.nan, math.nan
    values = {
        "sensors.gyroscope": {"noise_density": "0 °/s/√Hz"},
        "monte_carlo": {
            "realizations": REALIZATIONS,
            "seed": seed,
            "confidence": _CONFIDENCE,
            "offsets": "sobol",
            "resamples": 200,
        },
    }
    drive = _turning(time) if source.turned else _straight(time)
    table = run(scenario.with_values({**values, **drive, **source.written}), jobs=1).table
    row = table[(table["error"] == "along") & (table["statistic"] == "rms")].iloc[0]
    return float(row["value"]), float(row["ci_low"]), float(row["ci_high"])


def _straight(time: float) -> dict[str, object]:
    return {"trajectory.length": f"{time:g} m", "sensors.rate": f"{_SAMPLES / time:.12g} Hz"}


def _turning(time: float) -> dict[str, object]:
    """Straight on, round by 180° half-way, straight back; means over intervals hold the turn."""
    turn = _TURN * time
    return {
        "trajectory": {
            "shape": "curve",
            "radius": f"{turn / math.pi:.12g} m",
            "angle": "180 °",
            "speed": "1 m/s",
            "lead": f"{0.5 * (time - turn):.12g} s",
        },
        "sensors.rate": f"{max(_RATE_OF_TURNS, _SAMPLES / time):.12g} Hz",
        "sensors.sampling": "average",
    }


def drift_table(bias: str, noise: str, seed: int) -> Computed:
    """The table: printed, in closed form, simulated, on the round earth."""
    entries = list(drifts(bias, noise, seed))
    return Computed({_NAME: frame(entries)}, _text(entries))


def _text(entries: Sequence[Drift]) -> str:
    from mcsim.simulation.attitude_drift import EARTH_RATE, SCHULER_PERIOD

    blocks = []
    for time in TIMES:
        rows = [_HEADER, *(_cells(entry) for entry in entries if entry.time == time)]
        blocks.append("\n".join([f"position error after {_spoken(time)} [m]", *columns(rows)]))
    conclusion = _CONCLUSION.format(
        count=REALIZATIONS,
        share=STATED,
        period=SCHULER_PERIOD / 60.0,
        tilt=lasts(TILT, STATED) / 60.0,
        bias=lasts(TURN_RATE, STATED) / 60.0,
        coupling=math.degrees(EARTH_RATE) * 3600.0,
    )
    return "\n\n".join([*blocks, conclusion])


def _spoken(time: float) -> str:
    if time < 60.0:
        return f"{time:g} s"
    return f"{time / 60.0:g} min" if time < 3600.0 else f"{time / 3600.0:g} h"


def _cells(entry: Drift) -> list[str]:
    numbers = (entry.printed, entry.flat, entry.simulated, entry.round_earth)
    tilt = f"{math.degrees(entry.tilt):.3g}°"
    return [entry.source.group, entry.source.name, tilt, *map(_plain, numbers), entry.note]


def _plain(number: float) -> str:
    """Three significant digits, without an exponent where they can be read so; – for none."""
    if math.isnan(number):
        return "–"
    if number < _ROUNDING:
        return "0"
    rounded = float(f"{number:.3g}")
    return f"{rounded:,.0f}" if rounded >= 1000.0 else f"{rounded:g}"


def frame(entries: Sequence[Drift]) -> pd.DataFrame:
    """One row per entry; tilts in degrees, positions in m."""
    import pandas as pd

    return pd.DataFrame(
        {
            "group": [e.source.group for e in entries],
            "source": [e.source.name for e in entries],
            "time [s]": [e.time for e in entries],
            "tilt [deg]": [math.degrees(e.tilt) for e in entries],
            "printed [m]": [e.printed for e in entries],
            "flat [m]": [e.flat for e in entries],
            "simulated [m]": [e.simulated for e in entries],
            "ci_low [m]": [e.low for e in entries],
            "ci_high [m]": [e.high for e in entries],
            "round earth [m]": [e.round_earth for e in entries],
            "note": [e.note for e in entries],
        }
    )


def _make(folder: Path) -> list[Path]:
    """The figure, and the table that its markers are of."""
    from mcsim.figures.attitude_drift import draw_drifts
    from mcsim.figures.style import printed
    from mcsim.provenance import provenance_of
    from mcsim.report import Report

    entries = list(drifts())
    Report(
        provenance=provenance_of(
            f"figures {_NAME}", [shipped_scenarios() / "strapdown" / f"{_SCENARIO}.yaml"]
        ),
        tables={"table": frame(entries)},
        pictures=printed(draw_drifts(entries), "figure"),
    ).write(folder)
    return [folder / "figure.png"]


TABLE = PaperTable(
    _NAME,
    "Table 1 of the application note with a gyroscope behind it: flat, simulated, round earth.",
    drift_table,
    files=(_NAME,),
    settings=(
        Setting("bias", "", "A gyroscope's bias of your own, beside the grades.", metavar="20 °/h"),
        Setting(
            "noise",
            "",
            "Its angle random walk or noise density.",
            metavar="0.3 °/√h",
        ),
        Setting("seed", 1, least=0),
    ),
)
FIGURE = PaperFigure(_NAME, make=_make, folder=_SCENARIO)
