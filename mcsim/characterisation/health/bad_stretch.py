"""Where in a log is the sensor not itself?  The longest stretch that is stuck, noisy or at a rail.

The log is cut into windows of a second.  A window is bad in which a channel repeats nearly all of
its values where it usually does not, in which its noise from sample to sample is twice or half the
usual one, or in which many of its values lie at an end of their range.  Bad windows that are close
to each other are one stretch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.logs.model import Log

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Windows: seconds, and the fewest samples.
_WINDOW, _FEWEST = 1.0, 50
#: Share of repeated values of a stuck window, and of a healthy log.
_STUCK, _HEALTHY = 0.9, 0.5
#: Variance from sample to sample over the median that is bad; one of 50 samples never is by chance.
_LOUDER = 4.0
#: Share of a window at the ends of the log's range that shows a rail.
_AT_RAIL = 0.1
#: Good windows between bad ones that do not part them.
_BETWEEN = 3


@dataclass(frozen=True)
class BadStretch:
    """From ``start`` to ``end`` (s); ``why`` in words, by channel."""

    start: float
    end: float
    why: str


def bad_stretch(log: Log) -> BadStretch | None:
    """The longest bad stretch of a log, None if there is none."""
    size = int(max(_WINDOW * log.rate, _FEWEST))
    flags = {
        (channel.name, kind): flag
        for channel in log.channels
        for kind, flag in _flags(channel.samples, size).items()
        if flag.any()
    }
    if not flags:
        return None
    begin, end = _longest(np.any(list(flags.values()), axis=0))
    why = ", ".join(f"{name} {kind}" for (name, kind), f in flags.items() if f[begin:end].any())
    seconds = size / log.rate
    return BadStretch(begin * seconds, min(end * seconds, log.duration), why)


def _flags(samples: Array, size: int) -> dict[str, Flags]:
    """What is bad in which window, each (w,)."""
    count = len(samples) // size
    windows = samples[: count * size].reshape(count, size)
    steps = np.diff(windows, axis=1)
    repeated = np.mean(steps == 0.0, axis=1)
    stuck = (repeated > _STUCK) & (np.median(repeated) < _HEALTHY)
    variance = np.mean(steps**2, axis=1)
    usual = float(np.median(variance[~stuck])) if np.any(~stuck) else 0.0
    noisy = variance > _LOUDER * usual
    quiet = (variance < usual / _LOUDER) & ~stuck
    ends = (windows == samples.min()) | (windows == samples.max())
    rail = (np.mean(ends, axis=1) > _AT_RAIL) & ~stuck
    if np.mean(rail) > 0.5:  # so coarse an output has ends everywhere
        rail[:] = False
    return {"stuck": stuck, "noisy": noisy, "too quiet": quiet, "at a rail": rail}


def _longest(bad: Flags) -> tuple[int, int]:
    """First and last but one window of the longest run, short gaps closed."""
    places = np.flatnonzero(bad)
    runs = np.split(places, np.flatnonzero(np.diff(places) > _BETWEEN + 1) + 1)
    longest = max(runs, key=lambda run: int(run[-1] - run[0]))
    return int(longest[0]), int(longest[-1]) + 1
