"""Output that is stuck at a value, or held for several samples.

A healthy output repeats a value by chance, where it is quantised: in runs whose lengths fall off
geometrically.  A run much longer than nearly all others is a stuck output.  More repeated values
than neighbouring ones (one step up or down), which a smooth density makes as frequent, are
held: the sensor is slower than the log, or rows are repeated.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcsim.characterisation.health.record import Finding, Record, quiet_part
from mcsim.errors import InputError

#: A run is stuck if it is at least so many samples and seconds long, and so many times as long
#: as 99 of 100 runs.
_LEAST_RUN, _LEAST_SECONDS, _TIMES = 20, 0.1, 8.0
#: Runs this long (99 of 100) are those of steps coarser than the noise, which may stay for long.
_COARSE_RUN = 12.0
#: Stuck for more than this part of the log is not what the rest can be told with.
_MOST = 0.005
#: The part of the samples that must be held, and the steps per deviation of differences above
#: which repeated values say nothing.
_HELD, _COARSE_STEP = 0.02, 1.0


def check_stuck(record: Record) -> list[Finding]:
    """Find runs of one value, and values that are held.

    Raises
    ------
    InputError
        The output is stuck for a considerable part of the log.
    """
    starts, lengths = _runs(record.samples)
    usual = float(np.quantile(lengths, 0.99))
    limit = max(_LEAST_RUN, _LEAST_SECONDS * record.rate, _TIMES * usual)
    if usual > _COARSE_RUN:
        limit *= usual / _COARSE_RUN
    long = lengths > limit
    found = []
    if np.any(long):
        found.append(_stuck(record, starts[long], lengths[long]))
    return found + _held(record, lengths[~long])


def _runs(samples: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First sample and length of every run of equal values; (r,) each."""
    starts = np.flatnonzero(np.append(True, samples[1:] != samples[:-1]))
    return starts, np.diff(np.append(starts, len(samples)))


def _stuck(record: Record, starts: NDArray[np.int64], lengths: NDArray[np.int64]) -> Finding:
    n, longest = len(record.samples), int(np.argmax(lengths))
    begin, end = int(starts[longest]), int(starts[longest] + lengths[longest])
    value = record.written(float(record.samples[begin]))
    part = float(lengths.sum()) / n
    until = "the end" if end == n else f"{record.seconds(end):.6g} s"
    told = f"stuck at {value} from {record.seconds(begin):.6g} s to {until}"
    more = f", and {len(lengths) - 1} times more" if len(lengths) > 1 else ""
    if part > _MOST:
        clear = _longest_clear(starts, starts + lengths, n)
        advice = _advice(clear, record)
        raise InputError(
            f"{record.where}: {record.name} is {told}{more}, {100.0 * part:.2g} % of the log: "
            f"that is no sensor's noise{advice}"
        )
    return Finding("stuck", record.name, f"the output is {told}{more}; it stays in the fit")


def _longest_clear(starts: NDArray[np.int64], ends: NDArray[np.int64], n: int) -> tuple[int, int]:
    """The longest stretch of samples without a stuck run."""
    begins, stops = np.append(0, ends), np.append(starts, n)
    longest = int(np.argmax(stops - begins))
    return int(begins[longest]), int(stops[longest])


def _advice(clear: tuple[int, int], record: Record) -> str:
    begin, end = clear
    n = len(record.samples)
    if begin == 0 or end == n:
        return quiet_part(end, n, record) if begin == 0 else quiet_part(0, begin, record)
    first, last = np.ceil(record.seconds(begin)), np.floor(record.seconds(end))
    if last - first < 60.0:
        return "; what is left is too short, log again"
    return f"; it lives from --start {first:.10g} to --end {last:.10g} (s)"


def _held(record: Record, lengths: NDArray[np.int64]) -> list[Finding]:
    steps = np.abs(np.diff(record.samples))
    moving = steps[steps > 0.0]
    if record.resolution is None:
        expected = 0.0
    else:
        step = record.resolution
        if step > _COARSE_STEP * float(np.std(moving)):
            return []
        # As many repeat as go one step up, or down; the density is highest where they repeat.
        expected = 0.75 * np.count_nonzero(moving < 1.5 * step)
    repeated = float((lengths - 1).sum())
    n = len(record.samples)
    if repeated - expected < _HELD * n:
        return []
    each = n / (n - (repeated - expected))
    return [
        Finding(
            "held",
            record.name,
            f"{(repeated - expected) / n:.0%} of the values repeat the one before them: the "
            f"sensor gives about {record.rate / each:.3g} new values a second, fewer than the "
            "log holds",
        )
    ]
