"""Tables as lines of text, for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd


def columns(rows: list[list[str]]) -> list[str]:
    """Lines with the cells of each column padded to the same width."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def frame_text(table: pd.DataFrame) -> str:
    """A table with its header, one line per row; what is missing is left blank."""
    rows = [list(map(str, table.columns))]
    rows += [
        ["" if value is None or value != value else _short(value) for value in row]
        for row in table.astype(object).where(table.notna(), None).itertuples(index=False)
    ]
    return "\n".join(columns(rows))


def _short(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)
