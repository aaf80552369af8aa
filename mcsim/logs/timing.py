"""Time stamps: their rate, gaps, duplicates and jitter; samples made equally spaced."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.logs.model import Array, Timing

_FEWEST = 3
#: An interval this many times the usual one is a gap.
_GAP = 1.75
#: Gaps are bridged when they miss fewer samples than this part of the log.
_BRIDGED = 1e-3
#: The longest unbroken stretch must be this part of the log.
_UNBROKEN = 0.5
#: More stamps that repeat than this part: the clock is coarser than the samples.
_REPEATED = 0.05
#: A stated rate may differ from the stamps by this part.
_RATE_TOLERANCE = 0.02
#: Rates beyond are those of a wrong unit of time (Hz), those in between may be.
LOWEST_RATE, HIGHEST_RATE = 0.01, 90_000.0
_LOWEST_USUAL, _HIGHEST_USUAL = 1.5, 20_000.0
#: Jitter above this part of the interval is worth a note.
_JITTER = 0.1


@dataclass(frozen=True)
class Spacing:
    """How to make samples equally spaced.

    ``rows`` are kept ones; when ``positions`` is not None, the kept rows stand at these
    multiples of the interval, and what lies between is interpolated.
    """

    timing: Timing
    rows: NDArray[np.int64]
    positions: NDArray[np.int64] | None = None

    def apply(self, samples: Array) -> Array:
        """Equally spaced samples of a channel (all rows of the file)."""
        kept = samples[self.rows]
        if self.positions is None:
            return kept
        every = np.arange(self.positions[-1] + 1)
        return np.interp(every, self.positions, kept)


def unstamped(rate: float, count: int) -> Spacing:
    """Spacing of a file without time stamps."""
    return Spacing(Timing(rate, stamped=False), np.arange(count))


def check_stamps(stamps: Array, stated_rate: float | None, where: str) -> Spacing:
    """Look at time stamps (n,) in s; decide what is kept.

    Raises
    ------
    InputError
        Stamps run backwards, are too coarse, miss too much, or contradict the stated rate.
    """
    if len(stamps) < _FEWEST:
        raise InputError(
            f"{where}: {len(stamps)} row{'s' * (len(stamps) != 1)}: too few for a rate; a static "
            "log of minutes, better hours, is needed"
        )
    steps = np.diff(stamps)
    if np.any(steps < 0.0):
        row = int(np.argmax(steps < 0.0))
        raise InputError(
            f"{where}: the time runs backwards by {-steps[row]:.6g} s after sample {row + 1}"
        )
    duplicates = int(np.count_nonzero(steps == 0.0))
    if duplicates > _REPEATED * len(stamps):
        raise InputError(
            f"{where}: {duplicates} of {len(stamps)} time stamps repeat the one before; the clock "
            "is too coarse for the samples: give --rate, and leave the time out with --columns"
        )
    rows = np.flatnonzero(np.concatenate([[True], steps > 0.0]))
    steps = np.diff(stamps[rows])
    step = float(np.median(steps))
    usual = steps[steps <= _GAP * step]
    step = float(usual.mean())
    rate = 1.0 / step
    _check_rate(rate, stated_rate, where)
    usual = steps[steps <= _GAP * step]
    jitter = float(usual.std() / step)
    notes = []
    if duplicates:
        notes.append(f"{duplicates} samples that repeat a time stamp were left out")
    if jitter > _JITTER:
        notes.append(
            f"the time stamps scatter by {jitter:.0%} of the interval; the samples are taken as "
            "equally spaced, as the sensor's own clock makes them"
        )
    gaps = np.flatnonzero(steps > _GAP * step)
    counts = np.maximum(np.round(steps / step), 1.0).astype(np.int64)
    missing = int(np.sum(counts[gaps] - 1))
    timing = Timing(rate, True, duplicates, missing, jitter, doubt=_doubt(rate, stated_rate))
    return _mend(timing, rows, gaps, counts, notes, where)


def _mend(
    timing: Timing,
    rows: NDArray[np.int64],
    gaps: NDArray[np.int64],
    counts: NDArray[np.int64],
    notes: list[str],
    where: str,
) -> Spacing:
    """Bridge a few missing samples; else keep the longest stretch without a gap."""
    positions = None
    if timing.missing:
        missing, told = timing.missing, f"{len(gaps)} gaps in the time stamps miss"
        if missing < _BRIDGED * len(rows):
            whole = np.ones(len(counts), np.int64)
            whole[gaps] = counts[gaps]
            positions = np.concatenate([[0], np.cumsum(whole)])
            notes.append(f"{told} {missing} samples ({missing / len(rows):.2g} of all): bridged")
        else:
            edges = np.concatenate([[0], gaps + 1, [len(rows)]])
            longest = int(np.argmax(np.diff(edges)))
            kept = rows[edges[longest] : edges[longest + 1]]
            if len(kept) < _UNBROKEN * len(rows):
                raise InputError(
                    f"{where}: {told} {missing} samples; the longest stretch without a gap is "
                    f"{len(kept) / timing.rate:.6g} s, less than half of the log. Log it anew, "
                    "or cut out a whole stretch with --start and --end"
                )
            notes.append(
                f"{told} {missing} samples; only the longest stretch without one is used, "
                f"{len(kept) / timing.rate:.6g} s from {kept[0] / timing.rate:.6g} s on"
            )
            rows = kept
    doubt = [timing.doubt] if timing.doubt else []
    return Spacing(replace(timing, notes=(*notes, *doubt)), rows, positions)


def _check_rate(rate: float, stated: float | None, where: str) -> None:
    if stated is not None and abs(rate / stated - 1.0) > _RATE_TOLERANCE:
        raise InputError(
            f"{where}: --rate says {stated:.6g} Hz, the time stamps say {rate:.6g} Hz"
            + (_other_unit(rate / stated) or "; correct one")
        )
    if not LOWEST_RATE <= rate <= HIGHEST_RATE:
        raise InputError(
            f"{where}: the time stamps say {rate:.6g} Hz, which no inertial sensor has; is their "
            "unit right? (--units time=s, ms, µs or ns states another than the header)"
        )


def _other_unit(ratio: float) -> str:
    """A hint where the stamps say a rate that is a power of a thousand times the true one."""
    for power in (1000.0, 1e6, 1e9):
        for times, size in ((ratio / power, "larger"), (ratio * power, "smaller")):
            if abs(times - 1.0) < _RATE_TOLERANCE:
                return (
                    f"; they agree if the unit of time is {power:.0f} times {size}: state it by "
                    "--units time=…"
                )
    return ""


def _doubt(rate: float, stated: float | None) -> str:
    """A sentence about a rate that is possible, but hardly an inertial sensor's."""
    if stated is not None or _LOWEST_USUAL <= rate <= _HIGHEST_USUAL:
        return ""
    power = "1000 times smaller" if rate < _LOWEST_USUAL else "1000 times larger"
    return (
        f"the time stamps say {rate:.4g} Hz, an unusual rate: if their unit is {power} than the "
        "header says, state it by --units time=…; if not, confirm the rate by --rate"
    )
