"""``mcsim table stationary``: Tables 5.1 and 5.2 of the vibration thesis whole.

Extremes, peak to peak, deviation, static bias and ratio to the reference; densities, rates and
the noise in the whole band.  Beside them stands what follows from other printed values, and what
a simulated log of normal noise shows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mcsim import catalogue
from mcsim.api.bounded import between
from mcsim.papers import Computed, PaperTable, Setting
from mcsim.papers.sensor_logs import MICRO_G, SENSORS, printed, simulated_log
from mcsim.text_table import columns
from mcsim.units import KINDS, parse

if TYPE_CHECKING:
    import pandas as pd

    from mcsim.papers.sensor_logs import Printed

#: Table 5.1: least and largest value, peak to peak (m/s²) of each axis, static bias (m/s²) and the
#: ratio of z to the reference, as printed.
TABLE_5_1: dict[str, dict[str, tuple[float, ...]]] = {
    "MTN-1100": {"min": (-0.7358,), "max": (0.5559,), "p2p": (1.4017,), "bias": (0.0,)},
    "MTI-300": {
        "min": (-0.0460, -0.0437, -0.0525), "max": (0.0461, 0.0537, 0.0426),
        "p2p": (0.0921, 0.0974, 0.0951), "bias": (-0.0537, 0.0631, 9.8230), "ratio": (116.0,),
    },
    "MPU-9250": {
        "min": (-0.0784, -0.0899, -0.1265), "max": (0.0709, 0.0722, 0.1199),
        "p2p": (0.1494, 0.1621, 0.2464), "bias": (0.0515, 0.0472, 9.9171), "ratio": (318.0,),
    },
    "LSM9DS1": {
        "min": (-0.1516, -0.1540, -0.1985), "max": (0.1539, 0.1394, 0.1797),
        "p2p": (0.3056, 0.2934, 0.3782), "bias": (-0.2064, -0.1918, 9.9118), "ratio": (383.0,),
    },
    "BNO055": {
        "min": (-0.0273, -0.0460, -0.0464), "max": (0.0327, 0.0440, 0.0436),
        "p2p": (0.0600, 0.0900, 0.0900), "bias": (0.0173, -0.2740, 9.7664), "ratio": (140.0,),
    },
    "LSM303DLHC": {
        "min": (-15.30, -1.70, -16.50), "max": (1.90, 1.80, 2.0), "p2p": (17.20, 3.50, 18.50),
        "bias": (0.0, 0.0, 9.90), "ratio": (3000.0,),
    },
}  # fmt: skip
#: Table 5.2: the noise in the whole band (µg).
TOTAL_NOISE = {
    "MTN-1100": 8033.7, "MTI-300": 1719.6, "MPU-9250": 6434.2, "LSM9DS1": 4241.7,
    "BNO055": 1185.8, "LSM303DLHC": 5703.0,
}  # fmt: skip
#: Columns on the terminal, after sensor and axis; "sim." is simulated, the rest printed.
_HEADS_5_1 = (
    "min", "sim.", "max", "sim.", "p-p", "max-min", "sim.", "σ", "sim.", "bias", "ratio",
    "of σ", "extreme/σ", "normal",
)  # fmt: skip
_HEADS_5_2 = (
    "data sheet", "measured", "σ/√f_3dB", "rate: sheet", "measured", "f_3dB [Hz]", "noise",
    "of sheet", "of measured",
)  # fmt: skip
#: Printed values that are sums or products of others agree to so many of their digits' units.
_ROUNDING, _AGREES = 2e-4, 0.02
#: Densities that follow from deviations of two or three digits agree to this.
_DENSITY_AGREES = 0.05
#: A normal log's largest value is not as far out as this (deviations), whatever its length.
_NOT_NORMAL = 7.0
_WORDS = """\
sim.: simulated. max-min: of the printed extremes; ratio: to the reference on z, printed and that of
the printed σ. extreme/σ: the larger printed extreme in printed σ; normal: that of as many normal
samples (median). noise: in the whole band, printed, and density times √f_3dB, of the data sheet's
and of the measured density."""

_UNPRINTED = """\
  MTN-1100: its data-sheet density, rate and f_3dB are not printed; assumed are 100 Hz, the square
  of its noise over its density, and twice that as rate"""


def stationary_data(duration: str, seed: int) -> Computed:
    """Both tables, printed beside what follows and what is simulated."""
    seconds = between("--duration", duration, KINDS["time"], ("1 s", "1 h"), "20 s")
    sources = [printed(name) for name in SENSORS]
    extremes, noise = _extremes(sources, seconds, seed), _noise(sources)
    text = "\n".join(
        [
            f"Table 5.1, m/s²; logs of {seconds:g} s with the measured densities of Table 5.2",
            *columns(_rows(extremes, _HEADS_5_1)),
            "",
            "Table 5.2, densities in µg/√Hz, noise in µg",
            *columns(_rows(noise, _HEADS_5_2)),
            "",
            *_WORDS.splitlines(),
            "",
            "where the printed values cannot all hold:",
            *(f"  {remark}" for remark in remarks(extremes, noise)),
            *_UNPRINTED.splitlines(),
        ]
    )
    return Computed({"stationary": extremes, "noise": noise}, text, ("stationary", "noise"))


def _extremes(sources: Sequence[Printed], duration: float, seed: int) -> pd.DataFrame:
    import pandas as pd

    reference = float(sources[0].deviation[-1])
    rows: list[dict[str, Any]] = []
    for source in sources:
        log, table = simulated_log(source, "density", duration, seed), TABLE_5_1[source.name]
        for i, axis in enumerate(source.axes):
            low, high, spread = (table[key][i] for key in ("min", "max", "p2p"))
            deviation = float(source.deviation[i])
            ratio = "ratio" in table and axis == "z"
            rows.append(
                {
                    "sensor": source.name,
                    "axis": axis,
                    "min printed": low,
                    "min simulated": log[:, i].min(),
                    "max printed": high,
                    "max simulated": log[:, i].max(),
                    "peak to peak printed": spread,
                    "from extremes": high - low,
                    "peak to peak simulated": np.ptp(log[:, i]),
                    "std printed": deviation,
                    "std simulated": log[:, i].std(),
                    "static bias printed": table["bias"][i],
                    "ratio printed": table["ratio"][0] if ratio else math.nan,
                    "ratio of printed std": deviation / reference if ratio else math.nan,
                    "extreme printed [std]": max(high, -low) / deviation,
                    "extreme expected [std]": expected_extreme(len(log)),
                }
            )
    return pd.DataFrame(rows)


def expected_extreme(n: int) -> float:
    """Median of the largest of n normal deviations, whatever their sign."""
    from scipy.special import ndtri

    return float(ndtri(0.5 + 0.5 * 0.5 ** (1.0 / n)))


def _noise(sources: Sequence[Printed]) -> pd.DataFrame:
    import pandas as pd

    rows: list[dict[str, Any]] = []
    for source in sources:
        sheet, rate = _data_sheet(source.name)
        root = math.sqrt(source.bandwidth)
        for i, axis in enumerate(source.axes):
            density = float(source.density[i]) * MICRO_G
            rows.append(
                {
                    "sensor": source.name,
                    "axis": axis,
                    "density data sheet printed": sheet,
                    "density measured printed": density,
                    "std/√f_3dB": float(source.deviation[i]) * MICRO_G / root,
                    "rate data sheet printed [Hz]": rate,
                    "rate [Hz]": source.rate,
                    "f_3dB [Hz]": source.bandwidth,
                    "noise printed": TOTAL_NOISE[source.name],
                    "noise of data sheet": sheet * root,
                    "noise of measured": density * root,
                }
            )
    return pd.DataFrame(rows)


def _data_sheet(name: str) -> tuple[float, float]:
    """Density (µg/√Hz) and rate (Hz) in Table 5.2's columns of data sheets; nan if not printed."""
    for record in catalogue.find(name).records["accelerometer"]:
        if (record.source, record.origin) == ("thesis-table-5.2", "data sheet"):
            found = record.quantities
            density, rate = found.get("noise_density"), found.get("rate")
            return (
                parse(density, KINDS["acceleration noise density"]) * MICRO_G
                if density
                else math.nan,
                parse(rate, KINDS["frequency"]) if rate else math.nan,
            )
    return math.nan, math.nan


def remarks(extremes: pd.DataFrame, noise: pd.DataFrame) -> list[str]:
    """Where printed numbers contradict each other; computed from both tables."""
    return [*_of_extremes(extremes), *_of_noise(noise)]


def _of_extremes(table: pd.DataFrame) -> Iterator[str]:
    for _, row in table.iterrows():
        where = f"{row['sensor']} {row['axis']}"
        spread, sum_ = row["peak to peak printed"], row["from extremes"]
        if abs(spread - sum_) > _ROUNDING:
            yield f"{where}: peak to peak {spread:g} m/s², the printed extremes give {sum_:.5g}"
        if row["extreme printed [std]"] > _NOT_NORMAL:
            yield (
                f"{where}: its extreme is {row['extreme printed [std]']:.3g} printed deviations: "
                "spikes, or no normal noise"
            )
        ratio, own = row["ratio printed"], row["ratio of printed std"]
        if abs(ratio / own - 1.0) > _AGREES:
            yield f"{where}: ratio {ratio:g} to MTN-1100, the printed deviations give {own:.3g}"


def _of_noise(table: pd.DataFrame) -> Iterator[str]:
    for _, row in table[table["axis"].isin(["x"]) | (table["sensor"] == "MTN-1100")].iterrows():
        told = row["noise printed"]
        of = {"data sheet": row["noise of data sheet"], "measured": row["noise of measured"]}
        agrees = [key for key, value in of.items() if abs(value / told - 1.0) < _AGREES]
        if agrees != ["measured"] or row["sensor"] != "MTN-1100":
            source = f"that of the {agrees[0]} density" if agrees else "that of no printed density"
            yield f"{row['sensor']}: the noise {told:g} µg is {source}"
    yield from _of_densities(table)


def _of_densities(table: pd.DataFrame) -> Iterator[str]:
    """Measured densities against the deviations of Table 5.1, Eq. (5.1)."""
    for sensor, rows in table.groupby("sensor", sort=False):
        part = (rows["density measured printed"] / rows["std/√f_3dB"] - 1.0).to_numpy()
        if np.max(np.abs(part)) > _DENSITY_AGREES:
            told = ", ".join(f"{100.0 * value:+.0f}" for value in part)
            yield f"{sensor}: the measured densities differ from σ/√f_3dB by {told} %"


def _rows(table: pd.DataFrame, heads: Sequence[str]) -> list[list[str]]:
    rows = [["sensor", "axis", *heads]]
    rows += [[_cell(value) for value in row] for row in table.itertuples(index=False)]
    return rows


def _cell(value: Any) -> str:
    if isinstance(value, str):
        return value
    return "–" if math.isnan(value) else f"{value:.4g}"


TABLE = PaperTable(
    "stationary",
    "Stationary data of the vibration thesis (Tables 5.1 and 5.2 whole), printed and simulated.",
    stationary_data,
    files=("stationary", "noise"),
    settings=(Setting("duration", "20 s", metavar="'20 s'"), Setting("seed", 1, least=0)),
)
