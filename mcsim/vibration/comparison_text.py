"""A comparison of sensors as a terminal shows it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from mcsim.text_table import columns
from mcsim.vibration.comparison import Comparison

if TYPE_CHECKING:
    import pandas as pd

#: What is shown of each table: the columns that there are of these, under these words.
_TABLE = {
    "sensor": "sensor",
    "rate [Hz]": "rate [Hz]",
    "bandwidth [Hz]": "bandwidth [Hz]",
    "band_from [Hz]": "filters −3 dB [Hz]",
    "band_to [Hz]": "to",
    "half_power_found [Hz]": "−3 dB found [Hz]",
    "snr_raw [dB]": "SNR raw [dB]",
    "snr_filtered [dB]": "filtered",
    "peak_raw [m/s^2]": "peak raw [m/s²]",
    "peak_filtered [m/s^2]": "filtered",
    "peak_filtered_from_truth [%]": "from truth [%]",
    "peak_filtered_from_reference [%]": "from reference [%]",
    "rms_raw [m/s^2]": "RMS raw [m/s²]",
    "rms_filtered [m/s^2]": "filtered",
    "rms_filtered_from_truth [%]": "from truth [%]",
    "rms_filtered_from_reference [%]": "from reference [%]",
    "lag [s]": "lag [s]",
}
_ORDERS = {
    "sensor": "sensor",
    "tone": "tone",
    "found [Hz]": "found [Hz]",
    "u_found [Hz]": "±",
    "frequency_from_truth [Hz]": "from truth [Hz]",
    "frequency_from_reference [Hz]": "from reference [Hz]",
    "amplitude [m/s^2]": "amplitude [m/s²]",
    "u_amplitude [m/s^2]": "±",
    "amplitude_from_truth [%]": "from truth [%]",
    "amplitude_from_reference [%]": "from reference [%]",
    "u_amplitude_from_reference [%]": "±",
    "gain": "gain of filters",
    "amplitude_filtered [m/s^2]": "filtered [m/s²]",
    "above_noise [dB]": "above noise [dB]",
    "stands_out": "stands out",
}
_TRAVEL = {
    "sensor": "sensor",
    "drift_removed_by": "drift removed by",
    "top_speed [m/s]": "top speed [m/s]",
    "top_speed_error [m/s]": "error",
    "speed_at_end [m/s]": "speed at the end [m/s]",
    "height [m]": "height [m]",
    "height_error [m]": "error",
    "u_height_of_white_noise [m]": "± of white noise",
}
#: Of a response every so many bands are shown.
_EVERY = 3
#: Frequencies are shown with more digits: they are what agrees.
_DIGITS = {"found [Hz]": 7}
#: What is less is the rounding of a zero.
_ROUNDING = 1e-12
_NAN = float("nan")
_DOMINANT = "*"


def comparison_text(found: Comparison) -> str:
    """Its tables, as far as a terminal is wide; the files hold all columns."""
    parts = [columns(_rows(found.table, _TABLE))]
    if found.orders is not None:
        marked = found.orders.copy()
        marked["tone"] += [_DOMINANT if d == "yes" else "" for d in marked["dominant"]]
        parts.append([*columns(_rows(marked, _ORDERS)), f"{_DOMINANT} the strongest; ± is k = 1"])
    if found.travel is not None:
        parts.append(columns(_rows(found.travel, _TRAVEL)))
    if found.response is not None:
        parts.append(["amplitude over the true one", *columns(_response(found.response))])
    return "\n\n".join("\n".join(lines) for lines in parts)


def _rows(table: pd.DataFrame, words: Mapping[str, str]) -> list[list[str]]:
    """A head and the rows, without columns that are empty for all."""
    shown = [key for key in words if key in table and not table[key].isna().all()]
    rows = [[words[key] for key in shown]]
    for _, row in table.iterrows():
        rows.append([_cell(row[key], _DIGITS.get(key, 4)) for key in shown])
    return rows


def _cell(value: Any, digits: int = 4) -> str:
    if isinstance(value, str):
        return value
    if value != value:
        return "–"
    return f"{value if abs(value) > _ROUNDING else 0.0:.{digits}g}"


def _response(table: pd.DataFrame) -> list[list[str]]:
    """Frequencies down, sensors across; what a sensor has nothing of is a dash."""
    keys = zip(table["frequency [Hz]"], table["sensor"], strict=True)
    gains = dict(zip(keys, table["gain"], strict=True))
    sensors = list(dict.fromkeys(table["sensor"]))

    def row(frequency: float) -> list[str]:
        return [_cell(frequency), *(_cell(gains.get((frequency, s), _NAN)) for s in sensors)]

    shown = sorted(set(table["frequency [Hz]"]))[::_EVERY]
    return [["frequency [Hz]", *sensors], *map(row, shown)]
