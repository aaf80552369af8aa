"""Output that saturates: values pile up at an end of their range.

The density of noise falls towards the ends, so that the outermost k values need more room than the
next k.  At a rail they need next to none.  Steps of quantisation, and a rail that is one or two of
them wide, are allowed for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.health.record import Finding, Record
from mcsim.errors import InputError

Array = NDArray[np.float64]

#: Outermost values that are looked at: the fewest, and their growth.
_FEWEST, _GROWTH = 12, 1.5
#: Room of the outermost values, as a part of that of the next as many, that shows a rail.
_CROWDED = 0.2
#: Levels that a coarse output must have, and by how many standard errors more values must lie
#: at the outermost than at the next one.
_LEVELS, _ERRORS = 5, 5.0
#: Beyond this part of the samples at a rail nothing that is fitted is the sensor's.
_MOST = 0.005


def check_clipping(record: Record) -> list[Finding]:
    """Find rails.

    Raises
    ------
    InputError
        A considerable part of the samples is at a rail.
    """
    ordered = np.sort(record.samples)
    rails = [
        (int(np.count_nonzero(ordered <= edge)), float(ordered[0]), "below")
        for edge in _rail(ordered, record.resolution)
    ]
    rails += [
        (int(np.count_nonzero(-ordered <= edge)), float(ordered[-1]), "above")
        for edge in _rail(-ordered[::-1], record.resolution)
    ]
    if not rails:
        return []
    part = sum(count for count, _, _ in rails) / len(ordered)
    told = " and ".join(
        f"{100.0 * count / len(ordered):.2g} % of the samples at {record.written(value)}, "
        f"none {side}"
        for count, value, side in rails
    )
    if part > _MOST:
        raise InputError(
            f"{record.where}: {record.name} saturates: {told}; its noise is larger than what is "
            "left of it. Log again with a larger range or less offset, or leave this channel out "
            "(--columns)"
        )
    return [Finding("saturates", record.name, f"saturates: {told}; N may be too small")]


def _rail(ordered: Array, step: float | None) -> list[float]:
    """The upper edge of a rail at the lower end of ascending values (n,), if there is one."""
    n, k = len(ordered), _FEWEST
    width = step or 0.0
    found = []
    while 2 * k < n:
        room, next_room = ordered[k - 1] - ordered[0], ordered[2 * k - 1] - ordered[k - 1]
        if room + width < _CROWDED * next_room:
            found.append(float(ordered[k - 1]))
        k = int(np.ceil(_GROWTH * k))
    if found:
        return found[-1:]
    return _coarse_rail(ordered, step) if step is not None else []


def _coarse_rail(ordered: Array, step: float) -> list[float]:
    """As above where the steps are too coarse for that: by the values at each level."""
    levels = np.round((ordered - ordered[0]) / step).astype(np.int64)
    counts = np.bincount(np.minimum(levels, 1000))
    if np.count_nonzero(counts) < _LEVELS:
        return []
    first, second = float(counts[0]), float(counts[1])
    if first - second > _ERRORS * np.sqrt(first + second) and first > _FEWEST:
        return [float(ordered[0] + 0.5 * step)]
    return []
