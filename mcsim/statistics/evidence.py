"""What the statistics of a point are estimated from: its realizations, and how sure to be."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mcsim.statistics.bca import student_sigmas
from mcsim.statistics.collector import Collector
from mcsim.statistics.moments import Moments, moments


@dataclass(frozen=True)
class Evidence:
    """The realizations of the errors ``rows`` (e,) of one point.

    ``sigmas`` is the confidence of two-sided intervals as a number of standard deviations,
    ``resamples`` the bootstrap's number, ``key`` (64 bit) that of its random numbers.
    """

    collector: Collector
    rows: NDArray[np.intp]
    sigmas: float
    resamples: int
    key: int

    @cached_property
    def moments(self) -> Moments:
        """Mean, deviation and RMS, worked out together."""
        collector, reach = self.collector, self.sigmas
        if collector.nets:
            reach = student_sigmas(self.sigmas, len(collector.sizes))
        return moments(collector, self.rows, reach, self.resamples, self.key)
