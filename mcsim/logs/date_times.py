"""Dates and times of day as time stamps: what loggers write where others count seconds.

ISO 8601 (``2023-05-01T10:00:00.010+02:00``, also with a blank), ``01.05.2023 10:00:00``,
``01-May-2023 10:00:00`` and a time of day alone.  ``05/01/2023`` is a different day here and
there, and is not read.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

#: What stands in place of a unit where a column holds dates and times, and its SI value.
DATE_AND_TIME, NANOSECOND = "date and time", 1e-9
EXAMPLE = "2023-05-01 10:00:00.010"

_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_CLOCK = r"(?P<h>[01]?\d|2[0-3]):(?P<m>[0-5]\d):(?P<s>[0-5]\d|60)(?:[.,](?P<f>\d{1,9}))?"
_ZONE = r"(?:\s?(?:Z|UTC|GMT|(?P<sign>[-+])(?P<zh>\d\d):?(?P<zm>\d\d)?))?"
_DATES = (
    r"(?P<year>\d{4})[-/.](?P<month>\d\d)[-/.](?P<day>\d\d)(?:T|[ _]+)",
    r"(?P<day>\d{1,2})\.(?P<month>\d{1,2})\.(?P<year>\d{4}),? +",
    rf"(?P<day>\d{{1,2}})-(?P<month>(?i:{'|'.join(_MONTHS)}))-(?P<year>\d{{4}}) +",
    "",
)
_WAYS = tuple(f"{date}{_CLOCK}{_ZONE}" for date in _DATES)


def nanoseconds(cells: Sequence[str | None]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Dates and times (n,) in ns, whole numbers, and which cells (n,) hold none.

    Times of day alone count from midnight.  All cells are read like the first one that is a time.
    """
    import pandas as pd

    texts = pd.Series(list(cells), dtype="object").fillna("").str.strip()
    bad = np.ones(len(texts), bool)
    for way in _WAYS:
        fitting = texts.str.fullmatch(way).to_numpy(bool)
        if np.any(fitting):
            bad = ~fitting
            break
    else:
        return np.zeros(len(texts), np.int64), bad
    parts = texts.where(~bad, "").str.extract(f"^{way}$")

    def whole(name: str) -> NDArray[np.int64]:
        return np.array(parts[name].fillna("0"), np.int64)

    stamps = (whole("h") * 60 + whole("m")) * 60 + whole("s")
    offset = whole("zh") * 60 + whole("zm")
    stamps -= 60 * np.where(parts["sign"] == "-", -offset, offset)
    if "year" in parts:
        named = {name: f"{i:02d}" for i, name in enumerate(_MONTHS, start=1)}
        month = parts["month"].str.lower().replace(named).str.zfill(2)
        days = parts["year"] + "-" + month + "-" + parts["day"].str.zfill(2)
        read = pd.to_datetime(days, format="%Y-%m-%d", errors="coerce")
        bad |= read.isna().to_numpy()
        stamps += read.fillna(pd.Timestamp(0)).to_numpy("datetime64[D]").astype(np.int64) * 86_400
    fraction = parts["f"].fillna("").str.ljust(9, "0").astype("int64").to_numpy()
    return np.asarray(stamps * 1_000_000_000 + fraction, np.int64), bad


def are_dates(cells: Sequence[str]) -> bool:
    """Whether all cells that hold something are dates and times, or times of day."""
    held = [cell for cell in cells if cell.strip()]
    return bool(held) and not np.any(nanoseconds(held)[1])
