"""When the samples of a drive are taken, what their stamps say, and what becomes of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsim.errors import InputError
from mcsim.logs.stamps import even_instants, read_stamps
from mcsim.scenario.sample_times import Intervals, SampleTimes, Stamps

Array = NDArray[np.float64]

#: Its names in budgets.
STAMPS = "time stamps"
#: Intervals (in sampling intervals) beyond which a stated rate cannot be meant.
_LEAST, _MOST = 0.5, 2.0
#: Losses in a row that practically no realization has, as a probability.
_NEVER = 1e-15


@dataclass(frozen=True, eq=False)
class Instants:
    """Instants (n + 1,) of the samples and their stamps, in s from the first.

    ``even`` tells that they are multiples of the nominal interval.
    """

    true: Array
    stamped: Array
    even: bool = False

    @property
    def last(self) -> int:
        """Number of the last sample."""
        return len(self.true) - 1


@dataclass(frozen=True, eq=False)
class Schedule:
    """Instants of the samples of a drive, and how stamps err beyond that.

    ``instants`` are None where they are even and known to be: multiples of ``interval`` (s), the
    nominal one.  ``times`` are the rest, ``nominal`` tells that integrators take one sampling
    interval for each sample that arrives.
    """

    instants: Instants | None
    interval: float
    times: SampleTimes
    nominal: bool

    @property
    def varies(self) -> bool:
        """Whether integrators have to read intervals."""
        return self.instants is not None

    def without_losses(self) -> Schedule:
        """The same where every sample arrives; what else varies still does."""
        return replace(self, times=self.times.model_copy(update={"lost": 0.0}))

    @property
    def ratios(self) -> Array:
        """Stamped intervals (n + 1,) before the samples, in sampling intervals; one at sample 0."""
        assert self.instants is not None
        return np.append(1.0, np.diff(self.instants.stamped) / self.interval)

    @property
    def longest(self) -> float:
        """The longest interval, in sampling intervals, that practically any realization has."""
        if not self.varies:
            return 1.0
        lost = self.times.lost
        losses = math.ceil(math.log(_NEVER) / math.log(lost)) if lost else 0
        jitter = math.hypot(self.times.interval_jitter, self.times.stamp_jitter) / self.interval
        widest = 1.0 if self.instants is None else float(np.max(self.ratios))
        return 1.0 if self.nominal else widest * (1 + losses) + 16.0 * jitter


def schedule_of(
    times: SampleTimes,
    intervals: Intervals,
    rate: float,
    duration: float,
    folder: Path,
    block: str = "sensors",
) -> Schedule:
    """The schedule of a drive that lasts ``duration`` (s); files are looked up in ``folder``.

    ``block`` is what the scenario calls the block of the sensors.

    Raises
    ------
    InputError
        Recorded stamps that cannot be read, are fewer than the drive needs, or say another rate.
    """
    instants = None
    if times.varies:
        given = times.stamps
        instants = (
            _even(rate, times.rate_error, duration)
            if given is None
            else _recorded(given, rate, duration, folder, block)
        )
    return Schedule(instants, 1.0 / rate, times, intervals == "nominal")


@lru_cache(maxsize=64)
def _even(rate: float, rate_error: float, duration: float) -> Instants:
    """Even instants within the drive; rounding of the duration is forgiven."""
    own = rate * (1.0 + rate_error)
    instants = np.arange(math.floor(duration * own * (1.0 + 1e-12) + 1e-9) + 1) / own
    return Instants(instants, instants, even=rate_error == 0.0)


@lru_cache(maxsize=64)
def _recorded(stamps: Stamps, rate: float, duration: float, folder: Path, block: str) -> Instants:
    """Recorded stamps, as far as the drive goes."""
    path = folder / stamps.file
    stamped = read_stamps(path, stamps.column, f"{block}.time.stamps.column")
    true = stamped
    if stamps.instants == "even":
        true, rows = even_instants(stamped, str(path))
        stamped = stamped[rows] - stamped[rows[0]]
    usual = float(np.median(np.diff(true))) * rate
    if not _LEAST < usual < _MOST:
        raise InputError(
            f"{path}: the stamps are usually {usual / rate:.4g} s apart, `{block}.rate: {rate:g} "
            "Hz` says another interval; correct the rate, or the unit of the column"
        )
    count = int(np.count_nonzero(true <= duration + 1e-9))
    if count == len(true) and true[-1] < duration - _MOST / rate:
        raise InputError(
            f"{path}: the stamps end after {true[-1]:.6g} s, the drive after {duration:.6g} s; "
            "use a longer log, or shorten the drive"
        )
    if count < 2:
        raise InputError(
            f"{path}: no second stamp within the drive of {duration:.4g} s; use a longer drive"
        )
    return Instants(true[:count], stamped[:count])
