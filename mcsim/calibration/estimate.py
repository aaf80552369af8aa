"""A quantity with standard uncertainty and degrees of freedom."""

from __future__ import annotations

from dataclasses import dataclass

#: 95 % of a normal distribution lie within this many standard deviations.
NORMAL_FACTOR = 1.959963984540054
#: More degrees of freedom than these change no interval.
_MOST_FREEDOM = 1e9


@dataclass(frozen=True)
class Estimate:
    """A quantity with its standard uncertainty and effective degrees of freedom."""

    value: float
    uncertainty: float
    freedom: float

    @property
    def coverage_factor(self) -> float:
        """k of the 95 % interval ``value ± k uncertainty``, by Student's t."""
        from scipy.special import stdtrit

        return float(stdtrit(min(self.freedom, _MOST_FREEDOM), 0.975))

    @property
    def normal_uncertainty(self) -> float:
        """Deviation of the normal distribution whose 95 % interval is this one."""
        return self.uncertainty * self.coverage_factor / NORMAL_FACTOR
