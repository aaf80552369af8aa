"""Pictures of results: another one is a file with a ``Picture`` and a line here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mcsim.registry import Registry

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mcsim.results import Results


@dataclass(frozen=True)
class Picture:
    """One picture that a run leaves beside its tables, and ``mcsim plot`` draws again.

    Attributes
    ----------
    name : str
        Of its files, without ending.
    wants : callable
        ``wants(results) -> bool``: whether these results have what it shows.
    paint : callable
        ``paint(results) -> matplotlib.figure.Figure``.
    """

    name: str
    wants: Callable[[Results], bool]
    paint: Callable[[Results], Figure]


#: Drawing imports matplotlib; the names are known without it.
PICTURES: Registry[Picture] = Registry(
    "picture",
    later={
        "figure": "mcsim.figures.whole:PICTURE",
        "map": "mcsim.figures.maps:PICTURE",
        "tracks": "mcsim.figures.tracks:PICTURE",
    },
)
