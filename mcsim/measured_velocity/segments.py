"""Where a recorded run rests and where it moves: stated, or found by a rule that is told.

The rule: the record is still wherever means over a tenth of a second stay, for a whole stretch of
some seconds, within eight standard deviations that such means have in the rest.  A shorter
stretch without acceleration belongs to the motion: the vehicle drives at constant speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.measured_velocity.run_log import RecordedRuns

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Length of the means (s, samples) and how many of their deviations a still stretch spans.
MEAN_OF, _FEWEST, SPANS = 0.1, 5, 8.0
#: A stretch is still when it lasts so long (s) unless told otherwise.
STILL = 2.0
#: Output that moves by less than this (g) has not moved; what a rest may exceed the stillest by.
_ROUNDING, _UNSTEADY = 1e-9, 4.0
#: A rest needs so many samples, and so many at the end of a record count as still.
_LEAST_REST, _LEAST_END = 10, 4
SAMPLES = "samples"


@dataclass(frozen=True)
class Length:
    """A length of time (s), or a number of samples."""

    value: float
    samples: bool = False

    def until(self, time: Array, start: int) -> int:
        """Index of the stamp that ends it, from ``start`` on; beyond the last if it does."""
        if self.samples:
            return start + round(self.value)
        usual = 0.5 * float(np.median(np.diff(time)))
        return int(np.searchsorted(time, time[start] + self.value - usual))

    def __str__(self) -> str:
        return f"{self.value:g} {SAMPLES if self.samples else 's'}"


@dataclass(frozen=True)
class Segment:
    """One run within a record: the rest is [first, start), the motion has stamps start … end."""

    first: int
    start: int
    end: int


@dataclass(frozen=True)
class Rule:
    """How segments are told: lengths that are stated, else ``still`` seconds between motions."""

    rest: Length | None = None
    duration: Length | None = None
    still: float = STILL


def segments(record: RecordedRuns, rule: Rule, single: bool) -> tuple[list[Segment], str]:
    """The runs of a record, and how they were told, in words.

    ``single`` says that the record is of one run.

    Raises
    ------
    InputError
        The record does not begin at rest, nothing moves, or a stated length does not fit.
    """
    if rule.rest is None:
        found = _found(record, rule.still)
        if single and len(found) > 1:
            raise InputError(
                f"{record.name}: {len(found)} motions with rests of {rule.still:g} s and more "
                "between them, where one run is expected: raise --still beyond its longest drive "
                "at constant speed, or state --rest and --duration"
            )
        words = (
            f"rest and motion found: still where means over {MEAN_OF:g} s stay within "
            f"{SPANS:g} of their standard deviations for {rule.still:g} s or more"
        )
    else:
        start = rule.rest.until(record.time, 0)
        if not _LEAST_REST <= start < len(record.time) - 1:
            raise InputError(
                f"--rest {rule.rest}: {record.name} lasts {record.time[-1]:.6g} s "
                f"({len(record.time)} samples); the rest needs {_LEAST_REST} samples of it, and a "
                "motion behind"
            )
        found = [Segment(0, start, len(record.time) - 1)]
        words = f"rest as stated, the first {rule.rest}"
    if rule.duration is not None:
        return _lasting(record, found, rule.duration), f"{words}; motion of {rule.duration}"
    if rule.rest is not None:
        found, told = _until_still(record, found[0])
        words += told
    return found, words


def _lasting(record: RecordedRuns, found: list[Segment], duration: Length) -> list[Segment]:
    kept = []
    for n, segment in enumerate(found):
        end = duration.until(record.time, segment.start)
        last = found[n + 1].start if n + 1 < len(found) else len(record.time)
        if not segment.start < end < last:
            left = record.time[last - 1] - record.time[segment.start]
            raise InputError(
                f"--duration {duration}: {record.name} holds {left:.4g} s "
                f"({last - 1 - segment.start} samples) from the start of the motion on"
            )
        kept.append(Segment(segment.first, segment.start, end))
    return kept


def _until_still(record: RecordedRuns, segment: Segment) -> tuple[list[Segment], str]:
    """The motion ends where the record stays still; if it never does, with the record."""
    means, width = _means(record)
    limit = _limit(means[: segment.start], record.name)
    last = _last_change(means, limit, width)
    end = last + width // 2 + 1 if last is not None else len(record.time) - 1
    if not segment.start < end < len(record.time) - 1:
        return [segment], "; motion to the end of the record"
    return (
        [Segment(segment.first, segment.start, end)],
        f"; motion until means over {MEAN_OF:g} s stay within {SPANS:g} of their standard "
        "deviations to the end",
    )


def _means(record: RecordedRuns) -> tuple[Array, int]:
    """Means (n, 3) over a tenth of a second around every sample, and of how many samples."""
    from scipy.ndimage import uniform_filter1d

    interval = float(np.median(np.diff(record.time)))
    width = max(_FEWEST, round(MEAN_OF / interval))
    return uniform_filter1d(record.raw, width, axis=0, mode="nearest"), width


def _limit(rest: Array, name: str) -> Array:
    """How far means may spread (3,) where nothing moves."""
    limit: Array = SPANS * np.maximum(rest.std(axis=0), _ROUNDING)
    if np.any(np.ptp(rest, axis=0) > 1.5 * limit):
        raise InputError(f"{name}: the rest is not still; state where it ends, --rest '10 s'")
    return limit


def _still(means: Array, limit: Array, length: int) -> Flags:
    """Samples (n,) that lie in a stretch of ``length`` samples that is still."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    back = -(length // 2)
    high = maximum_filter1d(means, length, axis=0, origin=back, mode="nearest")
    low = minimum_filter1d(means, length, axis=0, origin=back, mode="nearest")
    begins = np.all(high - low <= limit, axis=1)
    begins[len(means) - length + 1 :] = False
    covered = np.cumsum(begins)
    return np.asarray(
        covered - np.concatenate([np.zeros(length, int), covered])[: len(covered)] > 0
    )


def _last_change(means: Array, limit: Array, width: int) -> int | None:
    """The last sample from which on the means are not all alike; None where there is no end."""
    high = np.maximum.accumulate(means[::-1])[::-1]
    low = np.minimum.accumulate(means[::-1])[::-1]
    quiet = np.all(high - low <= limit, axis=1)
    first = int(np.argmax(quiet))
    if len(means) - first < _LEAST_END * width or first == 0:
        return None
    return first


def _found(record: RecordedRuns, still: float) -> list[Segment]:
    """Runs between still stretches; each rest ends before the first sign of motion."""
    means, width = _means(record)
    length = round(still / float(np.median(np.diff(record.time))))
    if length < _LEAST_END * width or length > len(means) - width:
        raise InputError(
            f"{record.name}: --still {still:g} s: the record, of {record.time[-1]:.4g} s, must "
            f"begin with such a rest, and it must last {_LEAST_END * MEAN_OF:g} s at least"
        )
    _refuse_moving_start(record.name, means, length)
    at_rest = _still(means, _limit(means[:length], record.name), length)
    edges = np.flatnonzero(np.diff(at_rest.astype(int))) + 1
    found: list[Segment] = []
    first = 0
    for n in range(0, len(edges), 2):
        begin = int(edges[n])
        stop = int(edges[n + 1]) if n + 1 < len(edges) else len(means)
        # The means know of a change half their length before it; so much again for slow ones.
        half = width // 2 + 1
        start = max(begin - half, first + _LEAST_REST)
        end = min(stop + half, len(means) - 1)
        if n + 1 >= len(edges):
            last = _last_change(means, _limit(means[first:start], record.name), width)
            end = min(last + half, end) if last is not None else end
        found.append(Segment(first, start, end))
        first = end
    if not found:
        raise InputError(f"{record.name}: nothing moves in it; state --rest and --duration")
    return found


def _refuse_moving_start(name: str, means: Array, length: int) -> None:
    stillest = min(
        float(np.max(means[at : at + length].std(axis=0)))
        for at in range(0, len(means) - length + 1, max(length // 2, 1))
    )
    own = float(np.max(means[:length].std(axis=0)))
    if own > _UNSTEADY * max(stillest, _ROUNDING):
        raise InputError(
            f"{name}: it does not begin at rest; the tilt needs a rest before the motion: cut the "
            "file, or state --rest"
        )
