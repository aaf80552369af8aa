"""What every check of a channel looks at, and what it returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.units import KINDS, in_unit

Array = NDArray[np.float64]

#: A log as short as this (s) tells nothing.
SHORTEST = 60.0


@dataclass(frozen=True)
class Finding:
    """Something found in a channel (or the whole log, channel ``""``), as a sentence."""

    kind: str
    channel: str
    text: str


@dataclass(frozen=True)
class Record:
    """A channel without isolated spikes: ``samples`` (n,) in SI units at ``rate`` Hz.

    ``resolution`` is the quantisation step that shows, None where none does; ``kind`` and ``unit``
    say how to write a value, ``where`` which file it is.
    """

    name: str
    samples: Array
    rate: float
    resolution: float | None
    kind: str
    unit: str
    where: str

    def written(self, value: float) -> str:
        """An SI value with its unit."""
        return f"{in_unit(value, self.unit, KINDS[self.kind]):.4g} {self.unit}"

    def seconds(self, samples: float) -> float:
        """Duration (s) of a number of samples."""
        return samples / self.rate


def quiet_part(begin: int, end: int, record: Record) -> str:
    """Advice to use what lies before or after samples ``begin`` to ``end``, if that is enough."""
    n = len(record.samples)
    before, after = record.seconds(begin), record.seconds(n - end)
    if max(before, after) < SHORTEST:
        return "; what is left is too short, log again"
    # Rounded into the quiet part.
    if before >= after:
        return f"; what lies before is left by --end {np.floor(before * 1e3) / 1e3:.10g} (s)"
    start = np.ceil(record.seconds(end) * 1e3) / 1e3
    return f"; what lies after is left by --start {start:.10g} (s)"
