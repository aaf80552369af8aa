"""Files inside the folder of a log, plain or packed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

_ENDINGS = ("", ".gz", ".xz")


def first_inside(folder: Path, names: Iterable[str]) -> Path | None:
    """The first of the files that the folder holds; None if it holds none."""
    for name in names:
        for ending in _ENDINGS:
            if (folder / f"{name}{ending}").is_file():
                return folder / f"{name}{ending}"
    return None
