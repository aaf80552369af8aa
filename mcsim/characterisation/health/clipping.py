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
#: Levels that a coarse output must have, how many values must lie at the outermost (at least, and
#: as a share of the log), and by how many standard errors too many.
_LEVELS, _FEWEST_AT_A_LEVEL, _SHARE, _ERRORS = 5, 50.0, 2e-3, 5.0
#: Steps (of the deviation from sample to sample) from which on a slow wander shows at each level.
_COARSE_STEP = 1.2
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
    step = record.resolution
    deviation = float(np.std(np.diff(record.samples))) / np.sqrt(2.0)
    told_by_levels = step is not None and step < _COARSE_STEP * deviation
    rails = [
        (int(np.count_nonzero(ordered <= edge)), float(ordered[0]), "below")
        for edge in _rail(ordered, step, told_by_levels)
    ]
    rails += [
        (int(np.count_nonzero(-ordered <= edge)), float(ordered[-1]), "above")
        for edge in _rail(-ordered[::-1], step, told_by_levels)
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


def _rail(ordered: Array, step: float | None, told_by_levels: bool) -> list[float]:
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
    return _coarse_rail(ordered, step) if step is not None and told_by_levels else []


def _coarse_rail(ordered: Array, step: float) -> list[float]:
    """As above where the steps are too coarse for that: by the values at each level.

    The logarithm of their numbers bends downwards, c0 c2 < c1², unless values are piled up.
    """
    levels = np.round((ordered - ordered[0]) / step).astype(np.int64)
    counts = np.bincount(np.minimum(levels, 1000))
    if np.count_nonzero(counts) < _LEVELS:
        return []
    first, second, third = counts[:3].astype(float)
    if first < max(_FEWEST_AT_A_LEVEL, _SHARE * len(ordered)) or not (second and third):
        return []
    convexity = np.log(first * third / second**2)
    error = np.sqrt(1.0 / first + 4.0 / second + 1.0 / third)
    return [float(ordered[0] + 0.5 * step)] if convexity > _ERRORS * error else []
