"""Runs of a group side by side: corrected, levelled, integrated, aligned at the start of motion.

Averages need one axis of time.  Where no sample is lost, sample n of one run belongs to sample n
of another, as in the source; else all runs are taken to common instants, so that each keeps
its velocity there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mcsim.calibration.scatter import SampleScatter, sample_scatter
from mcsim.errors import InputError
from mcsim.measured_velocity.run_log import RecordedRuns
from mcsim.measured_velocity.segments import Segment

Array = NDArray[np.float64]

#: An interval this many times the usual one has lost samples, if it also leaves their scatter.
_LOST, _OF_SCATTER = 1.8, 6.0
#: So many samples of a rest, the last ones, tell the noise.
_NOISE_FROM = 20_000
#: Usual intervals of runs that are averaged sample by sample differ by no more than this part.
_SAME_RATE = 0.02
#: Below this lag-one correlation neighbouring intervals take back each other's errors.
STAMPS_BELOW = -0.25
#: A spread below this part of the interval is that of rounding.
_REGULAR = 1e-9


@dataclass(frozen=True)
class Run:
    """One run: raw output (n, 3) at its n steps (fractions of g), n + 1 stamps from its start (s).

    ``begin`` is the start within its record (s), ``rest`` (r, 3) are the samples before; ``lost``
    counts samples missing while moving.
    """

    name: str
    begin: float
    rest: Array
    raw: Array
    time: Array
    reference: Array | None
    lost: int


@dataclass(frozen=True)
class TimeBase:
    """What the stamps tell: usual interval (s), its standard uncertainty, correlation of
    neighbours, and how many intervals say so.

    ``resolution`` (s) is that of the stamps as they were read.
    """

    interval: float
    deviation: float
    correlation: float
    count: int
    resolution: float = 0.0

    @property
    def exact(self) -> bool:
        """Whether the intervals differ by rounding alone: of their errors they tell nothing."""
        return self.deviation <= max(_REGULAR * self.interval, self.resolution)


@dataclass(frozen=True)
class Group:
    """M runs on one axis of time, until the shortest ends.

    ``time`` (n + 1,) in s after the start of motion, ``raw`` (M, n, 3) and ``intervals`` (M, n) at
    the steps, ``rests`` (M, 3) the mean outputs at rest, of ``rest_samples`` (M,); ``reference``
    (M, n + 1) in m/s.  ``alignment`` says how the axis was made.  ``begins``, ``lengths`` (s) and
    ``steps`` are the runs' own; ``lost`` counts samples missing while moving.
    """

    names: tuple[str, ...]
    time: Array
    raw: Array
    intervals: Array
    rests: Array
    rest_samples: NDArray[np.int64]
    reference: Array | None
    scatter: SampleScatter
    time_base: TimeBase
    alignment: Literal["samples", "time"]
    begins: tuple[float, ...]
    lengths: tuple[float, ...]
    steps: tuple[int, ...]
    lost: int

    @property
    def runs(self) -> int:
        return len(self.names)


def run_of(record: RecordedRuns, segment: Segment, name: str) -> Run:
    """The run that a segment of a record is."""
    first, start, end = segment.first, segment.start, segment.end
    time = record.time[start : end + 1]
    intervals = np.diff(record.time[first : end + 1])
    gaps = np.diff(time)[_has_lost(np.diff(time), intervals)]
    return Run(
        name=name,
        begin=float(time[0]),
        rest=record.raw[first:start],
        raw=record.raw[start:end],
        time=time - time[0],
        reference=None if record.reference is None else record.reference[start : end + 1],
        lost=int(np.sum(np.round(gaps / np.median(intervals)) - 1.0)),
    )


def _has_lost(intervals: Array, usual: Array) -> NDArray[np.bool_]:
    middle = float(np.median(usual))
    spread = 1.4826 * float(np.median(np.abs(usual - middle)))
    return np.asarray(intervals > max(_LOST * middle, middle + _OF_SCATTER * spread))


def time_base(records: Sequence[Array], resolution: float = 0.0) -> TimeBase:
    """What the stamps (n,) of all records tell of their intervals; gaps are left out.

    ``resolution`` (s) is that of the stamps as they were read.
    """
    intervals = [np.diff(time) for time in records]
    whole = [i[~_has_lost(i, i)] for i in intervals]
    means = [float(i.mean()) for i in whole]
    centred = [i - mean for i, mean in zip(whole, means, strict=True)]
    count = sum(map(len, whole))
    squares = sum(float(c @ c) for c in centred)
    products = sum(float(c[1:] @ c[:-1]) for c in centred)
    return TimeBase(
        float(np.average(means, weights=[len(i) for i in whole])),
        float(np.sqrt(squares / max(count - len(whole), 1))),
        products / squares if squares > 0.0 else 0.0,
        count,
        resolution,
    )


def group_of(
    runs: Sequence[Run], base: TimeBase, align: Literal["auto", "samples", "time"] = "auto"
) -> Group:
    """Put runs side by side.

    Raises
    ------
    InputError
        No noise can be told from the rests.
    """
    scatter = sample_scatter([run.rest[-_NOISE_FROM:] for run in runs])
    if scatter is None:
        raise InputError(f"{runs[0].name}: the rest has a single sample")
    lost = sum(run.lost for run in runs)
    by_samples = align == "samples" or (align == "auto" and lost == 0 and _alike(runs, base))
    n = min(len(run.raw) for run in runs)
    if by_samples:
        time = np.asarray(np.mean([run.time[: n + 1] for run in runs], axis=0), float)
        raw = np.array([run.raw[:n] for run in runs])
        intervals = np.array([np.diff(run.time[: n + 1]) for run in runs])
    else:
        n = int(min(run.time[-1] for run in runs) / base.interval * (1.0 + 1e-9))
        time = np.asarray(np.arange(n + 1) * base.interval, float)
        raw = np.array([_resampled(run, time) for run in runs])
        intervals = np.broadcast_to(np.diff(time), raw.shape[:2])
    given = [run.reference for run in runs]
    reference = None
    if all(r is not None for r in given):
        reference = np.array(
            [
                r[: n + 1] if by_samples else np.interp(time, run.time, r)
                for run, r in zip(runs, given, strict=True)
                if r is not None
            ]
        )
    return Group(
        names=tuple(run.name for run in runs),
        time=time,
        raw=raw,
        intervals=intervals,
        rests=np.array([run.rest.mean(axis=0) for run in runs]),
        rest_samples=np.array([len(run.rest) for run in runs]),
        reference=reference,
        scatter=scatter,
        time_base=base,
        alignment="samples" if by_samples else "time",
        begins=tuple(run.begin for run in runs),
        lengths=tuple(float(run.time[-1]) for run in runs),
        steps=tuple(len(run.raw) for run in runs),
        lost=lost,
    )


def _alike(runs: Sequence[Run], base: TimeBase) -> bool:
    """Whether all runs have the same rate, as far as their jittering intervals tell."""
    means = np.array([run.time[-1] / len(run.raw) for run in runs])
    shortest = min(len(run.raw) for run in runs)
    jitter = _OF_SCATTER * base.deviation / np.sqrt(shortest)
    return bool(np.ptp(means) <= max(_SAME_RATE * base.interval, jitter))


def _resampled(run: Run, time: Array) -> Array:
    """Mean output (n, 3) between common instants, so that its integral stays what it was."""
    steps = run.raw * np.diff(run.time)[:, None]
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    at = np.column_stack([np.interp(time, run.time, s) for s in sums.T])
    return np.asarray(np.diff(at, axis=0) / np.diff(time)[:, None])
