"""A slow oscillation: a thermostat, a building that sways.

Lines below those that the channel's spectrum resolves are looked for in the periodogram of the
whole log, averaged over short windows first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.health.record import Finding, Record
from mcsim.characterisation.spectrum import (
    FIRST_BIN,
    Line,
    Spectrum,
    find_lines,
    resolution_of,
    spectrum_of,
)

Array = NDArray[np.float64]

#: Window means of a log at most, the fewest periods in it, and the factor between frequencies
#: that a floor is taken of: of so few a line must not be half.
_MEANS, _PERIODS, _NEIGHBOURHOOD = 1 << 14, 5, 2.5
#: A line must raise the Allan deviation by so much to be called an oscillation.
_RAISES = 0.05
#: The density of a line over the floor around it, in multiples of what chance makes of a known
#: floor: of a few frequencies the floor is known to a factor only.
_FLOOR_KNOWN = 2.5


def find_oscillations(samples: Array, rate: float) -> tuple[list[Line], Spectrum]:
    """Lines that a spectrum of shorter segments does not resolve, and the spectrum they are in."""
    size = -(-len(samples) // _MEANS)
    count = len(samples) // size
    means = samples[: count * size].reshape(count, size).mean(axis=1)
    slow = spectrum_of(means, rate / size, count, _NEIGHBOURHOOD)
    lines = find_lines(slow, _PERIODS - 1, _FLOOR_KNOWN)
    below = FIRST_BIN * resolution_of(len(samples), rate)
    return [x for x in lines if x.peak < below and x.raises > 1.0 + _RAISES], slow


def oscillation_finding(record: Record, line: Line) -> Finding:
    """A sentence about one of them."""
    return Finding(
        "oscillation",
        record.name,
        f"a slow oscillation of {record.written(np.sqrt(2.0) * line.deviation)} with a period of "
        f"about {1.0 / line.peak:.3g} s (thermostat, sway) raises the Allan deviation by up to "
        f"{line.raises - 1.0:.0%}, near {line.tau:.2g} s: that is no rest; the fit goes without it",
    )
